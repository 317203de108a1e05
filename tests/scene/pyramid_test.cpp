#include "scene/facets.h"
#include "scene/pyramid.h"
#include "scene/scene_file.h"
#include "tests/scene/random_poses.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include <gtest/gtest.h>

namespace scene {
namespace {

using HalfSquare = std::tuple<int, int, bool>; ///< place of the square in its image, whether the upper half

DepthImage blank(int width, int height, float disparity) {
    DepthImage image;
    image.name = "image";
    image.camera = {width, height, 1.0 * width, 1.0 * width, width / 2.0, height / 2.0};
    image.colour = Image<Rgb8>(width, height, Rgb8{100, 100, 100});
    image.disparity = Image<float>(width, height, disparity);
    image.flags = Image<std::uint8_t>(width, height, 0);
    return image;
}

/// A wavy surface with a step in the middle, holes, and some triangles that are skins.
DepthImage drawHills(int width, int height, unsigned seed) {
    RandomPlaces random(seed);
    DepthImage image = blank(width, height, 0.5f);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double wave = 0.05 * std::sin(0.05 * x) * std::cos(0.07 * y) * (y > height / 2 ? 1 : 0);
            image.disparity(x, y) = static_cast<float>((x < width / 2 ? 0.5 : 0.2) + wave);
            image.colour(x, y) = {static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y), 7};
            unsigned flags = 0;
            if (random.between(0, 1) < 0.01) flags |= kNoSurface;
            if (x == width / 2 - 1) flags |= kSkinUpper | kSkinLower;
            if (random.between(0, 1) < 0.01) flags |= kRedundant;
            image.flags(x, y) = static_cast<std::uint8_t>(flags);
        }
    return image;
}

std::multiset<HalfSquare> halvesOfSquares(const TileSet& set) {
    std::multiset<HalfSquare> halves;
    for (const Tile& tile : set.tiles)
        for (std::uint32_t i = tile.firstQuad; i < tile.firstQuad + tile.quadCount; ++i) {
            const TileQuad& quad = set.quads[i];
            const VertexPlace p = placeOf(tile, set.vertices[tile.firstVertex + (quad.top >> 16 & kQuadIndexMask)]);
            const int x = tile.x0 + static_cast<int>(p.x) - 1, y = tile.y0 + static_cast<int>(p.y);
            if ((quad.top & kDrawUpper) != 0) halves.insert({x, y, true});
            if ((quad.bottom & kDrawLower) != 0) halves.insert({x, y, false});
        }
    return halves;
}

std::multiset<HalfSquare> halvesOfFacets(const TileSet& set) {
    std::multiset<HalfSquare> halves;
    for (const Tile& tile : set.tiles)
        for (std::uint32_t i = tile.firstFacet; i < tile.firstFacet + tile.facetCount; ++i) {
            const std::uint32_t mark = set.facets[i].mark;
            const int x0 = tile.x0 + static_cast<int>(mark & 63u), y0 = tile.y0 + static_cast<int>(mark >> 6 & 63u);
            const int side = 1 << (mark >> 12 & 7u);
            for (int y = y0; y < y0 + side; ++y)
                for (int x = x0; x < x0 + side; ++x) {
                    if ((mark & kFacetUpper) != 0) halves.insert({x, y, true});
                    if ((mark & kFacetLower) != 0) halves.insert({x, y, false});
                }
        }
    return halves;
}

TEST(Facets, LieOverTheSquaresOfTheirTilesAndNothingElse) {
    for (const float tolerance : {0.0f, 0.001f, 0.02f}) {
        TileSet set = cutIntoTiles(drawHills(150, 130, 3));
        layFacets(set, tolerance, Squares::stay);
        TileSet withFacets = set;
        std::erase_if(withFacets.tiles, [](const Tile& tile) { return tile.facetCount == 0; });
        ASSERT_FALSE(withFacets.tiles.empty());
        EXPECT_EQ(halvesOfFacets(set), halvesOfSquares(withFacets));
    }
}

