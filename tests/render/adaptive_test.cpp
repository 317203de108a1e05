// The adaptive mesh and levels of detail: against the mesh, against the shared shader code run on the processor, and
// never a hole where one level passes into another.

#include "render/shaders/shared/detail.h"
#include "render/shaders/shared/facet.h"
#include "render/shaders/shared/z_key.h"
#include "scene/pyramid.h"
#include "tests/render/test_device.h"
#include "tests/render/test_scenes.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace render {
namespace {

class AdaptiveTest : public RenderTest {};

Quality plainQuality(Warp warp, double samplePixels = 0) {
    Quality quality;
    quality.warp = warp;
    quality.samplePixels = samplePixels;
    return quality;
}

double coveredPsnr(const EyeImage& a, const EyeImage& b) {
    double sum = 0, count = 0;
    for (int y = 0; y < a.colour.height(); ++y)
        for (int x = 0; x < a.colour.width(); ++x) {
            if (a.pixelClass(x, y) == 0 || b.pixelClass(x, y) == 0) continue;
            const scene::Rgb8 p = a.colour(x, y), q = b.colour(x, y);
            sum += (p.r - q.r) * (p.r - q.r) + (p.g - q.g) * (p.g - q.g) + (p.b - q.b) * (p.b - q.b);
            count += 3;
        }
    return 10 * std::log10(255.0 * 255.0 * count / std::max(sum, 1e-9));
}

TEST_F(AdaptiveTest, ShowsWhatTheMeshShows) {
    const CutScene room = cutInLevels({roomFromThreePlaces()[0]});
    const GpuScene scene(testDevice(), room.blocks());
    Painter paint(scene, cameraOf(320, 240, 1.3));
    for (const double x : {-0.2, 0.0, 0.3}) {
        const scene::View eye{cameraOf(320, 240, 1.3), poseAt({x, 0.02, 0.15}, 0.3 * x, 0.1)};
        const EyeImage mesh = paint(eye, plainQuality(Warp::mesh));
        const EyeImage adaptive = paint(eye, plainQuality(Warp::adaptive));
        EXPECT_GE(coveredPsnr(mesh, adaptive), 34) << "eye at " << x;
        EXPECT_GE(coverage(adaptive), coverage(mesh) - 0.002) << "eye at " << x;
    }
}

TEST_F(AdaptiveTest, CoarserLevelsAreSeenAsByTheirOwnCameras) {
    const CutScene room = cutInLevels({roomFromThreePlaces()[0], roomFromThreePlaces()[1]});
    const GpuScene scene(testDevice(), room.blocks());
    const scene::View eye{cameraOf(321, 241, 1.3), poseAt({0.123, 0.02, 0.15}, 0.37, 0.1)};
    const auto sources = sourceViewsOf(scene.images(), eye, {});
    std::uint32_t coarsest = 0;
    for (std::size_t i = 0; i < sources.size(); ++i) {
        const ResidentImage& image = scene.images()[i];
        EXPECT_EQ(sources[i].eyeImageFromSource,
                  scene::eyeImageFromSourceImage(eye, image.camera, image.worldFromCamera))
            << i;
        EXPECT_EQ(sources[i].pixelsPerSample,
                  std::sqrt(eye.camera.fx * eye.camera.fy / (image.camera.fx * image.camera.fy)))
            << i;
        coarsest = std::max(coarsest, image.level);
    }
    EXPECT_GE(coarsest, 2u);
}

/// The facets of a scene by the shader's own functions, one after another.
scene::Image<std::uint64_t> facetsOnProcessor(const CutScene& cut, const GpuScene& scene, const scene::View& eye) {
    scene::Image<std::uint64_t> keys(eye.camera.width, eye.camera.height, 0);
    const auto sources = sourceViewsOf(scene.images(), eye, {});
    std::size_t number = 0;
    for (const scene::TileSet& set : cut.sets)
        for (const scene::Tile& tile : set.tiles) {
            const ResidentTile& resident = scene.tiles()[number++];
            const TileDraw draw = tileDrawOf(sources[resident.image].eyeImageFromSource, resident);
            for (std::uint32_t f = tile.firstFacet; f < tile.firstFacet + tile.facetCount; ++f) {
                const scene::TileFacet& stored = set.facets[f];
                const Facet facet = facetOf(draw, stored.mark, stored.q, stored.perX, stored.perY);
                const PixelBox box = boxOf(facet, vec2(eye.camera.width, eye.camera.height));
                const FacetView view = turnRound(facet, vec2(box.first) + 0.5f);
                for (int y = box.first.y; y <= box.last.y; ++y)
                    for (int x = box.first.x; x <= box.last.x; ++x) {
                        const FacetSight sight = look(facet, view, vec2(x - box.first.x, y - box.first.y));
                        if (sight.disparity < 0) continue;
                        const float most = facet.side - 1;
                        const float left = clamp(floor(sight.x), 0.0f, most), top = clamp(floor(sight.y), 0.0f, most);
                        const auto texel = [&](int down) {
                            const auto row = static_cast<std::size_t>(stored.mark >> 6 & 63u) +
                                             static_cast<std::size_t>(top) + static_cast<std::size_t>(down);
                            return set.texels[tile.firstTexel + row * (tile.width + 1u) + (stored.mark & 63u) +
                                              static_cast<std::size_t>(left)];
                        };
                        const uint ofRight = shareOf256(sight.x - left);
                        const uint colour =
                            mixTwo(mixTwo(texel(0).here, texel(0).right, ofRight),
                                   mixTwo(texel(1).here, texel(1).right, ofRight), shareOf256(sight.y - top));
                        const uvec2 key = packKey(sight.disparity, colour, kClassSeen);
                        keys(x, y) = std::max(keys(x, y), std::uint64_t{key.y} << 32 | key.x);
                    }
            }
        }
    return keys;
}

TEST_F(AdaptiveTest, FacetsAreThoseOfTheProcessor) {
    const CutScene plane = cutInLevels({takePlane(cameraOf(225, 161, 1.2), {0.3, 0.2, 1}, 2)});
    const GpuScene scene(testDevice(), plane.blocks());
    for (const scene::Tile& tile : plane.sets[0].tiles)
        ASSERT_TRUE(tile.facetCount > 0 || tile.quadCount == 0) << "else this test would see only a part";
    for (const double x : {-0.4, 0.0, 0.7}) {
        const scene::View eye{cameraOf(200, 150, 1.3), poseAt({x, 0.1, 0.3}, -0.4 * x, 0.05)};
        const EyeImage device = drawOnce(scene, eye, plainQuality(Warp::adaptive));
        const scene::Image<std::uint64_t> keys = facetsOnProcessor(plane, scene, eye);
        int differ = 0, covered = 0;
        for (int v = 0; v < 150; ++v)
            for (int u = 0; u < 200; ++u) {
                const uvec2 key(static_cast<uint>(keys(u, v)), static_cast<uint>(keys(u, v) >> 32));
                const scene::Rgb8 c = device.colour(u, v);
                const uint shown = c.r | static_cast<uint>(c.g) << 8 | static_cast<uint>(c.b) << 16 |
                                   static_cast<uint>(device.pixelClass(u, v)) << 24;
                covered += keys(u, v) != 0;
                differ += shown != colourAndClassOf(key);
            }
        EXPECT_GT(covered, 10000);
        EXPECT_LE(differ, 30) << "eye at " << x;
    }
}

TEST_F(AdaptiveTest, FromItsOwnCameraAPlaneComesBack) {
    const scene::DepthImage taken = takePlane(cameraOf(130, 98, 1.2), {0.3, 0.2, 1}, 2);
    const CutScene plane = cutInLevels({taken});
    const GpuScene scene(testDevice(), plane.blocks());
    const EyeImage seen = drawOnce(scene, {taken.camera, taken.worldFromCamera}, plainQuality(Warp::adaptive));
    for (int y = 0; y < 98; ++y)
        for (int x = 0; x < 130; ++x) {
            ASSERT_EQ(seen.pixelClass(x, y), kClassSeen) << x << " " << y;
            EXPECT_LE(std::abs(seen.colour(x, y).r - taken.colour(x, y).r), 1);
            EXPECT_LE(std::abs(seen.colour(x, y).g - taken.colour(x, y).g), 1);
            EXPECT_NEAR(seen.depthMetres(x, y) * taken.disparity(x, y), 1, 1e-4);
        }
}

/// Pixels that look at the middle of a plane before the eye but see nothing.
int holesIn(const EyeImage& image, double share) {
    int holes = 0;
    const int width = image.colour.width(), height = image.colour.height();
    const int left = static_cast<int>(width * (0.5 - share / 2)), top = static_cast<int>(height * (0.5 - share / 2));
    for (int y = top; y < height - top; ++y)
        for (int x = left; x < width - left; ++x)
            holes += image.pixelClass(x, y) == kClassBackground;
    return holes;
}

// A wall 2 m before its camera, seen from farther and farther away, through all levels and what lies between them.
TEST_F(AdaptiveTest, NoHoleOpensBetweenLevels) {
    const scene::Camera camera = cameraOf(512, 384, 1.2);
    const CutScene wall = cutInLevels({takePlane(camera, {0.2, 0.1, 1}, 2)});
    const GpuScene scene(testDevice(), wall.blocks());
    const scene::Camera eyeCamera = cameraOf(256, 192, 1.2);
    Painter paint(scene, eyeCamera);
    for (const Warp warp : {Warp::points, Warp::adaptive})
        for (double back = 0; back < 14; back += 0.37) {
            const scene::View eye{eyeCamera, poseAt({0, 0, -back}, 0, 0)};
            const double share = 0.8 * 2 / (2 + 1.3 * back);
            EXPECT_EQ(holesIn(paint(eye, plainQuality(warp, 1)), share), 0)
                << back << " m back, warp " << static_cast<int>(warp);
        }
}

TEST_F(AdaptiveTest, FromFarAwayFewSamplesDo) {
    const CutScene wall = cutInLevels({takePlane(cameraOf(512, 384, 1.2), {0, 0, 1}, 2)});
    const GpuScene scene(testDevice(), wall.blocks());
    Renderer renderer(testDevice(), scene, 256, 192, 1);
    const auto samplesFrom = [&](double back) {
        const scene::View eye{cameraOf(256, 192, 1.2), poseAt({0, 0, -back}, 0, 0)};
        return renderer.draw(std::span(&eye, 1), plainQuality(Warp::points, 1)).eyes[0].samplesDrawn;
    };
    const auto near = samplesFrom(1), far = samplesFrom(30);
    EXPECT_GT(near, 40000u) << "about one for each pixel";
    EXPECT_LT(near, 60000u);
    EXPECT_LT(far, 2000u);
    EXPECT_GT(far, 0u);
}

// A sample, the one above it, and so on: at any distance one of them is drawn, and never three.
TEST(Detail, OfAChainOfSamplesOneOrTwoAreDrawn) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(0, 1);
    constexpr uint kLevels = 6;
    int twice = 0;
    constexpr int kChains = 20000;
    for (int i = 0; i < kChains; ++i) {
        const uint x = static_cast<uint>(random()) % 5000, y = static_cast<uint>(random()) % 5000;
        const float w = std::exp2(unit(random) * 9 - 2);
        int drawn = 0;
        for (uint level = 0; level < kLevels; ++level) {
            TileDraw draw{};
            draw.source = uvec4(0, 0, level, 17);
            draw.detail = vec4(1.0f / static_cast<float>(1u << level), level > 0 ? 1.0f : 0.0f,
                               level + 1 < kLevels ? 1.0f : 0.0f, 0);
            // What stands above is as far within what the levels reach into each other.
            const float here = w * (1 + 0.019f * (unit(random) - 0.5f));
            drawn += isOfDetail(draw, x >> level, y >> level, here);
        }
        EXPECT_GE(drawn, 1);
        EXPECT_LE(drawn, 2);
        twice += drawn == 2;
    }
    EXPECT_LT(twice, kChains / 20) << "the price of no holes";
}

} // namespace
} // namespace render
