// What options of the command line let through.

#include "app/real_range.h"

#include <gtest/gtest.h>

namespace app {

namespace {

int statusOf(const std::string& value) {
    CLI::App cli;
    double number = 0;
    cli.add_option("--number", number)->check(realRange(0.5, 100));
    try {
        cli.parse("--number " + value);
    } catch (const CLI::ParseError& error) {
        return error.get_exit_code();
    }
    return 0;
}

TEST(RealRange, LetsThroughWhatLiesInIt) {
    for (const char* right : {"0.5", "1", "1e2", "100"})
        EXPECT_EQ(statusOf(right), 0) << right;
    for (const char* wrong : {"0.49", "100.1", "-1", "inf", "-inf", "nan", "NaN", "-nan", "one", "1m"})
        EXPECT_NE(statusOf(wrong), 0) << wrong;
}

} // namespace

} // namespace app
