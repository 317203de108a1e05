#include "scene/synthetic.h"

#include "scene/synthetic_model.h"
#include "scene/synthetic_tracer.h"

#include "tests/scene/random_poses.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <limits>
#include <tbb/global_control.h>

namespace scene {
namespace {

constexpr double kFloatRounding = 2e-7; // relative: half a unit in the last place of a float, and the division's

/// A camera at a place that looks at another, x level.
View viewFrom(const glm::dvec3& eye, const glm::dvec3& at, const Camera& camera) {
    const glm::dvec3 forward = glm::normalize(at - eye);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 0, 1)));
    return {camera, {glm::dmat3(right, glm::cross(forward, right), forward), eye}};
}

Camera smallCamera() {
    return {160, 120, 131.0, 129.0, 80.5, 59.0};
}

/// A floor at z = 0 and a sphere above it.
SyntheticModel sphereOverFloor() {
    SyntheticModel model;
    model.name = "sphere";
    model.sky.sun = glm::dvec3(1.0);
    model.sky.towardsSun = glm::normalize(glm::dvec3(0.3, -0.2, 0.9));
    const int checker = addMaterial(model, {Pattern::checker, glm::dvec3(0.8), glm::dvec3(0.2), 0.5});
    addRectangle(model, {-20, -20, 0}, {40, 0, 0}, {0, 40, 0}, checker);
    addSphere(model, {0.3, -0.2, 1.1}, 0.7, checker);
    model.lightSpacing = 2.0;
    return model;
}

bool hasSameBytes(const DepthImage& a, const DepthImage& b) {
    return a.colour == b.colour && a.flags == b.flags &&
           std::memcmp(a.disparity.pixels().data(), b.disparity.pixels().data(), a.disparity.size() * sizeof(float)) ==
               0;
}

/// The small scenes are cheap; these three are lit once for all tests.
const SyntheticScene& sceneNamed(const std::string& name) {
    static const SyntheticScene room = makeRoom(1), corner = makeStreetCorner(1), corridor = makeCorridor(1);
    return name == "room" ? room : name == "corner" ? corner : corridor;
}

class EachScene : public testing::TestWithParam<const char*> {
  protected:
    const SyntheticScene& synthetic() const { return sceneNamed(GetParam()); }
};

TEST(Synthetic, DepthFollowsTheEquationsOfPlaneAndSphere) {
    const SyntheticScene scene(sphereOverFloor());
    const View view = viewFrom({-2.1, -3.3, 1.7}, {0.2, 0.1, 0.6}, smallCamera());
    const DepthImage image = renderTruth(scene, view);
    const glm::dvec3 eye = view.worldFromEye.translation, centre(0.3, -0.2, 1.1);
    int onSphere = 0, onFloor = 0, inSky = 0;
    for (int y = 0; y < view.camera.height; ++y)
        for (int x = 0; x < view.camera.width; ++x) {
            const glm::dvec3 ray = view.worldFromEye.rotation * rayThrough(view.camera, x + 0.5, y + 0.5);
            const double b = glm::dot(ray, eye - centre), a = glm::dot(ray, ray);
            const double root = b * b - a * (glm::dot(eye - centre, eye - centre) - 0.7 * 0.7);
            const double toFloor = -eye.z / ray.z;
            const glm::dvec3 foot = eye + ray * toFloor;
            const bool isFloor = toFloor > 0 && std::abs(foot.x) <= 20 && std::abs(foot.y) <= 20;
            double expected = 0;
            if (root > 1e-9)
                expected = a / (-b - std::sqrt(root)), ++onSphere;
            else if (root > -1e-4)
                continue; // grazing: single precision may decide either way
            else if (isFloor)
                expected = 1.0 / toFloor, ++onFloor;
            else
                ++inSky;
            if (expected == 0) {
                EXPECT_EQ(image.disparity(x, y), 0.0f);
                EXPECT_EQ(image.flags(x, y), kNoSurface);
            } else {
                // A grazed sphere's root is as uncertain as the discriminant that it comes from.
                const double slack = root > 1e-9 && root < 1e-2 ? 1e-5 : kFloatRounding;
                EXPECT_NEAR(image.disparity(x, y), expected, slack * expected) << x << ", " << y;
                EXPECT_EQ(image.flags(x, y), 0);
            }
        }
    EXPECT_GT(onSphere, 500);
    EXPECT_GT(onFloor, 2000);
    EXPECT_GT(inSky, 100);
}

