#include "scene/coverage.h"
#include "scene/coverage_levels.h"

#include "scene/errors.h"
#include "tests/scene/random_coverage.h"
#include "tests/scene/scratch_folder.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <random>

#include <gtest/gtest.h>
#include <xxhash.h>

namespace scene {
namespace {

constexpr std::size_t kCoverageHeaderBytes = 72, kCoverageHeaderChecked = 64, kCornerAt = 16, kEdgeAt = 40;

/// Every cell of the tree, written into all the finest cells it consists of.
std::vector<Observed> spreadOut(const Coverage& coverage, int side) {
    std::vector<Observed> kinds(static_cast<std::size_t>(side) * side * side);
    const std::function<void(std::size_t, int, int, int, int)> fill = [&](std::size_t index, int x0, int y0, int z0,
                                                                          int edge) {
        const CoverageNode& node = coverage.nodes[index];
        const int cell = edge / kCoverageBranching;
        std::uint32_t child = node.firstChild;
        for (int bit = 0; bit < 64; ++bit) {
            const int x = x0 + bit % 4 * cell, y = y0 + bit / 4 % 4 * cell, z = z0 + bit / 16 * cell;
            if ((node.children >> bit & 1) != 0) {
                fill(child++, x, y, z, cell);
                continue;
            }
            const Observed kind = (node.unseen >> bit & 1) != 0    ? Observed::unseen
                                  : (node.surface >> bit & 1) != 0 ? Observed::surface
                                                                   : Observed::empty;
            for (int dz = 0; dz < cell; ++dz)
                for (int dy = 0; dy < cell; ++dy)
                    for (int dx = 0; dx < cell; ++dx)
                        kinds[static_cast<std::size_t>((z + dz) * side + y + dy) * side + x + dx] = kind;
        }
    };
    fill(0, 0, 0, 0, side);
    return kinds;
}

TEST(Coverage, EveryPointIsInTheCellThatHoldsIt) {
    const Coverage coverage = randomCoverage(3, 3);
    constexpr int kSide = 64;
    const std::vector<Observed> kinds = spreadOut(coverage, kSide);
    const double step = coverage.edgeMetres / kSide;
    for (int z = 0; z < kSide; ++z)
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x) {
                const glm::dvec3 p = coverage.cornerInWorld + step * glm::dvec3(x + 0.4, y + 0.5, z + 0.6);
                const std::optional<CoverageCell> cell = cellAt(coverage, p);
                ASSERT_TRUE(cell);
                ASSERT_EQ(cell->observed, kinds[static_cast<std::size_t>(z * kSide + y) * kSide + x]);
                for (int axis = 0; axis < 3; ++axis) {
                    ASSERT_GE(p[axis], cell->cornerInWorld[axis]);
                    ASSERT_LT(p[axis], cell->cornerInWorld[axis] + cell->edgeMetres);
                }
            }
}

TEST(Coverage, OutsideNothingWasObserved) {
    Coverage coverage;
    coverage.edgeMetres = 2;
    coverage.nodes.resize(1); // all seen empty
    EXPECT_EQ(observedAt(coverage, {1, 1, 1}), Observed::empty);
    EXPECT_EQ(observedAt(coverage, {1, 2, 1}), Observed::unseen);
    EXPECT_EQ(observedAt(coverage, {-1e-9, 1, 1}), Observed::unseen);
    EXPECT_FALSE(cellAt(coverage, {1, 1, std::nan("")}));
}

TEST(Coverage, VolumesAreThoseOfTheCells) {
    const Coverage coverage = randomCoverage(4, 3);
    std::array<double, 3> counted{};
    for (const Observed kind : spreadOut(coverage, 64))
        counted[static_cast<std::size_t>(kind)] += std::pow(coverage.edgeMetres / 64, 3);
    const std::array<double, 3> volumes =
        volumesOf(coverage, coverage.cornerInWorld, coverage.cornerInWorld + coverage.edgeMetres);
    for (std::size_t kind = 0; kind < 3; ++kind)
        EXPECT_NEAR(volumes[kind], counted[kind], 1e-9 * counted[kind]);
    EXPECT_DOUBLE_EQ(finestCellOf(coverage), coverage.edgeMetres / 64);
}

TEST(Coverage, VolumesInABoxAreOfWhatLiesInIt) {
    const Coverage coverage = randomCoverage(4, 3);
    const glm::dvec3 corner = coverage.cornerInWorld;
    const double finest = coverage.edgeMetres / 64;
    // Of the finest cells; along z beyond the cube, where nothing is.
    const std::array<int, 3> first{5, 9, 0}, end{40, 33, 64};
    const glm::dvec3 low = corner + finest * glm::dvec3(first[0], first[1], -20);
    const glm::dvec3 high = corner + finest * glm::dvec3(end[0], end[1], 90);
    const std::vector<Observed> cells = spreadOut(coverage, 64);
    std::array<double, 3> counted{};
    for (int z = first[2]; z < end[2]; ++z)
        for (int y = first[1]; y < end[1]; ++y)
            for (int x = first[0]; x < end[0]; ++x)
                counted[static_cast<std::size_t>(cells[static_cast<std::size_t>((z * 64 + y) * 64 + x)])] +=
                    std::pow(finest, 3);
    const std::array<double, 3> volumes = volumesOf(coverage, low, high);
    for (std::size_t kind = 0; kind < 3; ++kind)
        EXPECT_NEAR(volumes[kind], counted[kind], 1e-9 * counted[kind]);
    // Half of one cell.
    const std::array<double, 3> half = volumesOf(coverage, corner, corner + finest * glm::dvec3(0.5, 1, 1));
    EXPECT_NEAR(half[0] + half[1] + half[2], 0.5 * std::pow(finest, 3), 1e-12);
}

/// What a cube of the finest cells is told as by one cell.
Observed asOne(const std::vector<Observed>& kinds, int side, const std::array<int, 3>& first, int edge) {
    std::array<int, 3> count{};
    for (int z = first[2]; z < first[2] + edge; ++z)
        for (int y = first[1]; y < first[1] + edge; ++y)
            for (int x = first[0]; x < first[0] + edge; ++x)
                ++count[static_cast<std::size_t>(kinds[static_cast<std::size_t>((z * side + y) * side + x)])];
    const bool hasSurface = count[static_cast<std::size_t>(Observed::surface)] > 0;
    const double unseen = count[static_cast<std::size_t>(Observed::unseen)] / std::pow(edge, 3);
    if (unseen >= (hasSurface ? 0.9 : 0.75)) return Observed::unseen;
    return hasSurface ? Observed::surface : Observed::empty;
}

TEST(CoverageLevels, WhatIsCutOffIsOneCellOfItsOwnKind) {
    constexpr int kSide = 256;
    Coverage whole = randomCoverage(11, 4, 0.4, 0.3);
    // Some nodes without surfaces, so that it is a matter of more or less; of others all that is not surface unseen,
    // and of every other one of those there is little surface.
    for (std::size_t i = 0; i < whole.nodes.size(); i += 2) {
        CoverageNode& node = whole.nodes[i];
        if (i % 4 == 0) {
            node.surface = 0;
            continue;
        }
        if (i % 8 == 2) node.surface &= whole.nodes[i - 1].surface;
        node.unseen = ~(node.surface | node.children);
    }
    ASSERT_EQ(levelsOf(whole), 4);
    const std::vector<Observed> fine = spreadOut(whole, kSide);
    for (const int levels : {1, 2, 3}) {
        const Coverage coarse = coarsened(whole, levels);
        EXPECT_EQ(levelsOf(coarse), levels);
        EXPECT_DOUBLE_EQ(finestCellOf(coarse), cellOfLevels(whole, levels));
        EXPECT_EQ(coarse.nodes.size(), firstNodesOf(whole)[static_cast<std::size_t>(levels)]);
        const std::vector<Observed> told = spreadOut(coarse, kSide);
        const int edge = kSide >> 2 * levels;
        std::array<int, 3> changed{};
        for (int z = 0; z < kSide; z += edge)
            for (int y = 0; y < kSide; y += edge)
                for (int x = 0; x < kSide; x += edge) {
                    const Observed expected = asOne(fine, kSide, {x, y, z}, edge);
                    const auto at = static_cast<std::size_t>((z * kSide + y) * kSide + x);
                    ASSERT_EQ(told[at], expected) << levels << " levels, " << x << " " << y << " " << z;
                    if (fine[at] != expected) ++changed[static_cast<std::size_t>(expected)];
                }
        EXPECT_GT(changed[static_cast<std::size_t>(Observed::surface)], 0) << "or nothing was tested";
        if (levels == 3) {
            // A tenth at most of such a cell is not unseen; so is seldom the corner of it that is looked at.
            EXPECT_GT(changed[static_cast<std::size_t>(Observed::unseen)], 20);
            EXPECT_GT(changed[static_cast<std::size_t>(Observed::empty)], 100);
        }
    }
}

TEST(CoverageLevels, WithAllItsLevelsItIsTheSame) {
    const Coverage whole = randomCoverage(12, 3);
    EXPECT_TRUE(coarsened(whole, 3) == whole);
    EXPECT_TRUE(coarsened(whole, 9) == whole);
    EXPECT_EQ(firstNodesOf(whole),
              (std::vector<std::size_t>{0, 1, 1 + static_cast<std::size_t>(std::popcount(whole.nodes[0].children)),
                                        whole.nodes.size()}));
}

TEST(CoverageLevels, WhatIsCutOffCanBeWrittenAndRead) {
    const ScratchFolder folder;
    const Coverage coarse = coarsened(randomCoverage(13, 4), 2);
    writeCoverage(coarse, folder.path() / kCoverageFile);
    EXPECT_TRUE(readCoverage(folder.path() / kCoverageFile) == coarse) << "it is a tree that a reader accepts";
}

class CoverageFile : public testing::Test {
  protected:
    void SetUp() override {
        coverage_ = randomCoverage(5, 2);
        writeCoverage(coverage_, path_);
        bytes_ = bytesOfFile(path_);
    }
    /// What reading says of a file with these bytes; empty if it says nothing.
    std::string complaintAbout(const std::string& bytes) const {
        writeFile(path_, bytes);
        return failureOf<Failure>([&] { readCoverage(path_); });
    }
    /// With checksums that fit, as a program that errs would write it.
    std::string complaintAboutNodes(const std::function<void(std::vector<CoverageNode>&)>& change) const {
        Coverage changed = coverage_;
        change(changed.nodes);
        writeCoverage(changed, path_);
        return complaintAbout(bytesOfFile(path_));
    }

