#include "scene/footprint.h"

#include "scene/view.h"
#include "tests/scene/random_poses.h"

#include <cmath>

#include <glm/vec2.hpp>
#include <gtest/gtest.h>

namespace scene {
namespace {

TEST(SampleWidth, IsWhatNeighbouringSamplesAreApart) {
    const Camera source{400, 300, 290, 290, 200, 150}, eye{640, 480, 340, 340, 320, 240};
    RandomPlaces random(1);
    const auto unit = [&] { return random.between(-1, 1); };
    int before = 0;
    for (int i = 0; i < 1000; ++i) {
        const View view{eye, random.pose(0.3)};
        const glm::dmat4 c = eyeImageFromSourceImage(view, source, {});
        const double x = 200 + 180 * unit(), y = 150 + 140 * unit(), d = 0.5 + 0.4 * unit();
        if ((c * glm::dvec4(x, y, 1, d)).z < 0.2) continue; // behind the eye, or nearly beside it
        ++before;
        const auto at = [&](double px, double py) {
            const glm::dvec4 h = c * glm::dvec4(px, py, 1, d);
            return glm::dvec2(h.x / h.z, h.y / h.z);
        };
        const glm::dvec2 across = (at(x + 1e-3, y) - at(x - 1e-3, y)) / 2e-3,
                         down = (at(x, y + 1e-3) - at(x, y - 1e-3)) / 2e-3;
        const double width = std::max(std::abs(across.x) + std::abs(down.x), std::abs(across.y) + std::abs(down.y));
        EXPECT_NEAR(sampleWidthInEye(c, {{x, y, d}, {x, y, d}}) / width, 1, 1e-4);
    }
    EXPECT_GT(before, 200);
}

TEST(SampleWidth, OfABoxIsTheLargestAndInfiniteBehindTheEye) {
    const Camera camera{100, 100, 53, 53, 50, 50};
    const glm::dmat4 same = eyeImageFromSourceImage({camera, {}}, camera, {});
    EXPECT_NEAR(sampleWidthInEye(same, {{1, 1, 0}, {90, 90, 5}}), 1, 1e-12);
    // Half a metre nearer: what was 1 m away is twice as large.
    const glm::dmat4 nearer = eyeImageFromSourceImage({camera, {glm::dmat3(1.0), {0, 0, 0.5}}}, camera, {});
    EXPECT_NEAR(sampleWidthInEye(nearer, {{1, 1, 0.1}, {90, 90, 1}}), 2, 1e-12);
    EXPECT_TRUE(std::isinf(sampleWidthInEye(nearer, {{1, 1, 0.1}, {90, 90, 2.5}})));
}

} // namespace
} // namespace scene
