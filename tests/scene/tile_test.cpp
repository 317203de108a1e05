#include "scene/tile.h"

#include "tests/scene/random_poses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace scene {
namespace {

using Place = std::pair<int, int>;
using Triangle = std::array<Place, 3>;

bool isKept(std::uint8_t flags) {
    return isDrawable(flags) && (flags & kRedundant) == 0;
}

/// What a random image is made of; shares of samples, from 0 to 1.
struct Content {
    double absent = 0.2, floating = 0.05, redundant = 0.2, skins = 0.2, interpolated = 0.1, directional = 0.2;
};

/// Samples that are not there have a disparity nobody may touch.
DepthImage drawImage(int width, int height, unsigned seed, const Content& content = {}) {
    RandomPlaces random(seed);
    DepthImage image;
    image.name = "random";
    image.camera = {width, height, 1.0 * width, 1.0 * height, width / 2.0, height / 2.0};
    image.colour = Image<Rgb8>(width, height);
    image.disparity = Image<float>(width, height, std::numeric_limits<float>::quiet_NaN());
    image.flags = Image<std::uint8_t>(width, height);
    const auto happens = [&](double share) { return random.between(0, 1) < share; };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            unsigned flags = 0;
            if (happens(content.absent)) flags |= kNoSurface;
            if (happens(content.floating)) flags |= kFloating;
            if (happens(content.redundant)) flags |= kRedundant;
            if (happens(content.skins)) flags |= kSkinUpper;
            if (happens(content.skins)) flags |= kSkinLower;
            if (happens(content.interpolated)) flags |= kInterpolated;
            if (happens(content.directional)) flags |= kDirectional;
            image.flags(x, y) = static_cast<std::uint8_t>(flags);
            const auto channel = [&] { return static_cast<std::uint8_t>(random.integerBetween(0, 255)); };
            const std::uint8_t r = channel(), g = channel(), b = channel();
            image.colour(x, y) = {r, g, b};
            const double disparity = happens(0.1) ? 0.0 : std::exp(random.between(-8, 5));
            if (isDrawable(image.flags(x, y))) image.disparity(x, y) = static_cast<float>(disparity);
        }
    return image;
}

/// The triangles of the whole image, straight from the words of cutIntoTiles.
std::multiset<Triangle> trianglesOf(const DepthImage& image) {
    std::multiset<Triangle> triangles;
    const auto add = [&](const Triangle& triangle) {
        bool anyKept = false;
        for (const auto& [x, y] : triangle) {
            if (!isDrawable(image.flags(x, y))) return;
            anyKept = anyKept || isKept(image.flags(x, y));
        }
        if (anyKept) triangles.insert(triangle);
    };
    for (int y = 0; y + 1 < image.camera.height; ++y)
        for (int x = 0; x + 1 < image.camera.width; ++x) {
            if ((image.flags(x, y) & kSkinUpper) == 0) add({Place{x, y}, Place{x + 1, y}, Place{x, y + 1}});
            if ((image.flags(x, y) & kSkinLower) == 0) add({Place{x + 1, y}, Place{x + 1, y + 1}, Place{x, y + 1}});
        }
    return triangles;
}

Place placeInImage(const Tile& tile, const TileVertex& vertex) {
    const VertexPlace place = placeOf(tile, vertex);
    return {tile.x0 + static_cast<int>(place.x), tile.y0 + static_cast<int>(place.y)};
}

/// The triangles that a renderer draws of these tiles of the set.
std::multiset<Triangle> trianglesOf(const TileSet& set, std::span<const Tile> tiles) {
    std::multiset<Triangle> triangles;
    for (const Tile& tile : tiles)
        for (std::uint32_t i = 0; i < tile.quadCount; ++i) {
            const TileQuad& quad = set.quads.at(tile.firstQuad + i);
            const auto at = [&](std::uint32_t index) {
                EXPECT_LT(index, tile.vertexCount);
                return placeInImage(tile, set.vertices.at(tile.firstVertex + index));
            };
            const Place p00 = at(quad.top & kQuadIndexMask), p10 = at(quad.top >> 16 & kQuadIndexMask);
            const Place p01 = at(quad.bottom & kQuadIndexMask), p11 = at(quad.bottom >> 16 & kQuadIndexMask);
            EXPECT_TRUE((quad.top & kDrawUpper) != 0 || (quad.bottom & kDrawLower) != 0);
            if ((quad.top & kDrawUpper) != 0) triangles.insert({p00, p10, p01});
            if ((quad.bottom & kDrawLower) != 0) triangles.insert({p10, p11, p01});
        }
    return triangles;
}

