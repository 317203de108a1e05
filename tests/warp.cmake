# Tests and benchmarks of the warp on the processor.
revisit_test(revisit_warp_tests WHOLE LABELS unit LINKS scene TBB::tbb PkgConfig::HWY
    SOURCES scene/blend_test.cpp scene/confidence_test.cpp scene/known_scenes.cpp scene/warp_points_test.cpp)

revisit_bench(revisit_warp_bench LINKS scene TBB::tbb PkgConfig::HWY SOURCES bench/bare_warp.cpp bench/warp_bench.cpp)
