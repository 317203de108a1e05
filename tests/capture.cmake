# Polygon scenes: read, lit and looked at, against what is known of them; and built by the program.
revisit_test(revisit_capture_tests WHOLE LABELS unit TIMEOUT 300
    SOURCES
        scene/capture/cube_capture_test.cpp
        scene/capture/free_space_test.cpp
        scene/capture/light_test.cpp
        scene/capture/polygon_view_test.cpp
        scene/capture/scanner_model_test.cpp
        scene/capture/simulated_camera_test.cpp
        scene/capture/simulated_scan_test.cpp
        scene/capture/spread_positions_test.cpp
        scene/capture/texture_pyramid_test.cpp
        scene/capture/tracer_test.cpp
        scene/import/camera_file_test.cpp
        scene/import/polygons_test.cpp
    LINKS scene_capture scene_project TBB::tbb opencv_core opencv_imgcodecs)