std::multiset<Triangle> trianglesOf(const TileSet& set) {
    return trianglesOf(set, set.tiles);
}

void expectTilesFollowEachOther(const TileSet& set) {
    std::uint32_t vertices = 0, quads = 0;
    for (const Tile& tile : set.tiles) {
        EXPECT_EQ(tile.firstVertex, vertices);
        EXPECT_EQ(tile.firstQuad, quads);
        EXPECT_GT(tile.vertexCount, 0u);
        EXPECT_LE(tile.pointCount, tile.vertexCount);
        vertices += tile.vertexCount;
        quads += tile.quadCount;
    }
    EXPECT_EQ(vertices, set.vertices.size());
    EXPECT_EQ(quads, set.quads.size());
}

void expectEveryKeptSampleOnce(const DepthImage& image, const TileSet& set) {
    std::multiset<Place> points;
    for (const Tile& tile : set.tiles)
        for (std::uint32_t i = 0; i < tile.pointCount; ++i) {
            const Place place = placeInImage(tile, set.vertices[tile.firstVertex + i]);
            EXPECT_TRUE(place.first < tile.x0 + tile.width && place.second < tile.y0 + tile.height);
            points.insert(place);
        }
    std::multiset<Place> kept;
    for (int y = 0; y < image.camera.height; ++y)
        for (int x = 0; x < image.camera.width; ++x)
            if (isKept(image.flags(x, y))) kept.insert({x, y});
    EXPECT_EQ(points, kept);
}

/// Samples stand in tiles of their tier and nowhere else. A triangle is a guess where any of its samples is one, else
/// filled where one that is kept was not measured, the base's where one is, and of other directions where all are.
void expectTiersByThemselves(const DepthImage& image, const TileSet& set) {
    const auto tierAt = [&](const Place& place) -> std::optional<Tier> {
        const std::uint8_t flags = image.flags(place.first, place.second);
        if (!isKept(flags)) return std::nullopt;
        const bool isMeasured = (flags & (kInterpolated | kNoSurface)) == 0;
        if ((flags & kNoSurface) != 0) return Tier::guess;
        if ((flags & kDirectional) != 0) return isMeasured ? Tier::directional : Tier::guess;
        return isMeasured ? Tier::base : Tier::closed;
    };
    const auto tierOf = [&](const Triangle& triangle) {
        std::set<std::optional<Tier>> tiers;
        for (const Place& place : triangle) {
            if ((image.flags(place.first, place.second) & kNoSurface) != 0) return Tier::guess;
            tiers.insert(tierAt(place));
        }
        for (const Tier tier : {Tier::closed, Tier::base, Tier::guess})
            if (tiers.contains(tier)) return tier;
        return Tier::directional;
    };
    for (const Tile& tile : set.tiles) {
        for (std::uint32_t i = 0; i < tile.pointCount; ++i)
            EXPECT_EQ(tierAt(placeInImage(tile, set.vertices[tile.firstVertex + i])), tile.tier);
        for (const Triangle& triangle : trianglesOf(set, {&tile, 1}))
            EXPECT_EQ(tierOf(triangle), tile.tier);
    }
}

