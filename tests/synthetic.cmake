# Tests of the synthetic scenes: against their own equations, on one thread and on two.
add_executable(revisit_synthetic_tests scene/synthetic_test.cpp)
target_link_libraries(revisit_synthetic_tests PRIVATE scene revisit_flags TBB::tbb GTest::gtest_main)
gtest_discover_tests(revisit_synthetic_tests DISCOVERY_TIMEOUT 60)
