# Walk cells.
revisit_test(revisit_plan_tests WHOLE LABELS unit LINKS scene scene_plan
    SOURCES scene/plan/simplex_test.cpp scene/plan/walk_cells_test.cpp)
revisit_test(revisit_position_search_tests LABELS scenes TIMEOUT 600 LINKS scene scene_plan TBB::tbb
    SOURCES scene/plan/known_sites.cpp scene/plan/position_search_test.cpp scene/plan/sight_search_test.cpp)
revisit_test(revisit_next_scan_tests LABELS scenes TIMEOUT 600 LINKS scene scene_plan scene_project scene_refine
    SOURCES scene/plan/next_scan_test.cpp)
revisit_bench(revisit_plan_bench LINKS scene_plan CGAL::CGAL SOURCES bench/plan_bench.cpp)

# Where positions stand and what is then unknown, what scenes built there are measured against, and the article's own
# set-up (docs/building.md, docs/performance.md); run by hand, for minutes.
add_library(revisit_captured_cube STATIC bench/captured_cube.cpp)
target_include_directories(revisit_captured_cube PUBLIC ${CMAKE_SOURCE_DIR})
target_link_libraries(revisit_captured_cube PUBLIC scene_capture scene_refine PRIVATE revisit_flags)
foreach(study position_study polygon_truth paper_setup cell_points)
    add_executable(revisit_${study} bench/${study}.cpp)
    target_include_directories(revisit_${study} SYSTEM PRIVATE ${OpenCV_INCLUDE_DIRS})
    target_link_libraries(revisit_${study} PRIVATE revisit_flags revisit_captured_cube scene_plan TBB::tbb
        nlohmann_json::nlohmann_json opencv_core opencv_imgcodecs opencv_imgproc)
endforeach()
target_sources(revisit_position_study PRIVATE bench/position_pictures.cpp)
target_sources(revisit_cell_points PRIVATE bench/position_pictures.cpp)
target_link_libraries(revisit_paper_setup PRIVATE render)
