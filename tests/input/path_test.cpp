#include "input/path.h"

#include "scene/errors.h"
#include "tests/scene/scratch_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include <glm/geometric.hpp>

namespace input {

namespace {

scene::Pose poseAt(const glm::dvec3& place, double heading = 0, double tilt = 0) {
    return scene::poseFromQuaternion(place, 0, std::sin(heading / 2), 0, std::cos(heading / 2)) *
           scene::poseFromQuaternion({0, 0, 0}, std::sin(tilt / 2), 0, 0, std::cos(tilt / 2));
}

/// Radians between two orientations.
double angleBetween(const scene::Pose& a, const scene::Pose& b) {
    const glm::dmat3 r = glm::transpose(a.rotation) * b.rotation;
    const glm::dvec3 axis{r[1][2] - r[2][1], r[2][0] - r[0][2], r[0][1] - r[1][0]};
    return std::atan2(glm::length(axis), r[0][0] + r[1][1] + r[2][2] - 1);
}

std::vector<PathKey> unevenKeys() {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> any(-1, 1);
    std::vector<PathKey> keys;
    double seconds = 0.25;
    for (int i = 0; i < 40; ++i) {
        const scene::Pose pose =
            poseAt({any(random), 1.6 + 0.2 * any(random), 2 * any(random)}, 3 * any(random), any(random));
        keys.push_back({seconds, pose, {}});
        seconds += 0.02 + 0.5 * std::abs(any(random));
    }
    return keys;
}

TEST(SmoothPath, PassesEachKeyExactlyAtItsTime) {
    const std::vector<PathKey> keys = unevenKeys();
    const SmoothPath path(keys);
    for (const PathKey& key : keys) {
        const auto pose = path(key.seconds);
        ASSERT_TRUE(pose);
        EXPECT_EQ(pose->translation, key.spaceFromHead.translation);
        EXPECT_EQ(pose->rotation, key.spaceFromHead.rotation);
    }
}

TEST(SmoothPath, NeitherPlaceNorOrientationJerksAtAKey) {
    const std::vector<PathKey> keys = unevenKeys();
    const SmoothPath path(keys);
    constexpr double h = 1e-6;
    for (std::size_t i = 1; i + 1 < keys.size(); ++i) {
        const double t = keys[i].seconds;
        const scene::Pose before = *path(t - h), at = *path(t), after = *path(t + h);
        const glm::dvec3 arriving = (at.translation - before.translation) / h,
                         leaving = (after.translation - at.translation) / h;
        EXPECT_LT(glm::distance(arriving, leaving), 0.02) << "at key " << i;
        // Turned on by as much as it turned before, it is where it will be.
        const scene::Pose on{at.rotation * glm::transpose(before.rotation) * at.rotation, at.translation};
        EXPECT_LT(angleBetween(on, after) / h, 0.05) << "at key " << i;
        EXPECT_LT(angleBetween(at, after), 1e-3);
    }
}

TEST(SmoothPath, NothingOvershootsAndWhatStoodStillStaysStill) {
    const SmoothPath path({{0, poseAt({0, 0, 0}), {}},
                           {1, poseAt({1, 0, 0}), {}},
                           {2, poseAt({1, 0, 0}), {}},
                           {2.1, poseAt({5, 0, 0}), {}}});
    double last = 0;
    for (double t = 0; t <= 2.1; t += 0.001) {
        const double x = path(t)->translation.x;
        EXPECT_GE(x, last - 1e-12);
        EXPECT_LE(x, 5 + 1e-12);
        if (t >= 1 && t <= 2) {
            EXPECT_NEAR(x, 1, 1e-12) << t;
        }
        last = x;
    }
}

TEST(SmoothPath, EvenMotionStaysEven) {
    std::vector<PathKey> keys;
    for (int i = 0; i < 6; ++i)
        keys.push_back({0.5 * i, poseAt({0.3 * i, 1.6, -0.1 * i}, 0.4 * i), {}});
    const SmoothPath path(keys);
    for (double t = 0; t < 2.5; t += 0.013) {
        const scene::Pose pose = *path(t), expected = poseAt({0.6 * t, 1.6, -0.2 * t}, 0.8 * t);
        EXPECT_LT(glm::distance(pose.translation, expected.translation), 1e-12);
        EXPECT_LT(angleBetween(pose, expected), 1e-9);
    }
}

TEST(SmoothPath, EvenMotionStaysEvenHoweverUnevenTheTimes) {
    std::vector<PathKey> keys;
    for (const double t : {0.0, 0.01, 0.5, 0.52, 2.0, 2.001, 2.3, 5.0})
        keys.push_back({t, poseAt({0.6 * t, 1.6, -0.2 * t}, 0.4 * t), {}});
    const SmoothPath path(keys);
    for (double t = 0; t < 5; t += 0.0037) {
        EXPECT_LT(glm::distance(path(t)->translation, glm::dvec3(0.6 * t, 1.6, -0.2 * t)), 1e-12) << t;
        EXPECT_LT(angleBetween(*path(t), poseAt({}, 0.4 * t)), 1e-9) << t;
    }
}

TEST(SmoothPath, LiesBetweenTheKeysHoweverTheyCome) {
    std::mt19937 random(17);
    std::uniform_real_distribution<double> any(-1, 1);
    for (int round = 0; round < 300; ++round) {
        std::vector<PathKey> keys;
        double seconds = 1e5 * any(random);
        for (int i = 0; i < 12; ++i) {
            scene::Pose pose = poseAt({any(random), any(random), any(random)}, 4 * any(random), any(random));
            // As trackers write them: standing still, twice the same time, a thousandth of a second apart.
            if (i > 0 && any(random) > 0.6) pose = keys.back().spaceFromHead;
            keys.push_back({seconds, pose, {}});
            seconds += any(random) > 0.7 ? 0 : std::pow(10, 3 * any(random));
        }
        const SmoothPath path(keys);
        for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
            const scene::Pose &a = keys[i].spaceFromHead, &b = keys[i + 1].spaceFromHead;
            const double h = keys[i + 1].seconds - keys[i].seconds;
            for (double share = 0.05; share < 1 && h > 0; share += 0.05) {
                const auto pose = path(keys[i].seconds + share * h);
                ASSERT_TRUE(pose);
                for (int axis = 0; axis < 3; ++axis) {
                    EXPECT_GE(pose->translation[axis], std::min(a.translation[axis], b.translation[axis]) - 1e-9);
                    EXPECT_LE(pose->translation[axis], std::max(a.translation[axis], b.translation[axis]) + 1e-9);
                }
                // A turn may bulge, since the next one is about another axis, but takes no long way round.
                EXPECT_LT(angleBetween(a, *pose) + angleBetween(*pose, b), 1.5 * angleBetween(a, b) + 1e-6)
                    << "round " << round << ", key " << i << ", " << share;
            }
        }
    }
}

TEST(SmoothPath, TurnsTheShorterWay) {
    const SmoothPath path({{0, poseAt({0, 0, 0}, 3.0), {}}, {1, poseAt({0, 0, 0}, -3.0), {}}});
    EXPECT_LT(angleBetween(*path(0.5), poseAt({0, 0, 0}, 3.14159265358979)), 1e-9);
}

TEST(SmoothPath, BeginsAndEndsWithItsKeys) {
    const SmoothPath one({{2, poseAt({1, 2, 3}), {}}});
    EXPECT_EQ(one(0)->translation, glm::dvec3(1, 2, 3));
    EXPECT_EQ(one(2)->translation, glm::dvec3(1, 2, 3));
    EXPECT_FALSE(one(2.1));
    const SmoothPath jump({{0, poseAt({0, 0, 0}), {}},
                           {1, poseAt({1, 0, 0}), {}},
                           {1, poseAt({7, 0, 0}), {}},
                           {2, poseAt({8, 0, 0}), {}}});
    EXPECT_NEAR(jump(1 - 1e-9)->translation.x, 1, 1e-6);
    EXPECT_EQ(jump(1)->translation.x, 7);
    EXPECT_NEAR(jump(1.5)->translation.x, 7.5, 1e-9);
}

TEST(RecordedPath, ComesBackAsItWasWritten) {
    RecordedPath path;
    path.keys = unevenKeys();
    path.keys[3].rig = Rig{{1, 2, 3}, 0.5, 2};
    const scene::ScratchFolder scratch;
    const std::filesystem::path file = scratch / "path.json";
    scene::writeFile(file, textOf(path));
    const RecordedPath again = readPath(file);
    ASSERT_EQ(again.keys.size(), path.keys.size());
    EXPECT_EQ(again.space, PathSpace::walk);
    for (std::size_t i = 0; i < path.keys.size(); ++i) {
        EXPECT_EQ(again.keys[i].seconds, path.keys[i].seconds);
        EXPECT_EQ(again.keys[i].spaceFromHead.translation, path.keys[i].spaceFromHead.translation);
        EXPECT_LT(angleBetween(again.keys[i].spaceFromHead, path.keys[i].spaceFromHead), 1e-9);
        EXPECT_EQ(again.keys[i].rig.has_value(), i == 3);
    }
    EXPECT_EQ(again.keys[3].rig->scale, 2);
}

TEST(RecordedPath, TimesThatRunBackAreRefusedByThePose) {
    const scene::ScratchFolder scratch;
    const std::filesystem::path file = scratch / "path.json";
    RecordedPath path;
    for (const double t : {0.0, 1.0, 1.0, 0.999999, 3.0})
        path.keys.push_back({t, poseAt({t, 0, 0}), {}});
    scene::writeFile(file, textOf(path));
    const std::string failure = scene::failureOf<scene::Failure>([&] { readPath(file); });
    EXPECT_EQ(failure.find(file.string() + ", pose 3: "), 0u) << failure;
    EXPECT_EQ(failure.find('\n'), std::string::npos);
    path.keys.erase(path.keys.begin() + 3);
    path.space = PathSpace::world;
    scene::writeFile(file, textOf(path));
    EXPECT_EQ(readPath(file).keys.size(), 4u) << "twice the same time is a jump";
    EXPECT_EQ(readPath(file).space, PathSpace::world);
}

TEST(RecordedPath, ARigThatStandsNowhereIsRefused) {
    const scene::ScratchFolder scratch;
    const std::filesystem::path file = scratch / "path.json";
    for (const char* rig : {"3", "{}", R"({"position": [0, 0], "yaw": 0, "scale": 1})",
                            R"({"position": [0, 0, 0], "yaw": 0, "scale": 0})",
                            R"({"position": [0, 0, 0], "yaw": "north", "scale": 1})"}) {
        scene::writeFile(
            file,
            std::string(R"({"space": "walk", "poses": [{"position": [0, 0, 0], "orientation": [0, 0, 0, 1], "rig": )") +
                rig + "}]}");
        const std::string failure = scene::failureOf<scene::Failure>([&] { readPath(file); });
        EXPECT_NE(failure.find("pose 0"), std::string::npos) << rig << ": " << failure;
    }
}

} // namespace

} // namespace input
