// The walk through coverage: shared code on the processor against the tree itself.

#include "render/post/coverage_texels.h"
#include "scene/coverage.h"
#include "scene/coverage_levels.h"
#include "scene/coverage_ray.h"
#include "tests/render/test_scenes.h"
#include "tests/render/tree_texels.h"
#include "tests/scene/random_coverage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace render {
namespace {

using Texels = TreeTexels;

/// Some of a site of 16 x 16 x 16 cubes, in one floor; nobody saw the rest. levels: of all.
scene::Coverage flatSite(std::uint32_t seed, int levels, double unseenShare, double dividedShare = 0.3) {
    const scene::Coverage part = scene::randomCoverage(seed, levels - 2, unseenShare, dividedShare);
    return coverageManyTimes(part, {{5, 7, 3}, {6, 7, 3}, {8, 9, 3}}, {-40, 12, 7}, 2);
}

/// Three of 64 x 64 x 64 cubes, side by side at the rim: voxels and bricks are as fine as they ever are.
scene::Coverage farSite(std::uint32_t seed, int levels, double unseenShare, double dividedShare = 0.3) {
    const scene::Coverage part = scene::randomCoverage(seed, levels - 3, unseenShare, dividedShare);
    return coverageManyTimes(part, {{0, 5, 63}, {1, 5, 63}, {2, 5, 63}}, {-40, 12, 7}, 3);
}
const glm::dvec3 kFarLeast = glm::dvec3(0, 5, 63) / 64.0, kFarMost = glm::dvec3(3, 6, 64) / 64.0;

/// Of places between two of the cube's.
void expectToFindTheCells(const scene::Coverage& coverage, const glm::dvec3& least, const glm::dvec3& most) {
    const int levels = scene::levelsOf(coverage);
    const Texels texels(coverage);
    std::mt19937 random(2);
    const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0; };
    const auto place = [&] {
        const double x = uniform(), y = uniform(), z = uniform();
        return least + (most - least) * glm::dvec3(x, y, z);
    };
    const float size = texels.grid().size;
    const bool hasBricksWithin = std::pow(4.0f, static_cast<float>(levels)) > 4 * size;
    const auto isDivided = [&](const glm::dvec3& p) {
        return unseenCellAt(texels, vec3(p)).voxel * size < (hasBricksWithin ? 0.25f : 1.0f);
    };
    int unseen = 0, divided = 0;
    for (int i = 0; i < 20000; ++i) {
        glm::dvec3 p = place();
        // Half of them where the tree goes on below the voxels, which is a small part of space.
        for (int k = 0; i % 2 == 0 && k < 100000 && !isDivided(p); ++k)
            p = place();
        divided += isDivided(p) ? 1 : 0;
        const bool isUnseen =
            scene::observedAt(coverage, coverage.cornerInWorld + coverage.edgeMetres * p) == scene::Observed::unseen;
        unseen += isUnseen ? 1 : 0;
        // At a face between two cells single precision may choose the other one.
        const double cells = std::pow(4.0, levels);
        const glm::dvec3 inFinest = p * cells - glm::floor(p * cells);
        if (std::min({inFinest.x, inFinest.y, inFinest.z}) < 1e-3 ||
            std::max({inFinest.x, inFinest.y, inFinest.z}) > 1 - 1e-3)
            continue;
        ASSERT_EQ(unseenCellAt(texels, vec3(p)).isUnseen, isUnseen) << p.x << " " << p.y << " " << p.z;
    }
    EXPECT_GT(unseen, 4000);
    EXPECT_GT(divided, 9000);
}

TEST(UnseenWalk, FindsTheCellsOfTheTree) {
    // Bricks within bricks within bricks.
    expectToFindTheCells(scene::randomCoverage(1, 6, 0.3, 0.15), glm::dvec3(0), glm::dvec3(1));
}

