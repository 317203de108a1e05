# Tests of input/: the processor alone.
revisit_test(revisit_input_tests WHOLE LABELS unit LINKS input nlohmann_json::nlohmann_json
    SOURCES input/bindings_test.cpp input/locomotion_properties_test.cpp input/locomotion_test.cpp input/path_test.cpp input/rig_test.cpp
        input/settings_test.cpp)
