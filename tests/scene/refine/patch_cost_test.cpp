// A patch's colours against a photograph's: vectors say what one sample after the other does.

#include "scene/refine/patch_cost.h"

#include "scene/reprojection.h"
#include "tests/scene/known_scenes.h"
#include "tests/scene/random_poses.h"
#include "tests/scene/vector_widths.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace scene {
namespace {

class PatchCost : public VectorWidths {
  protected:
    /// The same bits by every width that this processor has.
    static float sumByAll(const Image<Rgb8>& photograph, const PatchSamples& patch, const PatchPlaces& places,
                          float most) {
        const float sum = sumOfDifferences(photograph, patch, places, most);
        forEach([&](const char* width) { EXPECT_EQ(sumOfDifferences(photograph, patch, places, most), sum) << width; });
        return sum;
    }
};

TEST_F(PatchCost, IsThatOfEachSampleUpToTheLastPixelByVectorsOfAnyWidth) {
    RandomPlaces random(3);
    DepthImage photograph = imageOf({23, 17, 20, 20, 11, 8}, {}, [](double, double) { return 1.0; });
    for (Rgb8& colour : photograph.colour.pixels()) {
        const auto byte = [&] { return static_cast<std::uint8_t>(random.integerBetween(0, 255)); };
        colour.r = byte(), colour.g = byte(), colour.b = byte();
    }
    constexpr float kMost = 60;
    for (int round = 0; round < 2000; ++round) {
        // The farthest of its samples may lie a pixel within the photograph, on any side.
        const auto number = [&](double low, double high) { return static_cast<float>(random.between(low, high)); };
        const PatchPlaces places{number(5, 18), number(5, 12), number(-1, 1),
                                 number(-1, 1), number(-1, 1), number(-1, 1)};
        PatchSamples patch;
        double sum = 0, weights = 0;
        for (int j = -2; j <= 2; ++j)
            for (int i = -2; i <= 2; ++i) {
                const float dx = static_cast<float>(i), dy = static_cast<float>(j), weight = number(0, 1);
                if (weight < 0.3f) continue;
                const glm::vec3 colour(number(0, 255), number(0, 255), number(0, 255));
                const float u = places.u + dx * places.uByX + dy * places.uByY,
                            v = places.v + dx * places.vByX + dy * places.vByY;
                patch.add(dx, dy, weight, colour);
                const glm::vec3 there = colourWithin(photograph, u, v);
                const double apart =
                    std::abs(there.x - colour.x) + std::abs(there.y - colour.y) + std::abs(there.z - colour.z);
                sum += double{weight} * std::min(apart / 3, double{kMost});
                weights += double{weight};
            }
        patch.pad();
        ASSERT_NEAR(patch.weightOfAll(), weights, 1e-5);
        ASSERT_NEAR(sumByAll(photograph.colour, patch, places, kMost), sum, 2e-3) << "round " << round;
    }
    // The very last pixels.
    PatchSamples patch;
    patch.add(0, 0, 1, glm::vec3(0));
    patch.pad();
    const Rgb8 last = photograph.colour(22, 16);
    EXPECT_NEAR(sumByAll(photograph.colour, patch, {22.4999f, 16.4999f, 0, 0, 0, 0}, 255),
                (last.r + last.g + last.b) / 3.0, 0.1);
}

} // namespace
} // namespace scene