TEST(UnseenWalk, FindsTheCellsOfAFlatSite) {
    const scene::Coverage site = flatSite(1, 6, 0.3, 0.15);
    expectToFindTheCells(site, glm::dvec3(5, 7, 3) / 16.0, glm::dvec3(9, 10, 4) / 16.0);
    const UnseenGrid grid = Texels(site).grid();
    EXPECT_EQ(grid.size, 1024) << "a level finer than if it took up the cube";
    EXPECT_LE(grid.count.x * grid.count.y * grid.count.z, static_cast<float>(kMostVoxels));
    EXPECT_LT(grid.count.z, 67);
    for (int axis = 0; axis < 3; ++axis) {
        // A voxel more on each side, in which nothing was observed.
        EXPECT_LE(grid.first[axis], 64.0f * vec3(5, 7, 3)[axis] - 1);
        EXPECT_GE(grid.first[axis] + grid.count[axis], 64.0f * vec3(9, 10, 4)[axis] + 1);
    }
    // As fine as the tree, and no finer.
    EXPECT_EQ(Texels(flatSite(1, 5, 0.3)).grid().size, 1024);
    EXPECT_TRUE(coverageTexels(flatSite(1, 5, 0.3)).bricks.empty());
    EXPECT_EQ(Texels(flatSite(1, 4, 0.3)).grid().size, 256);
}

TEST(UnseenWalk, FindsTheCellsOfASmallSiteInALargeCube) {
    const scene::Coverage site = farSite(2, 7, 0.3, 0.15);
    expectToFindTheCells(site, kFarLeast, kFarMost);
    const UnseenGrid grid = Texels(site).grid();
    EXPECT_EQ(grid.size, 1024);
    EXPECT_EQ(grid.first, vec3(0, 5 * 16 - 1, 63 * 16 - 1));
    EXPECT_EQ(grid.first.z + grid.count.z, 1024) << "there is no more of the cube";
}

TEST(UnseenWalk, VoxelsAreNoFinerThanIsOfUse) {
    scene::Coverage coverage = scene::randomCoverage(1, 6, 0.3, 0.15);
    for (const auto& [edgeMetres, across] :
         {std::pair{5.7, 64}, {12.7, 64}, {12.9, 256}, {51.3, 1024}, {900.0, 1024}}) {
        coverage.edgeMetres = edgeMetres;
        const UnseenGrid grid = coverageTexels(coverage).grid;
        // Of a whole cube there are too many of the finest.
        EXPECT_EQ(grid.size, std::min(across, 256)) << edgeMetres;
    }
}

TEST(UnseenWalk, AWideSiteHasNoMoreVoxelsThanARayTakesSteps) {
    std::vector<std::array<int, 3>> places;
    for (int i = 2; i < 53; ++i)
        places.push_back({i, i, 9});
    const scene::Coverage site = coverageManyTimes(scene::randomCoverage(3, 3, 0.3), places, glm::dvec3(0), 3);
    const Texels texels(site);
    const UnseenGrid grid = texels.grid();
    EXPECT_EQ(grid.size, 256) << "there was room for finer ones";
    EXPECT_LE(grid.count.x + grid.count.y + grid.count.z, static_cast<float>(kMostVoxelsOnARay));
    // From behind its end all along beside it, where nobody looked: the depth is that of where the cube ends.
    const double per = 1.0 / 64;
    const glm::dvec3 from = glm::dvec3(61, 59, 9.5) * per;
    const UnseenHit hit = walkToUnseen(texels, vec3(from), vec3(-per, -per, 0), 58.0f, kRayInfinity, vec2(0.0f));
    EXPECT_TRUE(hit.isUnseen);
    EXPECT_EQ(hit.depth, kRayInfinity);
}

TEST(UnseenWalk, WhereNothingWasObservedAllIsUnseen) {
    scene::Coverage coverage{glm::dvec3(1, 2, 3), 4, std::vector<scene::CoverageNode>(1)};
    coverage.nodes[0].unseen = ~std::uint64_t{0};
    const Texels texels(coverage);
    for (const float x : {0.01f, 0.4f, 0.99f}) {
        const UnseenHit hit = walkToUnseen(texels, vec3(x, 0.3f, 0.6f), vec3(0.25f, 0.01f, 0.02f), 0.5f, 3, vec2(0.0f));
        EXPECT_TRUE(hit.isUnseen);
        EXPECT_EQ(hit.depth, 3);
        const UnseenHit atOnce = walkToUnseen(texels, vec3(x, 0.3f, 0.6f), vec3(0.25f, 0.01f, 0.02f), 0, 3, vec2(0.0f));
        EXPECT_TRUE(atOnce.isUnseen);
        EXPECT_EQ(atOnce.depth, 0);
    }
}