TEST(Synthetic, DepthOfARoomsWallIsItsPlane) {
    const Camera camera = smallCamera();
    const View view = viewFrom({2.6, 2.0, 2.2}, {2.5, -1.0, 2.5}, camera);
    const DepthImage image = renderTruth(sceneNamed("room"), view);
    for (int x = 0; x < camera.width; ++x) {
        const glm::dvec3 ray = view.worldFromEye.rotation * rayThrough(camera, x + 0.5, 60.5);
        const double wall = -2.0 / ray.y, place = 2.6 + ray.x * wall;
        if (ray.y < 0 && place > 0.1 && place < 5.1) {
            EXPECT_NEAR(image.disparity(x, 60), 1.0 / wall, kFloatRounding / wall);
        }
    }
}

TEST(Synthetic, NearThingsHideFarOnes) {
    SyntheticModel model;
    const int red = addMaterial(model, {Pattern::plain, glm::dvec3(0.8, 0.0, 0.0)});
    const int blue = addMaterial(model, {Pattern::plain, glm::dvec3(0.0, 0.0, 0.8)});
    addRectangle(model, {-5, 5, -5}, {10, 0, 0}, {0, 0, 10}, red);
    addBox(model, Pose{}, {-1, 2, -1}, {1, 3, 1}, blue);
    model.lightSpacing = 1;
    const SyntheticScene scene(std::move(model));
    for (double x = -1.9; x < 2; x += 0.1) {
        const bool isHidden = std::abs(x / 5 * 2) < 1; // the ray to (x', 5) passes the box's face at y = 2
        const auto hit = castRay(scene, {0, 0, 0}, {x * 1.0, 5.0, 0.0});
        ASSERT_TRUE(hit);
        const Rgb8 colour = colourAlong(scene, {0, 0, 0}, {x * 1.0, 5.0, 0.0});
        EXPECT_EQ(colour.b > colour.r, isHidden) << x;
        EXPECT_NEAR(hit->position.y, isHidden ? 2.0 : 5.0, 1e-12);
        EXPECT_NEAR(hit->normal.y, -1.0, 1e-12);
    }
    for (const double x : {-3.0, 3.0}) {
        const Rgb8 colour = colourAlong(scene, {0, 0, 0}, {x, 5.0, 0.0});
        EXPECT_GT(colour.r, colour.b);
    }
    EXPECT_FALSE(castRay(scene, {0, 0, 0}, {0, -1, 0}));
}

/// Every sample of one view that another sees unhidden has the same colour there.
TEST_P(EachScene, ColourOfAPointIsTheSameFromAllViews) {
    const std::vector<View> views = captureViews(synthetic(), 24, smallCamera());
    int compared = 0, different = 0;
    for (std::size_t i = 0; i + 1 < views.size(); ++i) {
        const DepthImage image = renderTruth(synthetic(), views[i]);
        const glm::dvec3 otherEye = views[i + 1].worldFromEye.translation;
        for (int y = 1; y < image.camera.height; y += 7)
            for (int x = 1; x < image.camera.width; x += 7) {
                if (image.flags(x, y) != 0) continue;
                const glm::dvec3 ray = views[i].worldFromEye.rotation * rayThrough(image.camera, x + 0.5, y + 0.5);
                const glm::dvec3 point =
                    views[i].worldFromEye.translation + ray / static_cast<double>(image.disparity(x, y));
                const auto seen = castRay(synthetic(), otherEye, point - otherEye);
                if (!seen || glm::length(seen->position - point) > 1e-5 * glm::length(point - otherEye))
                    continue; // hidden
                const Rgb8 a = image.colour(x, y), b = colourAlong(synthetic(), otherEye, point - otherEye);
                ++compared;
                different += std::abs(a.r - b.r) > 3 || std::abs(a.g - b.g) > 3 || std::abs(a.b - b.b) > 3;
            }
    }
    EXPECT_GT(compared, 2000);
    // A point on the very edge of a shadow or between two surfaces may fall to either side of it.
    EXPECT_LE(different, compared / 500);
}

