# Scan import and projection: everything that is known of E57, PTX and the faces of the cube.
find_package(GTest REQUIRED)
include(GoogleTest)

add_executable(revisit_scan_tests
    ${CMAKE_CURRENT_LIST_DIR}/scene/import/e57_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/scene/import/e57_damage_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/scene/import/ptx_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/scene/import/scan_samples_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/scene/import/written_e57.cpp
    ${CMAKE_CURRENT_LIST_DIR}/scene/project/cube_faces_test.cpp)
target_link_libraries(revisit_scan_tests PRIVATE scene_import scene_project revisit_flags revisit_e57format
    TBB::tbb opencv_core opencv_imgcodecs
    GTest::gtest_main)
target_compile_definitions(revisit_scan_tests PRIVATE REVISIT_SHARED_DATA="${CMAKE_SOURCE_DIR}/../shared/data")
gtest_discover_tests(revisit_scan_tests DISCOVERY_TIMEOUT 60)