/// The first unseen point on a ray in steps far smaller than the cells; asked of the tree itself.
double firstUnseenBySteps(const scene::Coverage& coverage, const glm::dvec3& eye, const glm::dvec3& direction,
                          double end) {
    for (double t = 0; t < end; t += 2e-4) {
        const glm::dvec3 p = coverage.cornerInWorld + coverage.edgeMetres * (eye + t * direction);
        const auto cell = cellAt(coverage, p);
        if (!cell) return end;
        if (cell->observed == scene::Observed::unseen) return t;
    }
    return end;
}

TEST(UnseenWalk, StopsWhereTheRayEntersTheUnseen) {
    const scene::Coverage coverage = scene::randomCoverage(3, 3, 0.08);
    const Texels texels(coverage);
    std::mt19937 random(4);
    const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0; };
    int met = 0, differ = 0;
    for (int i = 0; i < 1000; ++i) {
        const glm::dvec3 eye(uniform(), uniform(), uniform());
        const glm::dvec3 direction(uniform() - 0.5, uniform() - 0.5, uniform() - 0.5);
        const double end = uniform();
        const double expected = firstUnseenBySteps(coverage, eye, direction, end);
        const UnseenHit hit =
            walkToUnseen(texels, vec3(eye), vec3(direction), 0.0f, static_cast<float>(end), vec2(0.0f));
        met += hit.isUnseen ? 1 : 0;
        // Steps may pass over the corner of a cell that the walk finds.
        if (hit.isUnseen != (expected < end) || (hit.isUnseen && std::abs(double{hit.depth} - expected) > 5e-4))
            ++differ;
    }
    EXPECT_GT(met, 300);
    EXPECT_LT(met, 950);
    EXPECT_LE(differ, 10);
}

// The walker's hand meets what the eye is shown.
void expectToBeThatOfRays(const scene::Coverage& coverage, const glm::dvec3& middle, double around) {
    const Texels texels(coverage);
    std::mt19937 random(7);
    const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0; };
    int met = 0, differ = 0;
    for (int i = 0; i < 4000; ++i) {
        const double x = uniform(), y = uniform(), z = uniform();
        const glm::dvec3 eye = middle + around * (2.0 * glm::dvec3(x, y, z) - 1.0); // half of them outside
        const glm::dvec3 unit = glm::normalize(glm::dvec3(uniform() - 0.5, uniform() - 0.5, uniform() - 0.5));
        const double end = 8 * uniform(), pocket = i % 2 == 0 ? 0 : uniform();
        const auto found =
            scene::firstUnseen(coverage, coverage.cornerInWorld + coverage.edgeMetres * eye, unit, end, pocket);
        const UnseenHit hit = walkToUnseen(texels, vec3(eye), vec3(unit / coverage.edgeMetres),
                                           static_cast<float>(pocket), static_cast<float>(end), vec2(0.0f));
        met += hit.isUnseen ? 1 : 0;
        // In single precision a ray may pass a corner on the other side.
        if (hit.isUnseen != found.has_value() || (found && std::abs(double{hit.depth} - *found) > 1e-3)) ++differ;
    }
    EXPECT_GT(met, 1000);
    EXPECT_LT(met, 3900);
    EXPECT_LE(differ, 8);
}

TEST(UnseenWalk, IsThatOfRaysInDoublePrecision) {
    expectToBeThatOfRays(scene::randomCoverage(3, 3, 0.08), glm::dvec3(0.5), 1);
}