TEST_P(EachScene, RaysTogetherHitWhatEachHitsAlone) {
    const SyntheticTracer& tracer = synthetic().tracer();
    RandomPlaces random(5);
    int hits = 0, rounds = 0;
    for (const View& view : walkPath(synthetic(), 20, smallCamera()))
        for (int packet = 0; packet < 500; ++packet) {
            // As close together as neighbours in a scan, or anywhere.
            const double apart = packet % 2 == 0 ? 0.01 : 1;
            const glm::dvec3 eye = view.worldFromEye.translation, middle = random.point(1);
            std::vector<glm::dvec3> rays(
                static_cast<std::size_t>(random.integerBetween(1, SyntheticTracer::kTogether)));
            for (glm::dvec3& ray : rays)
                ray = middle + random.point(apart);
            const auto together = tracer.castTogether(eye, rays);
            for (std::size_t i = 0; i < together.size(); ++i) {
                const auto alone = i < rays.size() ? tracer.cast(eye, rays[i]) : std::nullopt;
                // Where two surfaces meet either may be named.
                ASSERT_EQ(together[i].has_value(), alone.has_value()) << "ray " << i << " of packet " << packet;
                if (!alone) continue;
                ASSERT_NEAR(together[i]->t, alone->t, 1e-12 * alone->t) << "ray " << i << " of packet " << packet;
                ++hits;
                rounds += alone->kind == SurfaceKind::round;
            }
        }
    EXPECT_GT(hits, 10000);
    EXPECT_GT(rounds, 20);
}

TEST_P(EachScene, OneThreadAndTwoGiveTheSameBytes) {
    // The scene itself was made, and is shown first, on all threads.
    const View view = walkPath(synthetic(), 5, smallCamera())[1];
    const DepthImage together = renderTruth(synthetic(), view, 2);
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_TRUE(hasSameBytes(together, renderTruth(synthetic(), view, 2)));
    EXPECT_TRUE(hasSameBytes(together, renderTruth(*makeSyntheticScene(GetParam(), 1), view, 2)));
}

TEST(Synthetic, ASeedMakesTheSameSceneAndAnotherSeedAnother) {
    const View view = viewFrom({1.0, 1.2, 1.6}, {5.0, 2.3, 1.2}, smallCamera());
    const DepthImage first = renderTruth(sceneNamed("room"), view);
    EXPECT_TRUE(hasSameBytes(first, renderTruth(makeRoom(1), view)));
    EXPECT_FALSE(hasSameBytes(first, renderTruth(makeRoom(2), view)));
}

TEST(Synthetic, OnlyTheThreeNamesAreScenes) {
    EXPECT_FALSE(makeSyntheticScene("castle"));
}

TEST_P(EachScene, WalksAndCapturesKeepClear) {
    for (const bool isWalk : {true, false}) {
        const std::vector<View> views = isWalk ? walkPath(synthetic(), 400) : captureViews(synthetic(), 400);
        for (std::size_t i = 0; i < views.size(); ++i) {
            const glm::dvec3 at = views[i].worldFromEye.translation;
            EXPECT_GT(clearanceAt(synthetic(), at), 0.15) << (isWalk ? "walk " : "capture ") << i;
            EXPECT_NEAR(at.z, isWalk ? 1.6 : 1.45, isWalk ? 0.02 : 0.2);
            if (i == 0) continue;
            const glm::dvec3 before = views[i - 1].worldFromEye.translation, step = at - before;
            EXPECT_LT(glm::length(step), 0.3);
            const auto hit = castRay(synthetic(), before, step);
            EXPECT_FALSE(hit && hit->distanceMetres < glm::length(step)) << i;
        }
    }
}