/// By the sides of the triangles that a renderer draws, their diagonals left out; unrounded.
double steepnessOf(const DepthImage& image, const Tile& tile, const TileSet& set) {
    const auto disparityAt = [&](std::uint32_t index) {
        const auto [x, y] = placeInImage(tile, set.vertices[tile.firstVertex + (index & kQuadIndexMask)]);
        return static_cast<double>(image.disparity(x, y));
    };
    std::multiset<double> steps;
    for (std::uint32_t i = tile.firstQuad; i < tile.firstQuad + tile.quadCount; ++i) {
        const TileQuad& quad = set.quads[i];
        const double d10 = disparityAt(quad.top >> 16), d01 = disparityAt(quad.bottom);
        double steepest = 0;
        for (const auto& [isDrawn, corner] : {std::pair{(quad.top & kDrawUpper) != 0, quad.top},
                                              std::pair{(quad.bottom & kDrawLower) != 0, quad.bottom >> 16}})
            if (isDrawn)
                steepest =
                    std::max({steepest, std::abs(disparityAt(corner) - d10), std::abs(disparityAt(corner) - d01)});
        steps.insert(steepest);
    }
    const double range = static_cast<double>(tile.maxDisparity) - tile.minDisparity;
    if (steps.empty() || range == 0) return 0;
    // The least that seven eighths of all are no greater than.
    const auto enough = std::find_if(steps.begin(), steps.end(), [&](double step) {
        return 8 * std::distance(steps.begin(), steps.upper_bound(step)) >= 7 * std::ssize(steps);
    });
    return 255 * *enough / range;
}

/// Border: surfaces that a drawn triangle of this tile needs, none of them twice. Kept samples that none needs are
/// lone, and stand at the end once more.
void expectBorderIsNeeded(const DepthImage& image, const TileSet& set) {
    for (const Tile& tile : set.tiles) {
        std::set<std::uint32_t> used;
        for (std::uint32_t i = 0; i < tile.quadCount; ++i) {
            const TileQuad& quad = set.quads[tile.firstQuad + i];
            used.insert({quad.top >> 16 & kQuadIndexMask, quad.bottom & kQuadIndexMask});
            if ((quad.top & kDrawUpper) != 0) used.insert(quad.top & kQuadIndexMask);
            if ((quad.bottom & kDrawLower) != 0) used.insert(quad.bottom >> 16 & kQuadIndexMask);
        }
        std::set<Place> places;
        std::vector<TileVertex> lone;
        for (std::uint32_t i = 0; i < tile.vertexCount - tile.loneCount; ++i) {
            if (!used.contains(i)) lone.push_back(set.vertices[tile.firstVertex + i]);
            const Place place = placeInImage(tile, set.vertices[tile.firstVertex + i]);
            EXPECT_TRUE(places.insert(place).second);
            EXPECT_TRUE(place.first <= tile.x0 + tile.width && place.second <= tile.y0 + tile.height);
            ASSERT_TRUE(place.first < image.camera.width && place.second < image.camera.height);
            EXPECT_TRUE(isDrawable(image.flags(place.first, place.second)));
            if (i >= tile.pointCount) {
                EXPECT_TRUE(used.contains(i));
            }
        }
        const double steepness = steepnessOf(image, tile, set);
        EXPECT_GE(tile.steepness, steepness - 1e-3);
        EXPECT_LE(tile.steepness, steepness + 1.001);
        const auto repeated = std::span(set.vertices).subspan(firstLoneOf(tile), tile.loneCount);
        EXPECT_TRUE(std::equal(lone.begin(), lone.end(), repeated.begin(), repeated.end()));
    }
}

/// Half a quantisation step, and the rounding of the single precision in which a shader puts it together.
void expectSamplesAreTrue(const DepthImage& image, const TileSet& set) {
    for (const Tile& tile : set.tiles) {
        float least = std::numeric_limits<float>::max(), most = 0;
        for (std::uint32_t i = 0; i < tile.vertexCount; ++i) {
            const TileVertex& vertex = set.vertices[tile.firstVertex + i];
            const auto [x, y] = placeInImage(tile, vertex);
            const Rgb8 c = image.colour(x, y);
            EXPECT_EQ(vertex.colour, c.r | static_cast<std::uint32_t>(c.g) << 8 |
                                         static_cast<std::uint32_t>(c.b) << 16 |
                                         static_cast<std::uint32_t>(image.flags(x, y)) << 24);
            const float truth = image.disparity(x, y);
            const float range = tile.maxDisparity - tile.minDisparity;
            const float bound = 0.5f * range / static_cast<float>(maxQuantisedOf(tile)) +
                                4 * std::numeric_limits<float>::epsilon() * tile.maxDisparity +
                                std::numeric_limits<float>::denorm_min();
            EXPECT_NEAR(disparityOf(tile, vertex), truth, bound);
            least = std::min(least, truth);
            most = std::max(most, truth);
        }
        EXPECT_EQ(tile.minDisparity, least);
        EXPECT_EQ(tile.maxDisparity, most);
    }
}