TEST(UnseenWalk, IsThatOfRaysAtAFlatSite) {
    const glm::dvec3 middle = glm::dvec3(6, 7.5, 3.5) / 16.0;
    expectToBeThatOfRays(flatSite(3, 5, 0.08), middle, 1.2 / 16);
    expectToBeThatOfRays(flatSite(3, 6, 0.08), middle, 1.2 / 16);
    // Half of the eyes stand beyond the cube's rim.
    expectToBeThatOfRays(farSite(3, 6, 0.08), 0.5 * (kFarLeast + kFarMost), 1.6 / 64);
    expectToBeThatOfRays(farSite(3, 7, 0.08), 0.5 * (kFarLeast + kFarMost), 1.6 / 64);
}

/// A cube of 4 m, unseen where x < 1 and where x > 3.
scene::Coverage openBetweenOneAndThree() {
    scene::Coverage coverage;
    coverage.edgeMetres = 4;
    coverage.nodes.resize(1);
    for (int bit = 0; bit < 64; ++bit)
        if (bit % 4 == 0 || bit % 4 == 3) coverage.nodes[0].unseen |= scene::coverageMask(bit);
    return coverage;
}

TEST(UnseenWalk, AnEyeInThePocketLooksThroughIt) {
    const Texels texels(openBetweenOneAndThree());
    const auto walk = [&](double x, float pocket, float end) {
        return walkToUnseen(texels, vec3(static_cast<float>(x) / 4, 0.6f, 0.6f), vec3(0.25f, 0.001f, 0.002f), pocket,
                            end, vec2(0.0f));
    };
    EXPECT_TRUE(walk(0.5, 0, kRayInfinity).isUnseen);
    EXPECT_FLOAT_EQ(walk(0.5, 0, kRayInfinity).depth, 0);
    EXPECT_NEAR(walk(0.5, 1, kRayInfinity).depth, 2.5f, 1e-3f) << "looked through to the other side";
    EXPECT_FALSE(walk(0.5, 1, 2).isUnseen);
    EXPECT_NEAR(walk(0.5, 0.3f, kRayInfinity).depth, 0.5f, 1e-3f) << "too deep: shown where it ends";
    EXPECT_TRUE(walk(0.5, 0.3f, 0.4f).isUnseen);
    EXPECT_FALSE(walk(0.5, 0.3f, 0.2f).isUnseen);
    EXPECT_NEAR(walk(1.5, 0, kRayInfinity).depth, 1.5f, 1e-3f);
    EXPECT_NEAR(walk(1.5, 1, kRayInfinity).depth, 1.5f, 1e-3f) << "an eye in seen space has no pocket";
    EXPECT_NEAR(walk(-0.5, 2, kRayInfinity).depth, 3.5f, 1e-3f) << "from without";
    EXPECT_TRUE(walk(-3, 2, kRayInfinity).isUnseen);
    EXPECT_TRUE(walk(5, 2, kRayInfinity).isUnseen) << "away from all that is known";
    EXPECT_FALSE(walk(5, 2, 1).isUnseen);
}

TEST(UnseenWalk, WhatIsDrawnWithinAnOpenStretchHidesWhatIsBehindIt) {
    const Texels texels(openBetweenOneAndThree());
    const vec3 eye(0.225f, 0.6f, 0.6f), ahead(0.25f, 0.001f, 0.002f), aside(0.0f, 1e-4f, 0.0f), down(0.0f, 0.0f, 1e-4f);
    const vec2 open = openStretch(texels, eye, ahead, aside, down, kRayInfinity);
    EXPECT_NEAR(open.x, 0.12f, 0.02f) << "behind what the eye stands in";
    EXPECT_NEAR(open.y, 2.1f, 1e-3f);
    for (const float end : {0.2f, 1.0f, 2.0f})
        EXPECT_FALSE(walkToUnseen(texels, eye, ahead, 1.0f, end, open).isUnseen) << end;
    EXPECT_NEAR(walkToUnseen(texels, eye, ahead, 1.0f, kRayInfinity, open).depth, 2.1f, 1e-3f);
}

constexpr int kMostAsked = 8;

