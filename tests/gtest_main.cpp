// The main of all test programs: every test starts from the same seed, whichever others ran before it.

#include <cstdio>
#include <cstdlib>

#include <gtest/gtest.h>

namespace {

constexpr unsigned kSeed = 20;

class SeedEachTest : public testing::EmptyTestEventListener {
    void OnTestProgramStart(const testing::UnitTest&) override { std::printf("std::rand starts at %u\n", kSeed); }
    void OnTestStart(const testing::TestInfo&) override { std::srand(kSeed); }
};

} // namespace

int main(int argc, char** argv) {
    testing::InitGoogleTest(&argc, argv);
    testing::UnitTest::GetInstance()->listeners().Append(new SeedEachTest); // GoogleTest owns it from here
    return RUN_ALL_TESTS();
}
