#include "scene/footprint.h"
#include "scene/warp.h"

#include "tests/scene/known_scenes.h"
#include "tests/scene/random_poses.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace scene {
namespace {

enum class Way { points, mesh };

WarpOptions plainOrder() {
    WarpOptions options;
    options.preference.nearBaseline = 0;
    return options;
}

ZBuffer warp(Way way, std::span<const TileBlock> blocks, const View& eye, const WarpOptions& options) {
    ZBuffer zBuffer(eye.camera.width, eye.camera.height, 0);
    (way == Way::points ? warpPoints : warpMesh)(blocks, eye, options, zBuffer);
    return zBuffer;
}

/// One image, cut and warped.
EyeImage warpOne(Way way, const DepthImage& image, const View& eye, const WarpOptions& options,
                 int tileSize = kDefaultTileSize) {
    const TileSet set = cutIntoTiles(image, tileSize);
    const TileBlock block = lend(set, image.camera, image.worldFromCamera);
    return resolve(warp(way, {&block, 1}, eye, options));
}

std::string at(int x, int y) {
    return "at (" + std::to_string(x) + ", " + std::to_string(y) + ")";
}

class Warp : public testing::TestWithParam<Way> {};

constexpr float kKeyRounding = 4e-6f; ///< of a key's disparity, relative (scene/tile_warp.h)

TEST_P(Warp, IntoItsOwnCameraIsTheImage) {
    const DepthImage image = imagesOfBareRoom(3).at(1);
    const auto [least, most] = std::minmax_element(image.disparity.pixels().begin(), image.disparity.pixels().end());
    const float step = (*most - *least) / static_cast<float>(maxQuantisedOf(kPlaceBits));
    const EyeImage eye = warpOne(GetParam(), image, {image.camera, image.worldFromCamera}, plainOrder());
    // The mesh ends at the outermost samples: whether their own pixels are covered is a matter of rounding.
    const int rim = GetParam() == Way::mesh ? 1 : 0;
    // A vertex is off its pixel's centre by rounding; the triangle that leans towards the eye most wins there.
    const float lean = GetParam() == Way::mesh ? 1e-4f * (*most - *least) : 0;
    for (int y = rim; y < image.camera.height - rim; ++y)
        for (int x = rim; x < image.camera.width - rim; ++x) {
            ASSERT_EQ(eye.pixelClass(x, y), static_cast<int>(PixelClass::seen)) << at(x, y);
            const float d = image.disparity(x, y);
            ASSERT_NEAR(1 / eye.depthMetres(x, y), d, 0.5f * step + lean + (kKeyRounding + 5e-7f) * d) << at(x, y);
            ASSERT_TRUE(eye.colour(x, y) == image.colour(x, y)) << at(x, y);
        }
}

TEST_P(Warp, GivesTheSameBytesOnOneThreadAndOnTwo) {
    const std::vector<DepthImage> images = imagesOfBareRoom(4);
    std::vector<TileSet> sets;
    std::vector<TileBlock> blocks;
    for (const DepthImage& image : images)
        sets.push_back(cutIntoTiles(image, 16));
    for (std::size_t i = 0; i < images.size(); ++i)
        blocks.push_back(lend(sets[i], images[i].camera, images[i].worldFromCamera));
    WarpOptions options;
    options.maxFootprint = 4;
    const View eye = viewFrom({1.5, 1.5, 1.6}, {4, 3, 1});
    const auto drawnBy = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return warp(GetParam(), blocks, eye, options);
    };
    const ZBuffer one = drawnBy(1);
    EXPECT_GT(std::count_if(one.pixels().begin(), one.pixels().end(), [](std::uint64_t key) { return key != 0; }),
              4000);
    for (int run = 0; run < 3; ++run)
        EXPECT_TRUE(drawnBy(2) == one) << "run " << run;
    std::reverse(blocks.begin(), blocks.end());
    EXPECT_TRUE(drawnBy(2) == one) << "the order of drawing shows";
}

