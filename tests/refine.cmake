# Tests of what stands between import and plan: the warp on the processor, comparing images, refine, dropouts.
revisit_test(revisit_refine_tests WHOLE LABELS unit TIMEOUT 300 LINKS scene scene_project scene_refine TBB::tbb PkgConfig::HWY
    SOURCES
        scene/density_test.cpp
        scene/footprint_test.cpp
        scene/known_scenes.cpp
        scene/pick_test.cpp
        scene/preference_test.cpp
        scene/samples_about_test.cpp
        scene/upright_test.cpp
        scene/project/dropouts_test.cpp
        scene/refine/colour_evening_test.cpp
        scene/refine/contradiction_test.cpp
        scene/refine/cover_test.cpp
        scene/refine/crossing_test.cpp
        scene/refine/open_space_test.cpp
        scene/refine/fusion_test.cpp
        scene/overlap_test.cpp
        scene/refine/patch_cost_test.cpp
        scene/refine/redundancy_test.cpp
        scene/refine/skins_test.cpp
        scene/reprojection_test.cpp
        scene/sample_comparison_test.cpp
        scene/warp_test.cpp)

# By themselves, since sanitized they take as long as all of the above.
revisit_test(revisit_silhouette_tests WHOLE LABELS unit TIMEOUT 300 LINKS scene scene_refine TBB::tbb
    SOURCES scene/known_scenes.cpp scene/refine/silhouettes_test.cpp)

# What the build reads and keeps: its own depth images, and captures made of pictures.
revisit_test(revisit_picture_tests WHOLE LABELS unit TIMEOUT 300
    LINKS scene scene_import TIFF::TIFF PkgConfig::XXHASH nlohmann_json::nlohmann_json opencv_core opencv_imgcodecs
    SOURCES
        scene/coverage_test.cpp
        scene/depth_tiff_test.cpp
        scene/image_store_test.cpp
        scene/import/photo_test.cpp
        scene/import/transforms_json_test.cpp
        scene/import/tum_rgbd_test.cpp
        scene/scene_file_test.cpp
        scene/open_ways_test.cpp)
