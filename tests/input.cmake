# Tests of input/: the processor alone.
revisit_test(revisit_input_tests LABELS unit LINKS input
    SOURCES input/bindings_test.cpp input/locomotion_test.cpp input/rig_test.cpp)