TEST(Facets, NoSampleLeavesItsPlane) {
    constexpr float kTolerance = 0.004f;
    const DepthImage image = drawHills(150, 130, 4);
    TileSet set = cutIntoTiles(image);
    layFacets(set, kTolerance, Squares::stay);
    std::size_t large = 0;
    for (const Tile& tile : set.tiles) {
        const float step = (tile.maxDisparity - tile.minDisparity) / static_cast<float>(maxQuantisedOf(tile));
        for (std::uint32_t i = tile.firstFacet; i < tile.firstFacet + tile.facetCount; ++i) {
            const TileFacet& facet = set.facets[i];
            const bool isWhole = (facet.mark & kFacetUpper) != 0 && (facet.mark & kFacetLower) != 0;
            const int x0 = static_cast<int>(facet.mark & 63u), y0 = static_cast<int>(facet.mark >> 6 & 63u);
            const int side = 1 << (facet.mark >> 12 & 7u);
            large += side >= 8;
            for (int y = 0; y <= side; ++y)
                for (int x = 0; x <= side; ++x) {
                    if (!isWhole && ((x == y) && (x == 0) != ((facet.mark & kFacetUpper) != 0))) continue;
                    const float q = facet.q + static_cast<float>(x) * facet.perX + static_cast<float>(y) * facet.perY;
                    const float truth = image.disparity(tile.x0 + x0 + x, tile.y0 + y0 + y);
                    EXPECT_NEAR(tile.minDisparity + q * step, truth, 1.01f * kTolerance * truth + 1e-6f);
                }
        }
    }
    EXPECT_GT(large, 10u);
}

// Those that a device draws at once take alike long.
TEST(Facets, TheLargestOfATileComeFirst) {
    TileSet set = cutIntoTiles(drawHills(150, 130, 4));
    layFacets(set, 0.004f, Squares::stay);
    std::size_t mixed = 0;
    for (const Tile& tile : set.tiles) {
        std::vector<std::uint32_t> sides;
        for (std::uint32_t i = tile.firstFacet; i < tile.firstFacet + tile.facetCount; ++i)
            sides.push_back(log2SideOf(set.facets[i]));
        EXPECT_TRUE(std::is_sorted(sides.rbegin(), sides.rend()));
        mixed += !sides.empty() && sides.front() != sides.back() ? 1 : 0;
    }
    EXPECT_GT(mixed, 3u);
}

TEST(Facets, AFlatTileIsOne) {
    const DepthImage image = blank(65, 65, 0.25f);
    TileSet set = cutIntoTiles(image);
    layFacets(set, 0.001f, Squares::goWhereFacetsAre);
    ASSERT_FALSE(set.tiles.empty());
    EXPECT_EQ(set.tiles.front().facetCount, 1u);
    EXPECT_TRUE(set.tiles.front().quadCount == 0);
    EXPECT_EQ(set.texels.at(set.tiles.front().firstTexel).right, 100u | 100u << 8 | 100u << 16);
}

TEST(Pyramid, NothingFloatsBetweenTwoSurfaces) {
    const DepthImage fine = drawHills(151, 131, 5);
    PyramidOptions options;
    DepthImage level = fine;
    for (int l = 1; l < 5; ++l) {
        level = halve(level, options);
        EXPECT_EQ(level.camera.width, cameraAtLevel(fine.camera, l).width);
        for (int y = 0; y < level.camera.height; ++y)
            for (int x = 0; x < level.camera.width; ++x) {
                if (!isDrawable(level.flags(x, y))) continue;
                const float d = level.disparity(x, y);
                EXPECT_TRUE((d > 0.14f && d < 0.26f) || (d > 0.44f && d < 0.56f)) << d << " at level " << l;
            }
    }
}

// Half the samples, from the same camera: what a coarse sample shows stands where the fine ones did.
TEST(Pyramid, ACoarseSampleIsTheMeanOfItsFour) {
    DepthImage fine = blank(8, 6, 0.5f);
    for (int y = 0; y < 6; ++y)
        for (int x = 0; x < 8; ++x)
            fine.colour(x, y) = {static_cast<std::uint8_t>(20 * x), static_cast<std::uint8_t>(30 * y), 0},
                           fine.disparity(x, y) = 0.5f + 0.001f * static_cast<float>(x);
    const DepthImage coarse = halve(fine, {});
    EXPECT_EQ(coarse.camera.width, 4);
    EXPECT_NEAR(coarse.disparity(1, 1), 0.5025f, 1e-6f);
    EXPECT_EQ(coarse.colour(1, 1), (Rgb8{50, 75, 0}));
    const glm::dvec3 a = rayThrough(fine.camera, 3.0, 3.0), b = rayThrough(coarse.camera, 1.5, 1.5);
    EXPECT_LT(glm::length(a - b), 1e-12);
}

