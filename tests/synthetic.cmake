# Synthetic scenes: against their own equations, on one thread and on two.
revisit_test(revisit_synthetic_tests WHOLE LABELS scenes TIMEOUT 600
    SOURCES scene/synthetic_test.cpp
    LINKS scene TBB::tbb)
