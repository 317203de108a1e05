// Figures of long runs: exact while they are short, near enough when they are not.

#include "app/spread.h"

#include <gtest/gtest.h>

namespace app {

namespace {

/// The numbers from 1 to count, each once, in no order.
Spread mixed(std::uint64_t count) {
    Spread spread;
    constexpr std::uint64_t kPrime = 7919; // has no divisor with the counts below in common
    for (std::uint64_t i = 0; i < count; ++i)
        spread.add(static_cast<double>(i * kPrime % count + 1));
    return spread;
}

TEST(Spread, IsExactOfFew) {
    const nlohmann::json spread = mixed(1000).toJson();
    EXPECT_EQ(spread.at("median"), 500);
    EXPECT_EQ(spread.at("p95"), 950);
    EXPECT_EQ(spread.at("p99"), 990);
    EXPECT_EQ(spread.at("max"), 1000);
    EXPECT_TRUE(Spread().toJson().is_null());
}

TEST(Spread, IsNearOfManyAndKnowsTheGreatest) {
    constexpr double kCount = 1000000;
    for (const bool isRising : {false, true}) {
        Spread spread = isRising ? Spread() : mixed(static_cast<std::uint64_t>(kCount));
        for (double value = 1; isRising && value <= kCount; ++value)
            spread.add(value);
        const nlohmann::json figures = spread.toJson();
        EXPECT_NEAR(figures.at("median").get<double>() / kCount, 0.5, 0.025);
        EXPECT_NEAR(figures.at("p95").get<double>() / kCount, 0.95, 0.0103);
        EXPECT_NEAR(figures.at("p99").get<double>() / kCount, 0.99, 0.005);
        EXPECT_EQ(figures.at("max"), kCount);
    }
}

TEST(Spread, OfNegativesIsNegative) {
    Spread spread;
    spread.add(-3);
    spread.add(-5);
    EXPECT_EQ(spread.toJson().at("max"), -3);
}

} // namespace

} // namespace app