TEST(Pyramid, WhatIsKeptComesFirstAndTheNearerOfTwoAlike) {
    DepthImage fine = blank(2, 2, 0.5f);
    for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {0, 1}})
        fine.flags(x, y) = kRedundant;
    fine.disparity(1, 1) = 0.2f;
    EXPECT_FLOAT_EQ(halve(fine, {}).disparity(0, 0), 0.2f) << "the only one that is kept";
    EXPECT_EQ(halve(fine, {}).flags(0, 0), 0);
    fine.flags(0, 0) = 0;
    EXPECT_FLOAT_EQ(halve(fine, {}).disparity(0, 0), 0.5f) << "three agree";
    fine.disparity(1, 0) = 0.2f;
    EXPECT_FLOAT_EQ(halve(fine, {}).disparity(0, 0), 0.5f) << "two and two: the nearer";
}

TEST(Pyramid, OfWhatIsKeptMeasuredBaseComesBeforeClosedAndThatBeforeOtherDirectionsAndGuesses) {
    constexpr std::uint8_t kOrder[] = {0, kInterpolated, kDirectional, kNoSurface | kInterpolated, kRedundant};
    for (int better = 0; better < 4; ++better)
        for (int worse = better + 1; worse < 5; ++worse) {
            DepthImage fine = blank(2, 2, 0.5f);
            for (std::uint8_t& flags : fine.flags.pixels())
                flags = kOrder[worse];
            fine.flags(1, 1) = kOrder[better];
            // Of its tier, but closed where three of the four were not measured.
            const bool isClosedThen = (better == 0 || better == 2) && (worse == 1 || worse == 3);
            const int flags = kOrder[better] | (isClosedThen ? kInterpolated : 0);
            EXPECT_EQ(halve(fine, {}).flags(0, 0), flags) << better << " and " << worse;
        }
}

TEST(Pyramid, AFewMeasuredSamplesVouchForNoOthers) {
    DepthImage image = blank(4, 2, 0.5f);
    const auto close = [&](int x, int y) {
        image.flags(x, y) = kInterpolated;
        image.disparity(x, y) = 0.505f;
        image.colour(x, y) = {200, 0, 0};
    };
    close(0, 0), close(1, 0), close(0, 1); // three of four
    close(3, 0), close(3, 1);              // two of four
    const DepthImage coarse = halve(image, {});
    EXPECT_TRUE(isClosed(coarse.flags(0, 0)));
    EXPECT_FALSE(isClosed(coarse.flags(1, 0)));
    for (const int x : {0, 1}) {
        EXPECT_EQ(coarse.disparity(x, 0), 0.5f) << "as measured";
        EXPECT_EQ(coarse.colour(x, 0), (Rgb8{100, 100, 100}));
    }
    // From level to level.
    DepthImage wide = blank(16, 16, 0.5f);
    for (std::uint8_t& flags : wide.flags.pixels())
        flags = kInterpolated;
    wide.flags(5, 5) = 0;
    EXPECT_TRUE(isClosed(halve(halve(wide, {}), {}).flags(1, 1)));
}

TEST(Pyramid, LevelsSurviveTheirBlock) {
    const TileSet set = cutIntoLevels(drawHills(300, 200, 6), {});
    std::set<int> levels;
    for (const Tile& tile : set.coarser)
        levels.insert(tile.level);
    EXPECT_EQ(levels, (std::set<int>{1, 2, 3, 4}));
    const TileSet back = unpackTiles(packTiles(set), "block");
    EXPECT_EQ(back.tiles, set.tiles);
    EXPECT_EQ(back.coarser, set.coarser);
    EXPECT_EQ(back.facets, set.facets);
    EXPECT_EQ(back.texels, set.texels);
}

} // namespace
} // namespace scene