    ScratchFolder scratch_;
    std::filesystem::path path_ = scratch_ / kCoverageFile;
    Coverage coverage_;
    std::string bytes_;
};

TEST_F(CoverageFile, ComesBackAsItWas) {
    EXPECT_EQ(readCoverage(path_), coverage_);
    EXPECT_EQ(bytes_.size(), kCoverageHeaderBytes + coverage_.nodes.size() * sizeof(CoverageNode));
}

TEST_F(CoverageFile, ADamagedByteAnywhereIsNoticed) {
    for (std::size_t at = 0; at < bytes_.size(); at += at < kCoverageHeaderBytes ? 1 : 37) {
        std::string damaged = bytes_;
        damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
        EXPECT_NE(complaintAbout(damaged).find(path_.string()), std::string::npos) << "byte " << at;
    }
}

TEST_F(CoverageFile, AFileOfAnotherLengthIsNoticed) {
    for (std::size_t length = 0; length < bytes_.size(); length += 61)
        EXPECT_NE(complaintAbout(bytes_.substr(0, length)), "") << length;
    EXPECT_NE(complaintAbout(bytes_ + '\0'), "");
    EXPECT_NE(complaintAbout(bytes_ + std::string(sizeof(CoverageNode), '\0')), "");
}

TEST_F(CoverageFile, AMissingFileIsNamed) {
    std::filesystem::remove(path_);
    EXPECT_THROW(readCoverage(path_), Failure);
}

TEST_F(CoverageFile, NodesThatAreNoTreeAreNoticed) {
    EXPECT_EQ(complaintAboutNodes([](auto&) {}), "");
    EXPECT_NE(complaintAboutNodes([](auto& nodes) { nodes[0].unseen |= nodes[0].children; }), "");
    EXPECT_NE(complaintAboutNodes([](auto& nodes) { nodes[0].surface |= nodes[0].children; }), "");
    EXPECT_NE(complaintAboutNodes([](auto& nodes) { nodes[1].unseen = nodes[1].surface = 1; }), "");
    EXPECT_NE(complaintAboutNodes([](auto& nodes) { nodes[0].firstChild = 0; }), "");
    EXPECT_NE(complaintAboutNodes([](auto& nodes) { nodes[0].firstChild = 1u << 30; }), "");
    EXPECT_NE(complaintAboutNodes([](auto& nodes) { nodes.pop_back(); }), "");
    EXPECT_NE(complaintAboutNodes([](auto& nodes) { nodes.emplace_back(); }), "");
    EXPECT_NE(complaintAboutNodes([](auto& nodes) { // its own child, and so on for ever
                  nodes.back() = {0, 0, 1, static_cast<std::uint32_t>(nodes.size()) - 1, 0};
              }),
              "");
    EXPECT_NE(complaintAboutNodes([](auto& nodes) { nodes.clear(); }), "");
}

TEST_F(CoverageFile, DeeperThanCanBeWalkedIsNoticed) {
    const auto chain = [](auto& nodes, std::size_t length) {
        nodes.assign(length, {});
        for (std::size_t i = 0; i + 1 < length; ++i)
            nodes[i] = {0, 0, 1, static_cast<std::uint32_t>(i + 1), 0};
    };
    EXPECT_EQ(complaintAboutNodes([&](auto& nodes) { chain(nodes, kMaxCoverageLevels); }), "");
    EXPECT_NE(complaintAboutNodes([&](auto& nodes) { chain(nodes, kMaxCoverageLevels + 1); }), "");
}

TEST_F(CoverageFile, APlaceThatIsNoneIsNoticed) {
    for (const std::size_t at : {kCornerAt, kCornerAt + 16, kEdgeAt})
        for (const double value : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
            std::string changed = bytes_;
            std::memcpy(changed.data() + at, &value, sizeof value);
            const std::uint64_t checksum = XXH3_64bits(changed.data(), kCoverageHeaderChecked);
            std::memcpy(changed.data() + kCoverageHeaderChecked, &checksum, sizeof checksum);
            EXPECT_NE(complaintAbout(changed), "") << at << " " << value;
        }
}

} // namespace
} // namespace scene