/// So many rings of open voxels are about one, itself the first, at most kMostAsked: asked of the tree itself. Outside
/// of the cube there are none.
int ringsAbout(const scene::Coverage& coverage, const std::array<int, 3>& at, int across) {
    const double edge = coverage.edgeMetres / across;
    const auto isOpen = [&](int x, int y, int z) {
        const glm::dvec3 low = coverage.cornerInWorld + edge * glm::dvec3(x, y, z);
        const std::array<double, 3> volumes = scene::volumesOf(coverage, low + 1e-6 * edge, low + (1 - 1e-6) * edge);
        return cellAt(coverage, low + 0.5 * edge) && volumes[static_cast<std::size_t>(scene::Observed::unseen)] == 0;
    };
    int rings = 0;
    for (bool isAllOpen = true; isAllOpen && rings < kMostAsked; rings += isAllOpen ? 1 : 0)
        for (int z = -rings; z <= rings; ++z)
            for (int y = -rings; y <= rings; ++y)
                for (int x = -rings; x <= rings; ++x)
                    if (std::max({std::abs(x), std::abs(y), std::abs(z)}) == rings)
                        isAllOpen = isAllOpen && isOpen(at[0] + x, at[1] + y, at[2] + z);
    return rings;
}

struct CellsAsked {
    int wide = 0, ofBricks = 0, within = 0, pairs = 0, ofGrid = 0; ///< within: of bricks in bricks
};

/// What is told to be open about places is as wide as it is said to be; the trees have two levels below the grid's.
void expectRingsOf(const scene::Coverage& coverage, int across, int places, CellsAsked& asked) {
    const Texels texels(coverage);
    const UnseenGrid grid = texels.grid();
    ASSERT_EQ(grid.size, across);
    ASSERT_EQ(texels.made.brickLevels, 2u);
    std::mt19937 random(6);
    const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0; };
    for (int i = 0; i < places; ++i) {
        const double x = uniform(), y = uniform(), z = uniform();
        const vec3 p((glm::dvec3(grid.first) + glm::dvec3(grid.count) * glm::dvec3(x, y, z)) / double(across));
        const UnseenCell cell = unseenCellAt(texels, p);
        // The voxel that the place is in, of the level at which it was found.
        const int size = int(std::round(1.0f / cell.voxel));
        const vec3 low = glm::floor(p * float(size));
        const std::array<int, 3> at{int(low.x), int(low.y), int(low.z)};
        const int rings = ringsAbout(coverage, at, size), told = int(cell.edge + 1) / 2;
        ASSERT_EQ(cell.isUnseen, rings == 0) << at[0] << " " << at[1] << " " << at[2] << " of " << size;
        if (cell.isUnseen) continue;
        if (size == across) {
            ASSERT_EQ(rings, std::min(told, kMostAsked));
            EXPECT_GT(told, 1) << "right beside what is not open there are bricks";
            ++asked.ofGrid;
        } else if (cell.edge == 2.0f) {
            EXPECT_EQ(rings, 1);
            for (int k = 0; k < 8; ++k)
                EXPECT_GT(ringsAbout(coverage,
                                     {at[0] / 2 * 2 + k % 2, at[1] / 2 * 2 + k / 2 % 2, at[2] / 2 * 2 + k / 4}, size),
                          0);
            ++asked.pairs;
        } else {
            EXPECT_EQ(std::min(rings, int(kMostBrickRings)), told) << at[0] << " " << at[1] << " " << at[2];
            asked.ofBricks += size == 4 * across ? 1 : 0;
            asked.within += size == 16 * across ? 1 : 0;
            asked.wide += rings > 3 ? 1 : 0;
        }
    }
}

TEST(UnseenWalk, RingsAreAllTheOpenCubesOfVoxelsAboutOne) {
    CellsAsked asked;
    expectRingsOf(scene::randomCoverage(5, 5, 0.01, 0.4), 64, 6000, asked);
    // Longer than wide, and wider than high; a quarter of it was observed.
    expectRingsOf(flatSite(5, 7, 0.01, 0.4), 1024, 12000, asked);
    EXPECT_GT(asked.wide, 100);
    EXPECT_GT(asked.ofBricks, 100);
    EXPECT_GT(asked.within, 60);
    EXPECT_GT(asked.pairs, 20);
    EXPECT_GT(asked.ofGrid, 100);
}

