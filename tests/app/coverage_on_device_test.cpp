// How finely coverage is brought to devices.

#include "app/coverage_on_device.h"

#include "render/post/coverage_texels.h"
#include "scene/coverage_levels.h"
#include "tests/scene/random_coverage.h"

#include <gtest/gtest.h>

#include <limits>

namespace app {

namespace {

constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max();

class CoverageForms : public testing::Test {
  protected:
    CoverageForm formOf(std::size_t mostTexels, const CoverageWish& wish) const {
        return app::formOf(coverage_, mostTexels, wish);
    }
    std::size_t bytesOf(int levels) const { return bytes_.at(static_cast<std::size_t>(levels)); }

    const scene::Coverage coverage_ = scene::randomCoverage(21, 6, 0.3, 0.15);
    const std::vector<std::size_t> bytes_ = render::coverageBytesByLevels(coverage_);
};

TEST_F(CoverageForms, AllOfItWhereThereIsRoom) {
    const CoverageForm form = formOf(kNoLimit, {.mostBytes = bytesOf(6), .whyNoMore = "asked"});
    EXPECT_EQ(form.wished, 6);
    EXPECT_EQ(form.levels, 6);
    EXPECT_EQ(form.bytes, bytesOf(6));
    EXPECT_EQ(form.why, "");
}

TEST_F(CoverageForms, AsFineAsItsShareAllowsAndAtLeastTheCoarsest) {
    ASSERT_LT(bytesOf(5), bytesOf(6));
    ASSERT_LT(bytesOf(4), bytesOf(5));
    const CoverageForm finer = formOf(kNoLimit, {.mostBytes = bytesOf(6) - 1, .whyNoMore = "asked"});
    EXPECT_EQ(finer.wished, 6);
    EXPECT_EQ(finer.levels, 5);
    EXPECT_EQ(finer.bytes, bytesOf(5));
    EXPECT_EQ(finer.why, "asked");
    const CoverageForm coarsest = formOf(kNoLimit, {.mostBytes = 0, .whyNoMore = "asked"});
    EXPECT_EQ(coarsest.levels, render::kLeastVoxelLevel);
    EXPECT_EQ(coarsest.bytes, bytesOf(render::kLeastVoxelLevel));
}

TEST_F(CoverageForms, AsFineAsShadersCanRead) {
    const CoverageForm form =
        formOf(bytesOf(6) / sizeof(render::CoveragePair) - 1, {.mostBytes = bytesOf(6), .whyNoMore = "asked"});
    EXPECT_EQ(form.levels, 5);
    EXPECT_NE(form.why.find("shaders"), std::string::npos) << form.why;
    // Where the share is what is small, it is not the device's fault.
    EXPECT_EQ(
        formOf(bytesOf(6) / sizeof(render::CoveragePair) - 1, {.mostBytes = bytesOf(4), .whyNoMore = "asked"}).why,
        "asked");
}

TEST_F(CoverageForms, NoFinerThanWished) {
    const double between = 1.01 * scene::cellOfLevels(coverage_, 5);
    const CoverageForm form =
        formOf(kNoLimit, {.leastCellMetres = between, .mostBytes = bytesOf(6), .whyNoMore = "asked"});
    EXPECT_EQ(form.wished, 4);
    EXPECT_EQ(form.levels, 4);
    EXPECT_EQ(form.why, "") << "it is what was wished";
}

} // namespace

} // namespace app
