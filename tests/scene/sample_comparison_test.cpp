// Many samples at once: what vectors of any width say of each is what sightingOf and compareWith say, to the bit.

#include "scene/sample_comparison.h"

#include "tests/scene/known_scenes.h"
#include "tests/scene/random_poses.h"
#include "tests/scene/vector_widths.h"

#include <bit>
#include <cmath>
#include <map>

namespace scene {
namespace {

/// Steps, holes, floating samples, guesses and slopes; the disparity of places without a surface may be any.
DepthImage roughImage(const Camera& camera, const Pose& pose, RandomPlaces& random) {
    DepthImage image = imageOf(camera, pose, [&](double x, double y) {
        const double step = std::fmod(x / 7 + y / 11, 2) < 1 ? 0.4 : 0.7;
        return step * (1 + 0.004 * x + 0.01 * random.between(0, 1));
    });
    for (std::size_t i = 0; i < image.flags.size(); ++i)
        if (random.between(0, 1) < 0.05) {
            constexpr std::uint8_t kKinds[] = {kNoSurface, kNoSurface | kInterpolated, kFloating, kRedundant,
                                               kSkinLower};
            image.flags.pixels()[i] = kKinds[random.integerBetween(0, 4)];
            if (image.flags.pixels()[i] == kNoSurface) image.disparity.pixels()[i] = 0;
        }
    return image;
}

void expectSame(const SampleComparison& samples, const DepthImage& target, const Reprojection& into,
                const ComparisonOptions& options, std::map<Relation, int>& met) {
    for (int i = 0; i < samples.count(); ++i) {
        const Sighting at = sightingOf(into, samples.x(i), samples.y(i), samples.disparity(i));
        const Comparison one = compareWith(target, at, options), all = samples.comparison(i);
        ASSERT_EQ(samples.isSeen(i), isSeenIn(target.camera, at)) << "sample " << i;
        ASSERT_EQ(all.relation, one.relation) << "sample " << i;
        ASSERT_EQ(samples.relation(i), one.relation) << "sample " << i;
        ASSERT_EQ(all.isSmooth, one.isSmooth) << "sample " << i;
        ASSERT_EQ(std::bit_cast<std::uint32_t>(all.disparity), std::bit_cast<std::uint32_t>(one.disparity));
        ++met[one.relation];
        if (!samples.isSeen(i)) continue;
        const Sighting seen = samples.sighting(i);
        ASSERT_EQ(std::bit_cast<std::uint32_t>(seen.u), std::bit_cast<std::uint32_t>(at.u)) << "sample " << i;
        ASSERT_EQ(std::bit_cast<std::uint32_t>(seen.v), std::bit_cast<std::uint32_t>(at.v)) << "sample " << i;
        ASSERT_EQ(std::bit_cast<std::uint32_t>(seen.disparity), std::bit_cast<std::uint32_t>(at.disparity));
    }
}

class SamplesTogether : public VectorWidths {};

TEST_F(SamplesTogether, AreComparedAsEachIsByVectorsOfAnyWidth) {
    RandomPlaces random(4);
    std::map<Relation, int> met;
    for (int round = 0; round < 60; ++round) {
        const Camera target{random.integerBetween(1, 60), random.integerBetween(1, 40), 40, 44, 28, 19};
        const Pose aside = poseFromQuaternion(random.point(0.5), random.between(-0.2, 0.2), random.between(-0.2, 0.2),
                                              random.between(-0.2, 0.2), 1);
        const DepthImage image = roughImage(target, round % 10 == 0 ? random.pose(3) : aside, random);
        const Camera camera{64, 48, 50, 50, 32, 24};
        const DepthImage source = roughImage(camera, {}, random);
        const Reprojection into = reprojectionInto(image, source);
        // Of any number, more than are looked at together included.
        SampleComparison samples(random.integerBetween(1, 700));
        const int count = random.integerBetween(0, 700);
        for (int i = 0; i < std::min(count, samples.most()); ++i) {
            const int x = random.integerBetween(0, 63), y = random.integerBetween(0, 47);
            samples.add(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, source.disparity(x, y));
        }
        ComparisonOptions options;
        options.sameSurface = round % 3 == 0 ? 0.2f : 0.02f;
        forEach([&](const char* width) {
            SCOPED_TRACE(testing::Message() << "round " << round << ", " << width);
            samples.compare(image, into, options);
            expectSame(samples, image, into, options, met);
        });
    }
    for (const Relation relation : {Relation::outside, Relation::agrees, Relation::inFront, Relation::behind})
        EXPECT_GT(met[relation], 1000) << static_cast<int>(relation);
}

TEST_F(SamplesTogether, TheLastPixelsAndTheEyesPlaneAreNoExceptions) {
    RandomPlaces random(5);
    std::map<Relation, int> met;
    const DepthImage image = roughImage({16, 9, 10, 10, 8, 4.5}, {}, random);
    for (const double z : {0.0, 2.0, 1e-30, -1e-7}) {
        const DepthImage source = imageOf(image.camera, {glm::dmat3(1), {0, 0, z}}, [](double, double) { return 0.5; });
        const Reprojection into = reprojectionInto(image, source);
        SampleComparison samples(2000);
        for (const float disparity : {0.5f, -0.5f, 0.f, 1e30f})
            for (const float x : {0.f, 0.5f, 0.49999997f, 14.5f, 14.4999990f, 15.5f, 15.999999f, 16.f})
                for (const float y : {0.f, 0.5f, 0.49999997f, 7.5f, 7.4999995f, 8.5f, 8.999999f, 9.f})
                    samples.add(x, y, disparity);
        forEach([&](const char* width) {
            SCOPED_TRACE(testing::Message() << "z " << z << ", " << width);
            samples.compare(image, into, {});
            expectSame(samples, image, into, {}, met);
        });
    }
}

} // namespace
} // namespace scene