// A sample on the camera's axis, seen from 0.1 mm before it: one triangle is larger than the eye's image.
TEST_P(Warp, SeesASurfaceFromATenthOfAMillimetre) {
    const Camera camera{64, 64, 60, 60, 32.5, 32.5};
    const DepthImage wall = imageOf(camera, {}, [](double, double) { return 1.0; });
    const View eye{{40, 40, 40, 40, 20.5, 20.5}, {glm::dmat3(1.0), {0, 0, 1 - 1e-4}}};
    const EyeImage seen = warpOne(GetParam(), wall, eye, plainOrder());
    if (GetParam() == Way::points) {
        EXPECT_NEAR(seen.depthMetres(20, 20), 1e-4f, 1e-6f);
        EXPECT_EQ(std::count(seen.pixelClass.pixels().begin(), seen.pixelClass.pixels().end(), 1), 1)
            << "the others are beside";
        return;
    }
    for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 40; ++x) {
            ASSERT_EQ(seen.pixelClass(x, y), 1) << at(x, y);
            ASSERT_NEAR(seen.depthMetres(x, y), 1e-4f, 1e-6f) << at(x, y);
            ASSERT_TRUE((seen.colour(x, y) == Rgb8{200, 100, 50})) << at(x, y);
        }
}

TEST_P(Warp, DrawsNothingThatIsBehindOrTooNear) {
    const DepthImage wall = imageOf({64, 64, 60, 60, 32.5, 32.5}, {}, [](double, double) { return 1.0; });
    for (const double z : {1 - 1e-6, 1.0, 1 + 1e-6, 1 + 1e-4, 2.0, 1e6}) {
        const EyeImage seen = warpOne(GetParam(), wall, {wall.camera, {glm::dmat3(1.0), {0, 0, z}}}, plainOrder());
        const auto drawn = std::count_if(seen.pixelClass.pixels().begin(), seen.pixelClass.pixels().end(),
                                         [](auto c) { return c != 0; });
        EXPECT_EQ(drawn, 0) << "from z = " << z;
    }
}

TEST_P(Warp, SkyIsBehindEverythingAndDoesNotMove) {
    const Camera camera = smallCamera();
    const Rgb8 blue{10, 20, 250}, brown{120, 80, 40};
    DepthImage sky = imageOf(
        camera, {}, [](double, double) { return 0.0; }, blue);
    sky.colour(100, 50) = {255, 255, 255};
    const DepthImage hill = imageOf(
        camera, {}, [](double, double) { return 1e-6; }, brown);
    const TileSet skySet = cutIntoTiles(sky), hillSet = cutIntoTiles(hill);
    const TileBlock skyBlock = lend(skySet, camera, {}), hillBlock = lend(hillSet, camera, {});

    const View farAside{camera, {glm::dmat3(1.0), {300, -200, 1000}}};
    const EyeImage alone = resolve(warp(GetParam(), {&skyBlock, 1}, farAside, plainOrder()));
    for (int y = 1; y + 1 < camera.height; ++y)
        for (int x = 1; x + 1 < camera.width; ++x) {
            ASSERT_EQ(alone.pixelClass(x, y), 1) << at(x, y);
            ASSERT_TRUE(std::isinf(alone.depthMetres(x, y))) << at(x, y);
            ASSERT_TRUE(alone.colour(x, y) == sky.colour(x, y)) << at(x, y) << ": the sky moved";
        }
    for (const bool skyFirst : {true, false}) {
        const std::vector<TileBlock> both =
            skyFirst ? std::vector{skyBlock, hillBlock} : std::vector{hillBlock, skyBlock};
        const EyeImage seen = resolve(warp(GetParam(), both, {camera, {}}, plainOrder()));
        for (int y = 1; y + 1 < camera.height; ++y)
            for (int x = 1; x + 1 < camera.width; ++x)
                ASSERT_TRUE(seen.colour(x, y) == brown) << at(x, y) << ", 1000 km away";
    }
}

