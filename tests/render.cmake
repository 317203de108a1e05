# Tests and benchmarks of render/. They draw on whatever device there is; without a graphics card that is lavapipe.
find_package(GTest REQUIRED)
find_package(benchmark REQUIRED)

add_library(revisit_render_scenes STATIC render/test_scenes.cpp)
target_link_libraries(revisit_render_scenes PUBLIC render PRIVATE revisit_flags)