/// Beams of rays through a tree: what they pass together is open, and each finds what it finds alone.
void expectToGoTogether(const scene::Coverage& coverage, float pocket, const vec3& least = vec3(0.0f), float edge = 1) {
    const Texels texels(coverage);
    std::mt19937 random(8);
    const auto uniform = [&] { return static_cast<float>(random()) / 4294967296.0f; };
    int beams = 0, together = 0, later = 0, differ = 0;
    for (int i = 0; i < 400; ++i) {
        const vec3 eye = least + edge * vec3(uniform(), uniform(), uniform());
        const vec3 base = edge * vec3(uniform() - 0.5f, uniform() - 0.5f, uniform() - 0.5f);
        const vec3 across = edge * vec3(0.02f * uniform(), 0.02f * uniform(), 0.0f),
                   down = edge * vec3(0.0f, 0.0f, 0.02f * uniform());
        const float farthest = i % 2 == 0 ? kRayInfinity : 2 * uniform();
        const vec2 open = openStretch(texels, eye, base, across, down, farthest);
        ++beams, together += open.y - open.x > 0.05f ? 1 : 0, later += open.y > open.x && open.x > 0 ? 1 : 0;
        for (int ray = 0; ray < 10; ++ray) {
            const vec3 direction = base + uniform() * across + uniform() * down;
            for (int k = 1; k < 40; ++k) {
                const vec3 p = eye + (open.x + float(k) / 40.0f * (open.y - open.x)) * direction;
                EXPECT_FALSE(open.y > open.x && unseenCellAt(texels, p).isUnseen) << "something unseen was passed over";
            }
            // Some end sooner than the one that goes farthest, most of those before the stretch does.
            const float end = ray % 2 == 0 ? farthest : std::min(farthest, 2.0f) * uniform();
            const UnseenHit alone = walkToUnseen(texels, eye, direction, pocket, end, vec2(0.0f)),
                            on = walkToUnseen(texels, eye, direction, pocket, end, open);
            // At a face between two cells single precision may choose the other one.
            const bool isSame =
                alone.isUnseen == on.isUnseen &&
                (!alone.isUnseen || std::abs(on.depth - alone.depth) <= 1e-3f * std::max(alone.depth, 1e-3f));
            differ += isSame ? 0 : 1;
            EXPECT_FALSE(on.isUnseen && on.depth > end) << "behind what is drawn";
        }
    }
    EXPECT_GT(together, beams / 8) << "or nothing was tested";
    EXPECT_GT(later, beams / 40) << "of those that begin away from the eye";
    EXPECT_LE(differ, 8) << "of 4000";
}

TEST(UnseenWalk, GoesTogetherWhereItIsOpenForAll) {
    // Five levels deep: bricks in bricks. Open for the most part, and with enough that eyes stand in.
    const scene::Coverage coverage = scene::randomCoverage(7, 5, 0.003);
    expectToGoTogether(coverage, 0);
    expectToGoTogether(coverage, 0.3f);
    expectToGoTogether(scene::coarsened(coverage, 4), 0.3f);
    const vec3 least = vec3(5, 7, 3) / 16.0f;
    expectToGoTogether(flatSite(7, 6, 0.003), 0.3f, least, 1.0f / 16);
    expectToGoTogether(flatSite(7, 6, 0.003), 0, least, 1.0f / 16);
    expectToGoTogether(farSite(7, 7, 0.003), 0, vec3(kFarLeast), 1.0f / 64);
}

/// Counts what is read.
struct CountingTexels {
    Texels texels;
    mutable std::size_t reads = 0;
    const UnseenGrid& grid() const { return texels.grid(); }
    uint word(uint index) const { return ++reads, texels.word(index); }
    uint brick(uint index) const { return ++reads, texels.brick(index); }
    uint base(uint index) const { return ++reads, texels.base(index); }
};

