# The programs, run as a user would: from a capture to frames.
revisit_test(revisit_app_tests WHOLE LABELS programs TIMEOUT 600
    SOURCES app/program.cpp app/walk_test.cpp
    LINKS nlohmann_json::nlohmann_json opencv_core opencv_imgcodecs)
target_compile_definitions(revisit_app_tests PRIVATE REVISIT_PROGRAM="$<TARGET_FILE:revisit>"
    REVISIT_MAKE_SAMPLE="$<TARGET_FILE:make_sample>")
target_include_directories(revisit_app_tests SYSTEM PRIVATE ${OpenCV_INCLUDE_DIRS})
add_dependencies(revisit_app_tests revisit make_sample)
