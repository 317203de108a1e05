#include "scene/refine/open_spaces.h"

#include "tests/scene/known_scenes.h"
#include "tests/scene/scratch_folder.h"
#include "tests/scene/stored_images.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace scene {
namespace {

constexpr std::array<double, 8> kNoBodies{};  ///< of facesOfTwoPlaces
const Camera kSquare{48, 48, 24, 24, 24, 24}; // 90 degrees: a face of a cube

/// Each at its own disparity or infinitely far, and joined to none: its patch is as thick as nothing.
DepthImage scatteredSamples(const Camera& camera, unsigned seed = 7) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> disparity(0.1f, 2);
    DepthImage image = imageOf(camera, {}, [&](double, double) { return disparity(random); });
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
            image.flags(x, y) = kSkinUpper | kSkinLower;
            if (random() % 8 == 0) image.disparity(x, y) = 0; // sky
        }
    return image;
}

/// As holdsSample, of such samples, by looking at each.
bool holdsOneOf(const DepthImage& image, const BoxInCamera& box) {
    const double zNear = box.centre.z - box.half.z, zFar = box.centre.z + box.half.z;
    if (zNear <= 0) return false;
    const Camera& camera = image.camera;
    glm::dvec2 least(1e9), most(-1e9);
    for (const double z : {zNear, zFar})
        for (const double side : {-1.0, 1.0}) {
            const glm::dvec2 at =
                project(camera, {box.centre.x + side * box.half.x, box.centre.y + side * box.half.y, z});
            least = glm::min(least, at), most = glm::max(most, at);
        }
    const auto boxNear = static_cast<float>(1 / zNear), boxFar = static_cast<float>(1 / zFar);
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
            const bool isSeenThrough = x + 1 > least.x && x <= most.x && y + 1 > least.y && y <= most.y;
            const float disparity = image.disparity(x, y);
            if (isSeenThrough && disparity > 0 && disparity >= boxFar && disparity <= boxNear) return true;
        }
    return false;
}

TEST(OpenSpace, HoldsASampleWhereOneIs) {
    const Camera camera{100, 60, 50, 40, 47, 33};
    const DepthImage image = scatteredSamples(camera);
    OpenSpace::Buffers buffers;
    const OpenSpace space(image, nullptr, 0, 0, buffers);
    std::mt19937 random(1);
    const auto between = [&](double least, double most) {
        return std::uniform_real_distribution<double>(least, most)(random);
    };
    int holding = 0;
    constexpr int kBoxes = 3000;
    for (int i = 0; i < kBoxes; ++i) {
        const double z = between(0.3, 6), half = z * std::exp(between(-5, -1));
        const BoxInCamera box{{z * between(-1.2, 1.2), z * between(-1.2, 1.2), z},
                              {half * between(0.2, 1), half * between(0.2, 1), half * std::exp(between(-5, 0))}};
        ASSERT_EQ(space.holdsSample(box), holdsOneOf(image, box)) << i;
        holding += space.holdsSample(box);
    }
    EXPECT_GT(holding, kBoxes / 10);
    EXPECT_LT(holding, 9 * kBoxes / 10);
}

TEST(OpenSpace, WhereTheCameraStoodIsOpenOnAllSides) {
    const DepthImage image = imageOf(kSquare, {}, [](double, double) { return 0.5f; });
    OpenSpace::Buffers buffers;
    const OpenSpace space(image, nullptr, 0, 0.2, buffers);
    for (const glm::dvec3& side : {glm::dvec3(1, 0, 0), glm::dvec3(0, -1, 0), glm::dvec3(0, 0, -1)}) {
        EXPECT_EQ(space.look({0.18 * side, glm::dvec3(0.005)}).sight, Sight::all);
        EXPECT_EQ(space.look({0.2 * side, glm::dvec3(0.02)}).sight, Sight::part);
        EXPECT_EQ(space.look({0.2 * side, glm::dvec3(0.005)}).sight, Sight::none) << "its rim is told by larger boxes";
        EXPECT_EQ(space.look({0.3 * side, glm::dvec3(0.005)}).sight, Sight::none);
    }
    EXPECT_EQ(space.look({glm::dvec3(0), glm::dvec3(0.1)}).sight, Sight::all);
    EXPECT_EQ(space.look({glm::dvec3(0), glm::dvec3(0.15)}).sight, Sight::part); // its corners are farther
}