/// Of rays through half a part, from places in it.
std::size_t readsOfRays(const scene::Coverage& coverage, const glm::dvec3& least, double edge) {
    const CountingTexels texels{Texels(coverage)};
    std::mt19937 random(11);
    const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0; };
    for (int i = 0; i < 2000; ++i) {
        const double x = uniform(), y = uniform(), z = uniform();
        const glm::dvec3 eye = least + edge * (0.25 + 0.5 * glm::dvec3(x, y, z));
        const double theta = 6.2831853 * uniform(), up = 2 * uniform() - 1, flat = std::sqrt(1 - up * up);
        const glm::dvec3 direction = 0.5 * edge * glm::dvec3(flat * std::cos(theta), flat * std::sin(theta), up);
        const vec2 open =
            openStretch(texels, vec3(eye), vec3(direction), vec3(0.01 * edge, 0, 0), vec3(0, 0.01 * edge, 0), 1);
        walkToUnseen(texels, vec3(eye), vec3(direction), 1.0f, 1.0f, open);
    }
    return texels.reads;
}

TEST(UnseenWalk, APartOfALargeSiteIsWalkedThroughAsFastAsByItself) {
    const scene::Coverage part = scene::randomCoverage(7, 5, 0.001);
    const std::size_t alone = readsOfRays(part, glm::dvec3(0), 1);
    EXPECT_GT(alone, 20000u) << "or nothing was walked through";
    // A site sixteen times as wide.
    const std::size_t ofSite = readsOfRays(flatSite(7, 7, 0.001), glm::dvec3(5, 7, 3) / 16.0, 1.0 / 16);
    EXPECT_LT(static_cast<double>(ofSite), 1.05 * static_cast<double>(alone));
}

std::size_t bytesOf(const scene::Coverage& coverage) {
    const CoverageTexels made = coverageTexels(coverage);
    return (made.words.size() + made.bricks.size() + made.bases.size()) * sizeof(std::uint32_t);
}

std::vector<std::size_t> foretoldBytes(const scene::Coverage& coverage) {
    std::vector<std::size_t> bytes;
    for (const CoverageSize& size : coverageSizesByLevels(coverage))
        bytes.push_back(size.bytes());
    return bytes;
}

TEST(UnseenWalk, NoMoreBytesThanAreForetold) {
    const scene::Coverage coverage = scene::randomCoverage(9, 6, 0.3, 0.15);
    const std::vector<std::size_t> most = foretoldBytes(coverage);
    ASSERT_EQ(most.size(), 7u);
    EXPECT_EQ(most[6], bytesOf(coverage)) << "all of it is counted exactly";
    for (int levels = 5; levels >= 3; --levels) {
        const std::size_t bytes = bytesOf(scene::coarsened(coverage, levels)),
                          foretold = most[static_cast<std::size_t>(levels)];
        EXPECT_LE(bytes, foretold) << levels;
        EXPECT_LT(foretold, levels > 3 ? most[static_cast<std::size_t>(levels) + 1] : foretold + 1);
    }
    EXPECT_EQ(most[3], bytesOf(scene::coarsened(coverage, 2))) << "the grid alone";
    // Of more voxels than there may be at the level that is fine enough: a level of the tree less is no other grid.
    scene::Coverage wide = scene::randomCoverage(9, 7, 0.3, 0.08);
    wide.edgeMetres = 60;
    EXPECT_EQ(foretoldBytes(wide)[6], bytesOf(scene::coarsened(wide, 6)));
    for (const scene::Coverage& other : {wide, flatSite(9, 7, 0.3, 0.15), farSite(9, 7, 0.3, 0.15),
                                         flatSite(9, 7, 0.003, 0.15), scene::randomCoverage(8, 6, 0.003, 0.15)}) {
        const std::vector<std::size_t> mostOfIt = foretoldBytes(other);
        EXPECT_EQ(mostOfIt.back(), bytesOf(other));
        for (int levels = scene::levelsOf(other) - 1; levels >= 2; --levels)
            EXPECT_LE(bytesOf(scene::coarsened(other, levels)), mostOfIt[static_cast<std::size_t>(levels)]) << levels;
    }
}

} // namespace
} // namespace render
