# Scan import and projection: everything that is known of E57, PTX and the faces of the cube.
revisit_test(revisit_scan_tests LABELS unit TIMEOUT 300
    SOURCES
        scene/import/e57_test.cpp
        scene/import/e57_damage_test.cpp
        scene/import/picture_codec_test.cpp
        scene/import/ptx_test.cpp
        scene/import/scan_photos_test.cpp
        scene/import/scan_samples_test.cpp
        scene/import/written_e57.cpp
        scene/project/cube_faces_test.cpp
        scene/project/open_sky_test.cpp
    LINKS scene_import scene_pictures scene_project revisit_e57format TBB::tbb opencv_core opencv_imgcodecs
        PkgConfig::SPNG)