void expectCutRight(const DepthImage& image, int tileSize) {
    const TileSet set = cutIntoTiles(image, tileSize);
    expectTilesFollowEachOther(set);
    expectEveryKeptSampleOnce(image, set);
    expectTiersByThemselves(image, set);
    expectBorderIsNeeded(image, set);
    expectSamplesAreTrue(image, set);
    EXPECT_EQ(trianglesOf(set), trianglesOf(image));
}

class CutIntoTiles : public testing::TestWithParam<int> {};

TEST_P(CutIntoTiles, ImagesOfAllSizes) {
    unsigned seed = 0;
    for (const auto& [width, height] :
         {Place{1, 1}, {1, 9}, {9, 1}, {2, 2}, {5, 3}, {63, 64}, {64, 63}, {65, 97}, {128, 96}}) {
        SCOPED_TRACE(std::to_string(width) + "x" + std::to_string(height));
        expectCutRight(drawImage(width, height, ++seed), GetParam());
    }
}

TEST_P(CutIntoTiles, FullImages) {
    const DepthImage image = drawImage(70, 70, 20, {0, 0, 0, 0});
    expectCutRight(image, GetParam());
    EXPECT_EQ(trianglesOf(cutIntoTiles(image, GetParam())).size(), 2u * 69 * 69);
}

TEST_P(CutIntoTiles, NothingLeftOfRedundantOrAbsentImages) {
    for (const Content& content : {Content{0, 0, 1, 0}, Content{1, 0, 0, 0, 0}, Content{0, 1, 0, 0}}) {
        const TileSet set = cutIntoTiles(drawImage(70, 70, 21, content), GetParam());
        EXPECT_TRUE(set.tiles.empty());
        EXPECT_TRUE(set.vertices.empty());
        EXPECT_TRUE(set.quads.empty());
    }
}

// Little is kept of it: scraps, in coordinates of their own, over several tiles' places.
TEST_P(CutIntoTiles, LittleLeftOfAnImage) {
    for (const double redundant : {0.9, 0.98, 0.999}) {
        const DepthImage image = drawImage(300, 270, 26, {0.1, 0.02, redundant, 0.1});
        expectCutRight(image, GetParam());
        const TileSet set = cutIntoTiles(image, GetParam());
        const bool hasScraps = std::any_of(set.tiles.begin(), set.tiles.end(),
                                           [](const Tile& tile) { return tile.placeBits == kScrapPlaceBits; });
        if (GetParam() < 16) {
            EXPECT_FALSE(hasScraps);
        } else if (redundant > 0.95) {
            EXPECT_TRUE(hasScraps);
        }
    }
}

TEST_P(CutIntoTiles, AllSkinsArePointsWithoutMesh) {
    const DepthImage image = drawImage(70, 70, 22, {0.2, 0.05, 0.2, 1});
    expectCutRight(image, GetParam());
    EXPECT_TRUE(cutIntoTiles(image, GetParam()).quads.empty());
}

// The one kept sample stands on a tile's first corner: its triangles reach into the tiles above and to the
// left, which have nothing else to draw.
TEST_P(CutIntoTiles, OneKeptSampleAmongRedundantOnes) {
    DepthImage image = drawImage(130, 130, 23, {0, 0, 1, 0});
    const int at = GetParam() == 1 ? 64 : GetParam() * (64 / GetParam());
    image.flags(at, at) = 0;
    expectCutRight(image, GetParam());
    EXPECT_EQ(trianglesOf(cutIntoTiles(image, GetParam())).size(), 6u);
}

