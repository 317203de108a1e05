# Tests and benchmarks of render/. They draw on whatever device there is; without a graphics card that is lavapipe.
add_library(revisit_render_scenes STATIC render/test_scenes.cpp)
target_link_libraries(revisit_render_scenes PUBLIC render PRIVATE revisit_flags)

revisit_test(revisit_render_tests WHOLE LABELS gpu TIMEOUT 600 LINKS revisit_render_scenes TBB::tbb PkgConfig::HWY
    SOURCES
        render/adaptive_test.cpp
        render/blend_test.cpp
        render/device_test.cpp
        render/draw_list_test.cpp
        render/draw_order_test.cpp
        render/stream_test.cpp
        render/card_test.cpp render/edge_cases_test.cpp
        render/extremes_test.cpp
        render/hole_fill_test.cpp
        render/hole_words_test.cpp
        render/occluders_test.cpp
        render/mark_test.cpp
        render/mesh_test.cpp
        render/oracle_test.cpp
        render/overlay_test.cpp
        render/points_test.cpp
        render/polygons_test.cpp
        render/reference.cpp
        render/output_test.cpp
        render/rescale_test.cpp
        render/selection_test.cpp
        render/shared_math_test.cpp
        render/sample_place_test.cpp
        render/splats_test.cpp
        render/standing_test.cpp
        render/stereo_test.cpp
        render/studio.cpp
        render/test_device.cpp
        render/visibility_test.cpp)

# Where nobody looked, against the geometry itself.
revisit_test(revisit_unseen_tests LABELS gpu TIMEOUT 1200
    LINKS revisit_render_scenes scene_project scene_refine TBB::tbb
    SOURCES
        render/behind_unseen_test.cpp
        render/test_device.cpp
        render/unseen_test.cpp
        render/unseen_truth_test.cpp
        render/unseen_walk_test.cpp)

revisit_shader(bare_scatter.comp kBareScatterCode ${CMAKE_CURRENT_SOURCE_DIR}/bench/shaders)
revisit_bench(revisit_render_bench LINKS revisit_render_scenes scene_project scene_refine TBB::tbb
    SOURCES
        bench/bare_scatter.cpp
        bench/large_scene_bench.cpp
        bench/panorama_bench.cpp
        bench/render_bench.cpp
        bench/triangles_bench.cpp
        ${CMAKE_CURRENT_BINARY_DIR}/spirv/bare_scatter.comp.h)
target_include_directories(revisit_render_bench PRIVATE ${CMAKE_CURRENT_BINARY_DIR})
