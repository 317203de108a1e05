// The device against the warp on the processor: the same tiles, the same eyes, the same pictures.

#include "scene/warp.h"
#include "tests/render/test_device.h"
#include "tests/render/test_scenes.h"

#include <array>
#include <random>

namespace render {
namespace {

class OracleTest : public RenderTest {};

struct Difference {
    double covered = 0, colour = 0,
           worstDepth = 0; ///< shares of pixels that differ; greatest relative depth difference
};

Difference compare(const EyeImage& device, const scene::EyeImage& processor) {
    Difference difference;
    double both = 0;
    for (int y = 0; y < device.colour.height(); ++y)
        for (int x = 0; x < device.colour.width(); ++x) {
            const bool here = device.pixelClass(x, y) != 0, there = processor.pixelClass(x, y) != 0;
            if (here != there) ++difference.covered;
            if (!here || !there) continue;
            ++both;
            if (device.colour(x, y) != processor.colour(x, y) ||
                device.pixelClass(x, y) != processor.pixelClass(x, y)) {
                ++difference.colour;
                continue; // another sample won
            }
            const double a = static_cast<double>(device.depthMetres(x, y)),
                         b = static_cast<double>(processor.depthMetres(x, y));
            difference.worstDepth = std::max(difference.worstDepth, std::abs(a / b - 1));
        }
    difference.covered /= static_cast<double>(device.colour.size());
    difference.colour /= both;
    return difference;
}

TEST_F(OracleTest, PointsAreThoseOfTheProcessor) {
    const CutScene room = roomInAllTiers();
    const auto blocks = room.blocks();
    const GpuScene scene(testDevice(), blocks);
    // Lavapipe and the oracle round alike. A card that is a bit of a float off may round a key's disparity to the next
    // of its 2^17 steps.
    const double worstDepth = testDevice().isProcessor() ? 1e-6 : 8e-6;
    for (const auto& [nearBaseline, footprint] : {std::pair{0.f, 1}, {0.05f, 1}, {0.2f, 1}, {0.2f, 3}, {0.f, 8}})
        for (const double x : {-0.2, 0.1, 0.3}) {
            const scene::View eye{cameraOf(220, 160, 1.3), poseAt({x, 0.02, 0.15}, 0.3 * x, 0.1)};
            Quality quality;
            quality.maxFootprint = footprint;
            quality.preference.nearBaseline = nearBaseline;
            scene::WarpOptions options;
            options.maxFootprint = footprint;
            options.preference = quality.preference;
            scene::ZBuffer zBuffer(eye.camera.width, eye.camera.height, 0);
            scene::warpPoints(blocks, eye, options, zBuffer);
            const Difference difference = compare(drawOnce(scene, eye, quality), scene::resolve(zBuffer));
            EXPECT_LE(difference.covered, 0.001)
                << "eye at " << x << ", near baseline " << nearBaseline << ", footprint " << footprint;
            EXPECT_LE(difference.colour, 0.001)
                << "eye at " << x << ", near baseline " << nearBaseline << ", footprint " << footprint;
            EXPECT_LE(difference.worstDepth, worstDepth)
                << "eye at " << x << ", near baseline " << nearBaseline << ", footprint " << footprint;
        }
}

} // namespace
} // namespace render
