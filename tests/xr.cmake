# Headsets without a headset: Monado, an OpenXR runtime whose head and hands tests steer (cmake/get_monado.sh).
add_library(revisit_monado STATIC xr/monado.cpp xr/remote_head.cpp)
target_compile_definitions(revisit_monado PRIVATE REVISIT_MONADO="${REVISIT_DEPS}/monado")
target_include_directories(revisit_monado PUBLIC ${CMAKE_SOURCE_DIR})
target_link_libraries(revisit_monado PUBLIC scene GTest::gtest PRIVATE revisit_flags)

# Headset, runtime and swapchains by themselves.
revisit_test(revisit_headset_tests LABELS gpu LINKS revisit_monado render xr
    SOURCES xr/headset_rig.cpp xr/headset_test.cpp)

# The walk in a headset, run as a user would.
revisit_program_test(revisit_headset_walk_tests LABELS data programs TIMEOUT 400
    SOURCES app/comparison.cpp app/program.cpp app/sample_scene.cpp app/walker.cpp xr/headset_walk_test.cpp)
target_link_libraries(revisit_headset_walk_tests PRIVATE revisit_monado scene)

# What may happen on the way.
revisit_program_test(revisit_headset_world_tests LABELS programs TIMEOUT 300
    SOURCES app/comparison.cpp app/program.cpp app/sample_scene.cpp app/walker.cpp xr/runtime_dies_test.cpp)
target_link_libraries(revisit_headset_world_tests PRIVATE revisit_monado scene)