TEST_P(Warp, DepthIsTheMeasuredOneAtEveryOrderLevel) {
    const Camera camera{64, 64, 60, 60, 32, 32};
    const DepthImage wall = imageOf(camera, {}, [](double, double) { return 0.5; });
    const TileSet set = cutIntoTiles(wall, 63); // one large tile, and slivers beside it
    WarpOptions options;
    options.preference = {0.5f, 62};
    std::set<int> levels;
    for (int i = 0; i <= 130; ++i) {
        const View eye{camera, {glm::dmat3(1.0), {i * 0.01, 0, 0}}};
        const auto level = orderLevelOf(set.tiles[0], camera, {}, eye, options.preference);
        ASSERT_TRUE(level && *level >= 0 && *level <= kMaxOrderLevel) << "eye " << i;
        levels.insert(*level);
        const EyeImage seen = resolve(warp(GetParam(), std::vector{lend(set, camera, {})}, eye, options));
        int drawn = 0;
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 64; ++x) {
                if (seen.pixelClass(x, y) == 0) continue;
                ++drawn;
                ASSERT_NEAR(seen.depthMetres(x, y), 2.f, 2.f * kKeyRounding + 2e-6f)
                    << at(x, y) << " at level " << *level;
                ASSERT_TRUE(seen.colour(x, y) == wall.colour(0, 0)) << at(x, y) << " at level " << *level;
            }
        EXPECT_GT(drawn, 1000) << "eye " << i;
    }
    EXPECT_GE(levels.size(), 55u) << "not enough levels were tried";
    EXPECT_TRUE(levels.contains(0) && levels.contains(kMaxOrderLevel));
}

TEST_P(Warp, ShowsTheSampleTakenNearTheEyeUnlessAnotherIsFarBeforeIt) {
    const Camera camera = smallCamera();
    const Rgb8 red{250, 0, 0}, green{0, 250, 0};
    const DepthImage mine = imageOf(
        camera, {}, [](double, double) { return 0.5; }, red);
    const auto centreWith = [&](double otherDepth, WarpOptions options) {
        options.maxFootprint = 4;
        // Its camera stands 1 m nearer to the wall: far from the eye by the default share.
        const DepthImage other = imageOf(
            camera, {glm::dmat3(1.0), {0, 0, -1}}, [&](double, double) { return 1 / (otherDepth + 1); }, green);
        const TileSet a = cutIntoTiles(mine), b = cutIntoTiles(other);
        const EyeImage seen =
            resolve(warp(GetParam(), std::vector{lend(a, camera, {}), lend(b, camera, other.worldFromCamera)},
                         {camera, {}}, options));
        return std::pair(seen.colour(80, 60), seen.depthMetres(80, 60));
    };
    EXPECT_TRUE(centreWith(1.9, {}).first == red) << "of two samples of one surface the near camera's";
    EXPECT_NEAR(centreWith(1.9, {}).second, 2.0f, 1e-5f);
    EXPECT_TRUE(centreWith(0.9, {}).first == green) << "a surface before it hides it";
    EXPECT_NEAR(centreWith(0.9, {}).second, 0.9f, 1e-5f);
    EXPECT_TRUE(centreWith(1.9, plainOrder()).first == green) << "plain z order shows the nearest";
}

INSTANTIATE_TEST_SUITE_P(Ways, Warp, testing::Values(Way::points, Way::mesh),
                         [](const auto& instance) { return instance.param == Way::points ? "Points" : "Mesh"; });

/// Where a stored sample is seen, in double precision and by the words of the papers alone.
struct Truth {
    double u, v, disparity;
    std::uint32_t colour;
};
std::vector<Truth> projectAll(const TileSet& set, const DepthImage& image, const View& eye) {
    const Pose eyeFromCamera = inverse(eye.worldFromEye) * image.worldFromCamera;
    std::vector<Truth> all;
    for (const Tile& tile : set.tiles)
        for (const TileVertex& vertex : std::span(set.vertices).subspan(tile.firstVertex, tile.pointCount)) {
            const double d = tile.minDisparity + placeOf(tile, vertex).q *
                                                     (static_cast<double>(tile.maxDisparity) - tile.minDisparity) /
                                                     maxQuantisedOf(tile);
            const double x = tile.x0 + placeOf(tile, vertex).x + 0.5, y = tile.y0 + placeOf(tile, vertex).y + 0.5;
            const glm::dvec3 pInEye = eyeFromCamera * (rayThrough(image.camera, x, y) / d);
            if (pInEye.z <= kNearMetres) continue;
            const glm::dvec2 uv = project(eye.camera, pInEye);
            all.push_back({uv.x, uv.y, 1 / pInEye.z, vertex.colour});
        }
    return all;
}