/// Sees one piece of space as the other does.
void expectTheSame(const OpenSpace& one, const OpenSpace& other) {
    int parts = 0, holding = 0;
    for (double z = 0.4; z < 8; z *= 1.1)
        for (double x = -1.2; x < 1.2; x += 0.05) {
            const BoxInCamera box{{x * z, x * x * z, z}, glm::dvec3(0.05 * z)};
            ASSERT_EQ(one.look(box).sight, other.look(box).sight);
            ASSERT_EQ(one.look(box).hasEdge, other.look(box).hasEdge);
            ASSERT_EQ(one.holdsSample(box), other.holdsSample(box));
            parts += one.look(box).sight == Sight::part, holding += one.holdsSample(box);
        }
    EXPECT_GT(parts, 0);
    EXPECT_GT(holding, 0);
}

TEST(OpenSpace, InTheBuffersOfAnotherIsAsInItsOwn) {
    OpenSpace::Buffers used;
    for (const Camera& camera : {Camera{20, 30, 15, 15, 10, 15}, kSquare, Camera{25, 20, 15, 15, 12, 10}}) {
        const DepthImage image = scatteredSamples(camera);
        OpenSpace::Buffers own;
        expectTheSame(OpenSpace(image, nullptr, 0, 0, used), OpenSpace(image, nullptr, 0, 0, own));
    }
}

/// Looks along x: to the right of a camera that looks along z.
Pose toTheRight() {
    const double half = std::sqrt(0.5);
    return poseFromQuaternion({0, 0, 0}, 0, half, 0, half);
}

// A wall two metres to the right, seen by a face that looks that way, and a silhouette on it.
TEST(Rim, SeesHowFarTheRaysOfAnotherFaceWent) {
    ASSERT_NEAR((toTheRight().rotation * glm::dvec3(0, 0, 1)).x, 1, 1e-12);
    DepthImage right = imageOf(kSquare, toTheRight(), [](double, double) { return 0.5; });
    for (int x = 0; x < kSquare.width; ++x)
        right.flags(x, 20) = kSkinUpper | kSkinLower;
    // Off centre, wide and high, and smaller than their margins of two.
    for (const Camera& face :
         {kSquare, Camera{40, 28, 20, 16, 19, 15}, Camera{64, 3, 32, 32, 30, 1}, Camera{1, 1, 0.5, 0.5, 0.5, 0.5}}) {
        Rim rim(face, glm::dmat3(1));
        rim.take(right);
        const int margin = rim.margin();
        ASSERT_EQ(margin, std::max(face.width / 8, 2));
        int taken = 0, edges = 0;
        for (int y = 0; y < rim.widened().height; ++y)
            for (int x = 0; x < rim.widened().width; ++x) {
                const bool isWithin = x >= margin && y >= margin && x < face.width + margin && y < face.height + margin;
                const glm::dvec3 ray = rayThrough(rim.widened(), x + 0.5, y + 0.5);
                // Those along an edge of the cube may fall to either side.
                if (isWithin || std::abs(std::abs(ray.y) - ray.x) < 1e-9 || std::abs(ray.x - 1) < 1e-9) continue;
                const RayEnd end = rim.at(x, y);
                ASSERT_EQ(end.provesSomething(), ray.x > 1 && std::abs(ray.y) < ray.x) << x << ", " << y;
                EXPECT_TRUE(end.isEdge || end.provesSomething());
                if (!end.provesSomething()) continue;
                ++taken;
                ASSERT_NEAR(end.disparity, ray.x / 2, 1e-6) << "it ends where x is 2 m";
                const int row = static_cast<int>(std::floor(kSquare.fy * ray.y / ray.x + kSquare.cy));
                ASSERT_EQ(end.isEdge, row == 20) << "its last row and column go on beyond it";
                edges += end.isEdge;
            }
        EXPECT_GT(taken, 2) << face.width;
        EXPECT_EQ(edges > 0, face.width > 1) << face.width;
    }
}

