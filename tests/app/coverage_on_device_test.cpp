// How finely coverage is brought to devices.

#include "app/coverage_on_device.h"

#include "render/post/coverage_texels.h"
#include "scene/coverage_levels.h"
#include "tests/scene/random_coverage.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace app {

namespace {

constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max();

/// All that was observed lies in a corner, a 64th of the cube wide: the finer the cells, the more voxels.
scene::Coverage cornerOfACube() {
    const scene::Coverage part = scene::randomCoverage(5, 4);
    scene::Coverage whole{part.cornerInWorld, 64 * part.edgeMetres, {}};
    for (std::uint32_t above = 0; above < 3; ++above)
        whole.nodes.push_back({.unseen = ~std::uint64_t{1}, .children = 1, .firstChild = above + 1});
    for (scene::CoverageNode node : part.nodes) {
        if (node.children != 0) node.firstChild += 3;
        whole.nodes.push_back(node);
    }
    return whole;
}

class CoverageForms : public testing::Test {
  protected:
    CoverageForm formOf(std::size_t mostTexels, const CoverageWish& wish) const {
        return app::formOf(coverage_, mostTexels, wish);
    }
    std::size_t bytesOf(int levels) const { return sizes_.at(static_cast<std::size_t>(levels)).bytes(); }

    const scene::Coverage coverage_ = scene::randomCoverage(21, 6, 0.3, 0.15);
    const std::vector<render::CoverageSize> sizes_ = render::coverageSizesByLevels(coverage_);
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
    EXPECT_EQ(coarsest.levels, render::kFewestLevels);
    EXPECT_EQ(coarsest.bytes, bytesOf(render::kFewestLevels));
}

TEST(CoverageFormOfACorner, IsAsFineAsShadersCanRead) {
    const scene::Coverage coverage = cornerOfACube();
    const std::vector<render::CoverageSize> sizes = render::coverageSizesByLevels(coverage);
    ASSERT_EQ(sizes.size(), 8u);
    ASSERT_LT(sizes[5].mostTexels(), sizes[6].mostTexels());
    // They are three buffers: none of them has all the texels there are.
    const render::CoverageTexels made = render::coverageTexels(coverage);
    EXPECT_EQ(sizes[7].mostTexels(), std::max(made.words.size(), made.bricks.size()));
    const CoverageWish all{.mostBytes = kNoLimit, .whyNoMore = "asked"};
    EXPECT_EQ(formOf(coverage, sizes[7].mostTexels(), all).levels, 7);
    const CoverageForm form = formOf(coverage, sizes[6].mostTexels() - 1, all);
    EXPECT_EQ(form.levels, 5);
    EXPECT_NE(form.why.find("shaders"), std::string::npos) << form.why;
    // Where the share is what is small, it is not the device's fault.
    const CoverageWish little{.mostBytes = sizes[4].bytes(), .whyNoMore = "asked"};
    EXPECT_EQ(formOf(coverage, sizes[6].mostTexels() - 1, little).why, "asked");
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