void expectPointsAreWhereDoublePrecisionPutsThem(const DepthImage& image, const View& eye) {
    const TileSet set = cutIntoTiles(image);
    const EyeImage seen =
        resolve(warp(Way::points, std::vector{lend(set, image.camera, image.worldFromCamera)}, eye, plainOrder()));
    constexpr double kPixel = 2e-3, kRelative = 1e-5;
    Image<double> least(eye.camera.width, eye.camera.height, 0.0);
    Image<std::vector<double>> possible(eye.camera.width, eye.camera.height);
    int inside = 0;
    for (const Truth& truth : projectAll(set, image, eye)) {
        const auto cell = [&](double u, double v) { return std::pair(std::floor(u), std::floor(v)); };
        std::set<std::pair<double, double>> cells;
        for (const double du : {-kPixel, kPixel})
            for (const double dv : {-kPixel, kPixel})
                cells.insert(cell(truth.u + du, truth.v + dv));
        for (const auto& [u, v] : cells) {
            if (u < 0 || v < 0 || u >= eye.camera.width || v >= eye.camera.height) continue;
            const int x = static_cast<int>(u), y = static_cast<int>(v);
            possible(x, y).push_back(truth.disparity);
            if (cells.size() > 1) continue;
            least(x, y) = std::max(least(x, y), truth.disparity);
            ++inside;
        }
    }
    ASSERT_GT(inside, 1000) << "the eye looks elsewhere";
    for (int y = 0; y < eye.camera.height; ++y)
        for (int x = 0; x < eye.camera.width; ++x) {
            const double d = seen.pixelClass(x, y) ? 1.0 / static_cast<double>(seen.depthMetres(x, y)) : 0.0;
            ASSERT_GE(d, least(x, y) * (1 - kRelative)) << at(x, y) << ": the nearest sample is not shown";
            if (d == 0) continue;
            const auto fits = [&](double truth) { return std::abs(truth - d) <= kRelative * d; };
            ASSERT_TRUE(std::any_of(possible(x, y).begin(), possible(x, y).end(), fits))
                << at(x, y) << ": depth of no sample";
        }
}

TEST(WarpPoints, AgreeWithEachSampleProjectedInDoublePrecision) {
    const DepthImage image = imagesOfBareRoom(5).at(2);
    for (const View& eye :
         {viewFrom({1, 1, 1.6}, {4, 3, 1}), viewFrom({4.8, 3.9, 2.2}, {2, 2, 0.4}, {200, 90, 70, 110, 70.25, 60.5}),
          viewFrom({3.9, 2.4, 1.1}, {1, 2.2, 1})})
        expectPointsAreWhereDoublePrecisionPutsThem(image, eye);
}

TEST(WarpPoints, AreAsExactTenThousandKilometresFromTheOrigin) {
    DepthImage image = imagesOfBareRoom(5).at(2);
    View eye = viewFrom({1, 1, 1.6}, {4, 3, 1});
    image.worldFromCamera.translation += kFarFromOrigin;
    eye.worldFromEye.translation += kFarFromOrigin;
    expectPointsAreWhereDoublePrecisionPutsThem(image, eye);
}

TEST(WarpPoints, FootprintCoversWhatTheSampleCovers) {
    const Camera camera = smallCamera();
    const DepthImage wall = imageOf(camera, {}, [](double, double) { return 0.5; });
    WarpOptions options = plainOrder();
    options.maxFootprint = 8;
    for (const auto& [z, side] : {std::pair{0.0, 1}, {1.0, 2}, {1.4, 4}, {1.7, 7}, {1.95, 8}}) {
        const View eye{camera, {glm::dmat3(1.0), {0, 0, z}}};
        const TileSet set = cutIntoTiles(wall);
        EXPECT_EQ(
            footprintOf(boxInEye(eyeImageFromSourceImage(eye, camera, {}), boxOf(set.tiles[7], camera)).sampleWidth, 1,
                        8),
            side)
            << "from z = " << z;
        const EyeImage seen = warpOne(Way::points, wall, eye, options);
        if (side == 8) continue; // the most that was allowed does not cover
        EXPECT_EQ(std::count(seen.pixelClass.pixels().begin(), seen.pixelClass.pixels().end(), 0), 0)
            << "holes from z = " << z;
    }
}

