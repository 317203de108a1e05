#include "scene/footprint.h"

#include "scene/view.h"
#include "tests/scene/random_poses.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
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
        const BoxInEye seen = boxInEye(c, {{x, y, d}, {x, y, d}});
        EXPECT_NEAR(seen.sampleWidth / width, 1, 1e-4);
        EXPECT_EQ(seen.slopeStep, 0) << "no extent";
        EXPECT_EQ(seen.area, 0);
    }
    EXPECT_GT(before, 200);
}

TEST(SampleWidth, OfABoxIsTheLargestAndInfiniteBehindTheEye) {
    const Camera camera{100, 100, 53, 53, 50, 50};
    const glm::dmat4 same = eyeImageFromSourceImage({camera, {}}, camera, {});
    EXPECT_NEAR(boxInEye(same, {{1, 1, 0}, {90, 90, 5}}).sampleWidth, 1, 1e-12);
    // Half a metre nearer: what was 1 m away is twice as large.
    const glm::dmat4 nearer = eyeImageFromSourceImage({camera, {glm::dmat3(1.0), {0, 0, 0.5}}}, camera, {});
    EXPECT_NEAR(boxInEye(nearer, {{1, 1, 0.1}, {90, 90, 1}}).sampleWidth, 2, 1e-12);
    EXPECT_TRUE(std::isinf(boxInEye(nearer, {{1, 1, 0.1}, {90, 90, 2.5}}).sampleWidth));
}

TEST(SampleWidth, OfScrapsIsThatOfTheMiddleOfTheirBox) {
    const SampleBox box{{10, 20, 0.5}, {30, 60, 1.5}};
    EXPECT_EQ(typicalOf(box, kPlaceBits).least, box.least);
    EXPECT_EQ(typicalOf(box, kPlaceBits).most, box.most);
    const SampleBox ofScraps = typicalOf(box, kScrapPlaceBits);
    EXPECT_EQ(ofScraps.least, glm::dvec3(20, 40, 1));
    EXPECT_EQ(ofScraps.most, ofScraps.least);

    const Camera camera{100, 100, 53, 53, 50, 50};
    const glm::dmat4 c = eyeImageFromSourceImage({camera, {glm::dmat3(1.0), {0.1, 0.05, 0}}}, camera, {});
    const BoxInEye whole = boxInEye(c, box), seen = typicalInEye(c, box, kScrapPlaceBits);
    EXPECT_EQ(typicalInEye(c, box, kPlaceBits).sampleWidth, whole.sampleWidth);
    EXPECT_EQ(seen.sampleWidth, boxInEye(c, ofScraps).sampleWidth);
    // The eye has moved within the image's plane: a step of disparity is as many pixels everywhere.
    EXPECT_NEAR(seen.slopeStep, 53 * std::hypot(0.1, 0.05), 1e-9) << "for all of the box' disparities";
    EXPECT_NEAR(whole.slopeStep, seen.slopeStep, 1e-9);
}

TEST(BoxInEyeTest, StepAndAreaAreThoseOfItsCorners) {
    const Camera source{400, 300, 290, 290, 200, 150}, eye{640, 480, 340, 340, 320, 240};
    RandomPlaces random(2);
    int before = 0;
    for (int i = 0; i < 300; ++i) {
        const View view{eye, random.pose(0.3)};
        const glm::dmat4 c = eyeImageFromSourceImage(view, source, {});
        const SampleBox box{{random.between(20, 200), random.between(20, 150), random.between(0.2, 0.4)},
                            {random.between(201, 380), random.between(151, 280), random.between(0.41, 0.9)}};
        glm::dvec2 least(1e300), most(-1e300);
        double step = 0;
        bool isBehind = false;
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 p(corner & 1 ? box.most.x : box.least.x, corner & 2 ? box.most.y : box.least.y,
                               corner & 4 ? box.most.z : box.least.z);
            isBehind = isBehind || (c * glm::dvec4(p.x, p.y, 1, p.z)).z <= 0;
            const auto at = [&](double d) {
                const glm::dvec4 h = c * glm::dvec4(p.x, p.y, 1, d);
                return glm::dvec2(h.x / h.z, h.y / h.z);
            };
            least = glm::min(least, at(p.z)), most = glm::max(most, at(p.z));
            step = std::max(step, glm::length(at(p.z + 1e-7) - at(p.z - 1e-7)) / 2e-7);
        }
        const BoxInEye seen = boxInEye(c, box);
        EXPECT_EQ(std::isinf(seen.area), isBehind);
        EXPECT_EQ(std::isinf(seen.slopeStep), isBehind);
        if (isBehind) continue;
        ++before;
        EXPECT_NEAR(seen.area / ((most.x - least.x) * (most.y - least.y)), 1, 1e-9);
        EXPECT_NEAR(seen.slopeStep / (step * (box.most.z - box.least.z)), 1, 1e-4);
    }
    EXPECT_GT(before, 30);
}

} // namespace
} // namespace scene
