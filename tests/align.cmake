# Registration of scans.
revisit_test(revisit_align_tests LABELS scenes TIMEOUT 300 LINKS scene_align scene_capture TBB::tbb
    SOURCES scene/align/registration_test.cpp scene/align/scan_groups_test.cpp scene/align/scan_planes_test.cpp
        scene/align/scanner_calibration_test.cpp)

# Cameras from boards.
revisit_test(revisit_board_tests LABELS unit TIMEOUT 300
    LINKS scene_align opencv_core opencv_imgproc opencv_imgcodecs opencv_calib3d
    SOURCES scene/align/camera_calibration_test.cpp)
target_include_directories(revisit_board_tests SYSTEM PRIVATE ${OpenCV_INCLUDE_DIRS})

# Photographs against each other.
revisit_test(revisit_turn_tests WHOLE LABELS unit LINKS scene_align Eigen3::Eigen
    SOURCES scene/align/lost_scans_test.cpp scene/align/neighbour_turn_test.cpp scene/align/normal_equations_test.cpp scene/align/pair_record_test.cpp
        scene/align/turn_network_test.cpp)

# Photographs with range against each other.
revisit_test(revisit_joint_images_tests WHOLE LABELS unit TIMEOUT 300 LINKS scene_align scene_refine TBB::tbb
    SOURCES scene/align/joint_images_test.cpp scene/known_scenes.cpp)

# Photographs laid on scans, and what scattered samples become in a camera.
revisit_test(revisit_photographs_tests LABELS scenes TIMEOUT 300 WHOLE LINKS scene_capture scene_project TBB::tbb
    SOURCES scene/align/colour_to_range_test.cpp scene/project/planar_projection_test.cpp)

# How exact and how sure registration is, over many seeds (docs/building.md); run by hand, for minutes.
add_executable(revisit_registration_study bench/registration_study.cpp)
target_include_directories(revisit_registration_study PRIVATE ${CMAKE_SOURCE_DIR})
target_link_libraries(revisit_registration_study PRIVATE revisit_flags scene_align scene_capture
    nlohmann_json::nlohmann_json)

# How exactly the constants of a scanner are found; the same.
add_executable(revisit_calibration_study bench/calibration_study.cpp)
target_include_directories(revisit_calibration_study PRIVATE ${CMAKE_SOURCE_DIR})
target_link_libraries(revisit_calibration_study PRIVATE revisit_flags scene_align scene_capture
    nlohmann_json::nlohmann_json)

# The same of photographs against their scans (docs/building.md).
add_executable(revisit_colour_study bench/colour_study.cpp)
target_include_directories(revisit_colour_study PRIVATE ${CMAKE_SOURCE_DIR})
target_include_directories(revisit_colour_study SYSTEM PRIVATE ${OpenCV_INCLUDE_DIRS})
target_link_libraries(revisit_colour_study PRIVATE revisit_flags scene_align scene_capture scene_project
    nlohmann_json::nlohmann_json opencv_core opencv_imgcodecs)