/// Every pixel within the outline of the samples' rectangle, drawn in by a margin, must be drawn.
void expectNoHole(const DepthImage& wall, const View& eye, int tileSize, double margin) {
    const EyeImage seen = warpOne(Way::mesh, wall, eye, plainOrder(), tileSize);
    int within = 0;
    for (int y = 0; y < eye.camera.height; ++y)
        for (int x = 0; x < eye.camera.width; ++x) {
            if (seen.pixelClass(x, y) == 1) {
                ++within;
                continue;
            }
            // A hole: where its ray meets the wall z = 2 m must be outside the image.
            const glm::dvec3 origin = eye.worldFromEye.translation;
            const glm::dvec3 ray = eye.worldFromEye.rotation * rayThrough(eye.camera, x + 0.5, y + 0.5);
            const double t = (2 - origin.z) / ray.z;
            const glm::dvec2 uv = project(wall.camera, origin + t * ray);
            const bool isInside = t > 0 && uv.x > 0.5 + margin && uv.y > 0.5 + margin &&
                                  uv.x < wall.camera.width - 0.5 - margin && uv.y < wall.camera.height - 0.5 - margin;
            ASSERT_FALSE(isInside) << "hole " << at(x, y) << ", tiles of " << tileSize << ", sample (" << uv.x << ", "
                                   << uv.y << ")";
        }
    ASSERT_GT(within, 500);
}

// Shifted by (s, -s) pixels, every diagonal of the mesh runs through centres of pixels; shifted by halves, every edge
// does.
TEST(WarpMesh, IsWatertightWhereEdgesRunThroughPixelCentres) {
    const Camera camera = smallCamera();
    const DepthImage wall = imageOf(camera, {}, [](double, double) { return 0.5; });
    RandomPlaces random(3);
    for (int i = 0; i < 40; ++i) {
        const double s = i == 0 ? 0.5 : random.between(-3, 3), depthPerPixel = 2 / camera.fx;
        const View eye{camera, {glm::dmat3(1.0), {s * depthPerPixel, (i % 2 ? -s : s) * depthPerPixel, 0}}};
        SCOPED_TRACE("shift " + std::to_string(s));
        expectNoHole(wall, eye, i % 3 == 0 ? 7 : 32, 1e-3);
    }
}

TEST(WarpMesh, IsWatertightBetweenTilesFromAnywhere) {
    const DepthImage wall = imageOf(smallCamera(), {}, [](double, double) { return 0.5; });
    RandomPlaces random(4);
    for (int i = 0; i < 24; ++i) {
        const glm::dvec3 from(random.between(-1, 1), random.between(-1, 1), random.between(0, 1.7));
        const glm::dvec3 forward =
            glm::normalize(glm::dvec3(random.between(-0.4, 0.4), random.between(-0.3, 0.3), 2) - from);
        const double roll = random.between(-3, 3);
        const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(std::sin(roll), std::cos(roll), 0), forward));
        const View eye{smallCamera(), {glm::dmat3(right, glm::cross(forward, right), forward), from}};
        SCOPED_TRACE("eye " + std::to_string(i));
        expectNoHole(wall, eye, i % 2 ? 5 : 32, 1e-3);
    }
}

TEST(WarpMesh, LeavesSkinsOut) {
    const Camera camera = smallCamera();
    const auto step = [](double x, double) { return x < 80 ? 1.0 : 0.25; }; // 1 m, beyond 4 m
    DepthImage image = imageOf(camera, {}, step);
    const View aside{camera, {glm::dmat3(1.0), {0.2, 0, 0}}};
    const auto between = [&](const DepthImage& drawn) {
        const EyeImage seen = warpOne(Way::mesh, drawn, aside, plainOrder());
        return std::count_if(seen.depthMetres.pixels().begin(), seen.depthMetres.pixels().end(),
                             [](float z) { return z > 1.001f && z < 3.999f; });
    };
    EXPECT_GT(between(image), 500) << "the false surface is not even there";
    for (int y = 0; y < camera.height; ++y)
        image.flags(79, y) = kSkinUpper | kSkinLower;
    EXPECT_EQ(between(image), 0);
}

} // namespace
} // namespace scene
