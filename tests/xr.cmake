# The headset through a real runtime: Monado, its head and controllers steered by the test (tests/xr/monado.h).
add_library(revisit_monado STATIC xr/monado.cpp xr/remote_head.cpp)
target_include_directories(revisit_monado PUBLIC ${CMAKE_SOURCE_DIR})
target_link_libraries(revisit_monado PUBLIC scene PRIVATE revisit_flags)
target_compile_definitions(revisit_monado PRIVATE REVISIT_MONADO="${REVISIT_DEPS}/monado")

revisit_program_test(revisit_headset_tests LABELS programs TIMEOUT 300
    SOURCES app/comparison.cpp app/program.cpp xr/headset_test.cpp)
target_link_libraries(revisit_headset_tests PRIVATE revisit_monado)

# In this process, frame by frame.
revisit_test(revisit_controllers_tests LABELS programs LINKS app revisit_monado nlohmann_json::nlohmann_json
    SOURCES app/program.cpp xr/controllers_test.cpp)
target_compile_definitions(revisit_controllers_tests PRIVATE REVISIT_PROGRAM="$<TARGET_FILE:revisit>"
    REVISIT_MAKE_SAMPLE="$<TARGET_FILE:make_sample>")
add_dependencies(revisit_controllers_tests revisit make_sample)