TEST_P(EachScene, WalkIsSmooth) {
    const std::vector<View> views = walkPath(synthetic(), 600);
    for (std::size_t i = 1; i < views.size(); ++i) {
        const double turn = glm::dot(views[i].worldFromEye.rotation[2], views[i - 1].worldFromEye.rotation[2]);
        EXPECT_GT(turn, std::cos(0.12)) << i;
    }
}

TEST_P(EachScene, ScanPointsLieOnSurfacesAndOnTheirGrid) {
    const std::vector<Pose> positions = scanPositions(synthetic());
    ASSERT_GE(positions.size(), 3u);
    constexpr int kColumns = 90, kRows = 40;
    for (const Pose& worldFromScanner : positions) {
        EXPECT_GT(clearanceAt(synthetic(), worldFromScanner.translation), 0.15);
        const Scan scan = simulateScan(synthetic(), worldFromScanner, kColumns, kRows);
        ASSERT_EQ(scan.pointsInScanner.size(), scan.colours.size());
        ASSERT_GT(scan.pointsInScanner.size(), kColumns * kRows / 3u);
        for (std::size_t i = 0; i < scan.pointsInScanner.size(); ++i) {
            const glm::dvec3 p(scan.pointsInScanner[i]);
            const auto hit = castRay(synthetic(), worldFromScanner.translation, worldFromScanner.rotation * p);
            ASSERT_TRUE(hit);
            // A point is rounded to floats, and with it the ray: on grazed surfaces the range differs by
            // more.
            const double graze =
                std::max(std::abs(glm::dot(hit->normal, glm::normalize(worldFromScanner.rotation * p))), 1e-3);
            EXPECT_NEAR(hit->distanceMetres, glm::length(p), 1e-6 * glm::length(p) / graze + 1e-6);
            const double azimuth = std::atan2(-p.y, p.x) / 6.283185307179586;
            EXPECT_NEAR((azimuth < 0 ? azimuth + 1 : azimuth) * kColumns - 0.5, scan.column[i], 1e-3);
            const ScanOptions usual;
            const double down =
                (usual.topRadians - std::asin(p.z / glm::length(p))) / (usual.topRadians - usual.bottomRadians);
            EXPECT_NEAR(down * kRows - 0.5, scan.row[i], 1e-3);
        }
    }
}

TEST(Synthetic, RangeNoiseHasItsDeviationAndItsSeed) {
    const SyntheticScene scene(sphereOverFloor());
    const Pose worldFromScanner{glm::dmat3(1.0), {4.0, 3.0, 1.5}};
    ScanOptions options;
    options.topRadians = -0.2;
    const Scan ideal = simulateScan(scene, worldFromScanner, 200, 60, options);
    options.rangeNoiseMetres = 0.004;
    const Scan noisy = simulateScan(scene, worldFromScanner, 200, 60, options);
    ASSERT_EQ(ideal.pointsInScanner.size(), noisy.pointsInScanner.size());
    double sum = 0, squares = 0;
    for (std::size_t i = 0; i < ideal.pointsInScanner.size(); ++i) {
        const double error =
            static_cast<double>(glm::length(noisy.pointsInScanner[i]) - glm::length(ideal.pointsInScanner[i]));
        sum += error, squares += error * error;
    }
    const double count = static_cast<double>(ideal.pointsInScanner.size());
    EXPECT_NEAR(sum / count, 0.0, 0.0002);
    EXPECT_NEAR(std::sqrt(squares / count), 0.004, 0.0002);
    EXPECT_EQ(noisy.pointsInScanner, simulateScan(scene, worldFromScanner, 200, 60, options).pointsInScanner);
    options.noiseSeed = 2;
    EXPECT_NE(noisy.pointsInScanner, simulateScan(scene, worldFromScanner, 200, 60, options).pointsInScanner);
}

INSTANTIATE_TEST_SUITE_P(Synthetic, EachScene, testing::Values("room", "corner", "corridor"),
                         [](const auto& scene) { return std::string(scene.param); });

} // namespace
} // namespace scene
