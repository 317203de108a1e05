#include "render/draw_list.h"
#include "render/shaders/shared/sample_place.h"
#include "render/shaders/shared/tile_draw.h"
#include "render/shaders/shared/triangle.h"
#include "render/shaders/shared/z_key.h"
#include "scene/tile_warp.h"
#include "tests/render/test_scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>

namespace render {
namespace {

static_assert(kRimShare == scene::kRimShare && kNotDisparity == scene::kNotDisparity,
              "keys of processor and device are alike");
static_assert(kMostPlaceSteps == scene::kMostPlaceSteps);

TEST(SamplePlace, StepsAreThoseOfTheProcessor) {
    EXPECT_EQ(perPixelOf(placeStepsOfPoints().own), scene::kPlaceStepsOfPoint);
    EXPECT_EQ(perPixelOf(placeStepsOfPoints().rim), scene::kPlaceStepsOfRim);
    EXPECT_EQ(perPixelOf(placeStepsOfSplats().own), scene::kPlaceStepsOfSplat);
}

std::uint32_t placeOf(std::uint32_t x, std::uint32_t y, std::uint32_t q) {
    return x | y << 6 | q << 12;
}

TEST(WarpSample, AgreesWithDoublePrecision) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(-1, 1);
    const scene::Camera source = cameraOf(2000, 1000, 1.5), eyeCamera = cameraOf(640, 480, 1.6);
    for (int i = 0; i < 2000; ++i) {
        const glm::dvec3 offset(4.5e5, 5.4e6, 300); // a national grid
        const scene::Pose worldFromSource = poseAt(offset, 3 * unit(random), unit(random));
        const scene::View eye{eyeCamera, poseAt(offset + glm::dvec3(unit(random), unit(random), unit(random)),
                                                3 * unit(random), unit(random))};
        const glm::dmat4 c = scene::eyeImageFromSourceImage(eye, source, worldFromSource);
        ResidentTile tile;
        tile.x0 = static_cast<int>(1900 * std::abs(unit(random))),
        tile.y0 = static_cast<int>(900 * std::abs(unit(random)));
        tile.minDisparity = 0.2f, tile.maxDisparity = 0.9f;
        const TileDraw draw = tileDrawOf(c, tile);

        const std::uint32_t most = scene::maxQuantisedOf(scene::kPlaceBits);
        const auto below = [&](std::uint32_t end) { return static_cast<std::uint32_t>(random() % end); };
        const std::uint32_t x = below(64), y = below(64), q = below(most + 1);
        const vec4 h = warpSample(draw, placeOf(x, y, q));
        const double d = tile.minDisparity + q * (0.9 * 1.0f - 0.2) / most;
        const glm::dvec4 truth = c * glm::dvec4(tile.x0 + x + 0.5, tile.y0 + y + 0.5, 1, d);
        if (truth.z < 0.05) continue;
        ASSERT_TRUE(isBeforeEye(h));
        const vec3 seen = project(h);
        // The larger a position, the coarser its last bit; w, too, is a difference of larger numbers.
        const double tolerance = 1e-6 * (1 + (std::abs(truth.x) + std::abs(truth.y) + 2000) / truth.z) / truth.z;
        EXPECT_NEAR(seen.x, truth.x / truth.z, tolerance);
        EXPECT_NEAR(seen.y, truth.y / truth.z, tolerance);
        EXPECT_NEAR(seen.z * truth.z / truth.w, 1, 1e-5 / truth.z);
    }
}

TEST(WarpSample, BehindAndOnTheEyePlaneIsRejected) {
    EXPECT_FALSE(isBeforeEye(vec4(1, 1, -0.1f, 1)));
    EXPECT_FALSE(isBeforeEye(vec4(1, 1, 0, 1)));
    EXPECT_FALSE(isBeforeEye(vec4(1, 1, 1e-6f, 1))) << "a micrometre before the eye";
    EXPECT_TRUE(isBeforeEye(vec4(1, 1, 1e-4f, 1))) << "a tenth of a millimetre before the eye";
    EXPECT_TRUE(isBeforeEye(vec4(1, 1, 1, 0))) << "sky";
}

TEST(Footprint, IsCentredOnThePosition) {
    EXPECT_EQ(firstOfFootprint(3.0f, 1), 3);
    EXPECT_EQ(firstOfFootprint(3.99f, 1), 3);
    EXPECT_EQ(firstOfFootprint(3.4f, 2), 2);
    EXPECT_EQ(firstOfFootprint(3.6f, 2), 3);
    EXPECT_EQ(firstOfFootprint(3.4f, 3), 2);
    EXPECT_EQ(firstOfFootprint(-0.2f, 1), -1);
}

TEST(ZKey, OrdersByDisparityAndKeepsColourAndClass) {
    const auto word = [](uvec2 key) { return std::uint64_t{key.y} << 32 | key.x; };
    const std::uint64_t sky = word(packKey(0, 0, kClassSeen)),
                        far = word(packKey(0.01f, 0xffffff, 63 << 2 | kClassUnseen)),
                        near = word(packKey(100, 0, kClassSeen));
    EXPECT_LT(0u, sky) << "sky stands before nothing";
    EXPECT_LT(sky, far);
    EXPECT_LT(far, near);
    const uvec2 key = packKey(0.25f, 0xab123456u, kClassSeen);
    EXPECT_EQ(colourAndClassOf(key), 0x01123456u) << "flags do not leak into the class";
    EXPECT_EQ(depthOf(key), 4.0f);
    for (uint level = 0; level <= 63; ++level) {
        const float order = 0.25f / scene::orderScale(static_cast<int>(level));
        const uvec2 pushed = packKey(order, 0x123456u, level << 2 | kClassSeen);
        EXPECT_NEAR(depthOf(pushed) / 4.0f, 1, 4e-6f) << "level " << level << " is taken back";
        EXPECT_EQ(colourAndClassOf(pushed), 0x01123456u);
    }
    EXPECT_EQ(depthOf(uvec2(0, 0)), 0.0f);
    EXPECT_TRUE(std::isinf(depthOf(packKey(0, 5, kClassSeen))));
}

TEST(TriangleCover, AgreesWithBarycentricCoordinates) {
    std::mt19937 random(11);
    std::uniform_real_distribution<float> place(-20, 60), depth(0.1f, 2);
    int inside = 0;
    for (int i = 0; i < 20000; ++i) {
        const vec3 a(place(random), place(random), depth(random)), b(place(random), place(random), depth(random)),
            c(place(random), place(random), depth(random));
        const vec2 origin(10.5f, 7.5f), offset(std::floor(place(random)), std::floor(place(random)));
        const Covered covered = cover(setUp(a, b, c, origin), a, b, c, offset);

        const glm::dvec2 p(origin + offset), da(a.x, a.y), db(b.x, b.y), dc(c.x, c.y);
        const auto twice = [](glm::dvec2 s, glm::dvec2 t, glm::dvec2 r) {
            return (t.x - s.x) * (r.y - s.y) - (t.y - s.y) * (r.x - s.x);
        };
        const double area = twice(da, db, dc);
        const double ofA = twice(db, dc, p) / area, ofB = twice(dc, da, p) / area, ofC = twice(da, db, p) / area;
        const double least = std::min({ofA, ofB, ofC});
        if (std::abs(area) < 10 || std::abs(least) < 0.01) continue;
        ASSERT_EQ(covered.disparity >= 0, least > 0) << i;
        if (least <= 0) continue;
        ++inside;
        EXPECT_NEAR(covered.disparity, ofA * a.z + ofB * b.z + ofC * c.z, 1e-4);
    }
    EXPECT_GT(inside, 1000);
}

TEST(TriangleCover, FatEdgesReachASixtyFourthOfAPixelAndNotTwoOfThem) {
    // Legs of 10 pixels along the grid, and the same turned round.
    const vec3 a(10, 10, 1), b(20, 10, 1), c(10, 20, 1);
    for (const auto& [p, q] : {std::pair(b, c), std::pair(c, b)})
        for (const float outside : {0.9f, 1.1f}) {
            const bool isCovered = outside < 1;
            const float by = outside * kFatEdge;
            EXPECT_EQ(cover(setUp(a, p, q, vec2(15, 10 - by)), a, p, q, vec2(0)).disparity >= 0, isCovered);
            EXPECT_EQ(cover(setUp(a, p, q, vec2(10 - by, 15)), a, p, q, vec2(0)).disparity >= 0, isCovered);
            // On the diagonal a little farther: its length is taken as the sum of the legs.
            EXPECT_EQ(cover(setUp(a, p, q, vec2(15 + by, 15 + by)), a, p, q, vec2(0)).disparity >= 0, isCovered);
        }
}

TEST(TriangleCover, WithoutAreaNothingIsCovered) {
    const vec3 a(1, 1, 1), b(5, 5, 1), c(3, 3, 1);
    for (float x = 0; x < 6; ++x)
        EXPECT_LT(cover(setUp(a, b, c, vec2(0.5f, 0.5f)), a, b, c, vec2(x, x)).disparity, 0);
    EXPECT_LT(cover(setUp(a, a, a, vec2(1)), a, a, a, vec2(0)).disparity, 0);
}

TEST(MixColours, IsWithinOneStep) {
    std::mt19937 random(17);
    std::uniform_real_distribution<float> share(0, 1);
    for (int i = 0; i < 20000; ++i) {
        const std::uint32_t a = static_cast<std::uint32_t>(random()), b = static_cast<std::uint32_t>(random()),
                            c = static_cast<std::uint32_t>(random());
        const float ofB = share(random), ofC = share(random) * (1 - ofB);
        const std::uint32_t mixed = mixColours(a, b, c, ofB, ofC);
        EXPECT_EQ(mixed >> 24, 0u);
        for (int shift = 0; shift < 24; shift += 8) {
            const auto at = [&](std::uint32_t v) { return static_cast<double>(v >> shift & 255u); };
            EXPECT_NEAR(at(mixed), at(a) + ofB * (at(b) - at(a)) + ofC * (at(c) - at(a)), 1.6);
        }
    }
    EXPECT_EQ(mixColours(0xff112233u, 1, 2, 0, 0), 0x112233u) << "at a corner its colour is exact";
    EXPECT_EQ(mixColours(1, 0xff112233u, 2, 1, 0), 0x112233u);
    EXPECT_EQ(mixColours(1, 2, 0xff112233u, -0.01f, 1.01f), 0x112233u);
    EXPECT_EQ(mixColours(0xffffffu, 0xffffffu, 0xffffffu, 0.3f, 0.3f), 0xffffffu);
}

TEST(PixelsOf, IsClippedToTheScreenHoweverFarOutside) {
    const PixelBox all = pixelsOf(vec2(-1e30f), vec2(1e30f), vec2(640, 480));
    EXPECT_EQ(all.first, ivec2(0, 0));
    EXPECT_EQ(all.last, ivec2(639, 479));
    const PixelBox none = pixelsOf(vec2(1e20f), vec2(2e20f), vec2(640, 480));
    EXPECT_LT(none.last.x, none.first.x);
    const PixelBox one = pixelsOf(vec2(3.4f, 7.4f), vec2(3.6f, 7.6f), vec2(640, 480));
    EXPECT_EQ(one.first, ivec2(3, 7));
    EXPECT_EQ(one.last, ivec2(3, 7));
    const PixelBox between = pixelsOf(vec2(3.6f, 7.6f), vec2(4.4f, 8.4f), vec2(640, 480));
    EXPECT_LT(between.last.x, between.first.x) << "no pixel centre inside";
}

} // namespace
} // namespace render