TEST_P(CutIntoTiles, ExtremeDisparities) {
    constexpr float kTiny = std::numeric_limits<float>::denorm_min();
    for (const auto& [least, most] : {std::pair{0.0f, 0.0f},
                                      {0.0f, 1e4f},
                                      {0.0f, kTiny},
                                      {1.0f, std::nextafter(1.0f, 2.0f)},
                                      {1e-5f, 1e-5f},
                                      {1e3f, 1e3f},
                                      {0.0f, 1e30f}}) {
        SCOPED_TRACE(std::to_string(least) + " to " + std::to_string(most));
        DepthImage image = drawImage(40, 40, 24, {0, 0, 0, 0});
        for (int y = 0; y < 40; ++y)
            for (int x = 0; x < 40; ++x)
                image.disparity(x, y) = (x * 7 + y * 3) % 5 < 2 ? least : most;
        expectCutRight(image, GetParam());
    }
}

// The least of a tile comes back exactly: flat tiles stay flat, infinity stays infinitely far.
TEST_P(CutIntoTiles, LeastDisparityComesBackExactly) {
    const DepthImage image = drawImage(70, 70, 25);
    const TileSet set = cutIntoTiles(image, GetParam());
    for (const Tile& tile : set.tiles)
        for (std::uint32_t i = 0; i < tile.vertexCount; ++i) {
            const TileVertex& vertex = set.vertices[tile.firstVertex + i];
            const auto [x, y] = placeInImage(tile, vertex);
            EXPECT_GE(disparityOf(tile, vertex), tile.minDisparity);
            if (image.disparity(x, y) == tile.minDisparity) {
                EXPECT_EQ(disparityOf(tile, vertex), tile.minDisparity);
            }
        }
}

TEST(BoxAroundSamples, HoldsEachAndTouchesSome) {
    DepthImage image = drawImage(70, 50, 31, {0.3, 0, 0.2, 0.1});
    image.worldFromCamera.translation = {3, -2, 7};
    for (float& disparity : image.disparity.pixels())
        disparity = 0.2f + 0.8f * std::clamp(disparity, 0.f, 1.f); // no sky
    const TileSet set = cutIntoTiles(image);
    const TileBlock block = lend(set, image.camera, image.worldFromCamera);
    glm::dvec3 least(1e9), most(-1e9);
    for (const Tile& tile : set.tiles)
        for (std::uint32_t i = 0; i < tile.vertexCount; ++i) {
            const TileVertex& vertex = set.vertices[tile.firstVertex + i];
            const auto [x, y] = placeInImage(tile, vertex);
            const glm::dvec3 p = image.worldFromCamera * (rayThrough(image.camera, x + 0.5, y + 0.5) /
                                                          static_cast<double>(disparityOf(tile, vertex)));
            least = glm::min(least, p), most = glm::max(most, p);
        }
    const WorldExtent exact = boxAroundSamples(block, 0), wider = boxAroundSamples(block, 0.1);
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(exact.least[axis], least[axis], 1e-9);
        EXPECT_NEAR(exact.most[axis], most[axis], 1e-9);
        EXPECT_LT(wider.least[axis], least[axis]);
        EXPECT_GT(wider.most[axis], most[axis]);
    }
    EXPECT_NEAR(wider.most.z - 7, (most.z - 7) / 0.9, 1e-9) << "by disparity, the farthest goes farther";
    EXPECT_FALSE(boxAroundSamples({}, 0).isFinite()) << "around nothing";
    image.disparity(40, 20) = 0, image.flags(40, 20) = 0;
    const TileSet withSky = cutIntoTiles(image);
    EXPECT_FALSE(boxAroundSamples(lend(withSky, image.camera, image.worldFromCamera), 0).isFinite()) << "sky";
}

INSTANTIATE_TEST_SUITE_P(TileSizes, CutIntoTiles, testing::Values(1, 7, 32, 63), testing::PrintToStringParamName());

} // namespace
} // namespace scene