TEST(Rim, TheFirstThatSawARaySaysHowFarItWent) {
    DepthImage nearby = imageOf(kSquare, toTheRight(), [](double, double) { return 1.0; });
    nearby.flags(0, 24) = kNoSurface; // looks past the border of the face straight ahead
    const DepthImage far = imageOf(kSquare, toTheRight(), [](double, double) { return 0.25; });
    Rim rim(kSquare, glm::dmat3(1));
    rim.take(nearby), rim.take(far);
    int fromNearby = 0, fromFar = 0;
    for (int y = 6; y < 54; ++y)
        for (int x = 54; x < 60; ++x) {
            const double metres = rayThrough(rim.widened(), x + 0.5, y + 0.5).x / double{rim.at(x, y).disparity};
            ++(std::abs(metres - 1) < 1e-6 ? fromNearby : fromFar);
            EXPECT_TRUE(std::abs(metres - 1) < 1e-6 || std::abs(metres - 4) < 1e-6) << metres;
        }
    EXPECT_GT(fromFar, 0);
    EXPECT_GT(fromNearby, 10 * fromFar);
}

/// Two scans of three faces each, the first with a layer of one of them and a smaller face, and a photograph between.
std::vector<DepthImage> facesOfTwoPlaces() {
    const double half = std::sqrt(0.5);
    std::vector<DepthImage> images;
    const auto add = [&](const Camera& camera, const glm::dvec3& place, double turn) {
        const Pose pose = poseFromQuaternion(place, 0, turn, 0, std::sqrt(1 - turn * turn));
        images.push_back(scatteredSamples(camera, static_cast<unsigned>(images.size())));
        images.back().worldFromCamera = pose;
        images.back().name = std::to_string(images.size());
    };
    const glm::dvec3 first(0, 0, 0), second(3, 0, 1);
    add(kSquare, first, 0), add(kSquare, second, 0), add(kSquare, first, half),
        add({30, 20, 15, 15, 15, 10}, {1, 2, 3}, 0);
    add({24, 24, 12, 12, 12, 12}, first, -half), add(kSquare, second, half), add(kSquare, first, 0);
    add(kSquare, second, -half);
    return images;
}

TEST(OpenSpaces, AreThoseOfEachImageWithTheRimThatItsPlaceGives) {
    const std::vector<DepthImage> images = facesOfTwoPlaces();
    const ScratchFolder folder;
    const std::vector<StoredImage> stored = writeImages(images, folder.path());
    std::vector<DepthImage> read;
    for (const StoredImage& image : stored)
        read.push_back(readDepthTiff(image.file));
    // Room for one rim at a time, for two, and for all.
    for (const std::size_t rims : {1, 2, 100}) {
        ImageStore store(stored, 4 * rims * Rim::bytesOf(kSquare));
        std::vector<std::string> visited;
        OpenSpaces(store, 0, kNoBodies).forEach([&](const DepthImage& image, const OpenSpace& space) {
            visited.push_back(image.name);
            Rim rim(image.camera, image.worldFromCamera.rotation);
            bool isContinued = false;
            for (const DepthImage& other : read)
                if (other.worldFromCamera.translation == image.worldFromCamera.translation &&
                    Rim::mayShow(image.camera, image.worldFromCamera.rotation, other.camera,
                                 other.worldFromCamera.rotation))
                    rim.take(other), isContinued = true;
            EXPECT_EQ(isContinued, image.name != "4") << "only the photograph stands alone";
            OpenSpace::Buffers own;
            expectTheSame(space, OpenSpace(image, isContinued ? &rim : nullptr, 0, 0, own));
            return true;
        });
        // Place by place, face by face, a layer after its face.
        EXPECT_EQ(visited, (std::vector<std::string>{"1", "7", "3", "5", "4", "2", "6", "8"})) << rims;
    }
}

TEST(OpenSpaces, EndWhereNoMoreAreWanted) {
    ImageStore store(facesOfTwoPlaces());
    OpenSpaces spaces(store, 0, kNoBodies);
    std::size_t visits = 0;
    spaces.forEach([&](const DepthImage&, const OpenSpace&) { return ++visits < 3; });
    EXPECT_EQ(visits, 3u);
}

} // namespace
} // namespace scene
