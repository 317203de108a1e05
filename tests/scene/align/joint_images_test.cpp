// Photographs with range whose poses are off, against those they were taken from.

#include "scene/align/joint_images.h"
#include "scene/refine/colour_evening.h"
#include "scene/synthetic_random.h"

#include "tests/repetitions.h"
#include "tests/scene/known_scenes.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace scene {
namespace {

constexpr int kImages = 10;
constexpr double kDegree = 0.017453292519943295;

Camera fineCamera() {
    return resized(smallCamera(), 320, 240);
}

const std::vector<DepthImage>& truth() {
    static const std::vector<DepthImage> images = imagesOfBareRoom(kImages, fineCamera());
    return images;
}

/// A turn about an axis by an angle of normal distribution, and a step.
Pose disturbed(const Pose& pose, double metres, double radians, SeededSequence& random) {
    const auto some = [&] { // one after the other, so that every compiler draws the same
        glm::dvec3 v;
        for (int i = 0; i < 3; ++i)
            v[i] = random.normal();
        return v;
    };
    const glm::dvec3 half = 0.5 * radians / std::sqrt(3.0) * some();
    const Pose turn = poseFromQuaternion(glm::dvec3(0), half.x, half.y, half.z, 1);
    return {turn.rotation * pose.rotation, pose.translation + metres / std::sqrt(3.0) * some()};
}

/// As a camera would have taken them: noise of both kinds, exposures up to a third of a stop off.
std::vector<DepthImage> taken(std::vector<DepthImage> images, unsigned seed) {
    SeededSequence random(seed);
    for (DepthImage& image : images) {
        applyFactors(image.colour, glm::dvec3(std::exp2(random.between(-0.33, 0.33))));
        for (Rgb8& c : image.colour.pixels())
            for (std::uint8_t* channel : {&c.r, &c.g, &c.b})
                *channel = static_cast<std::uint8_t>(std::clamp(std::lround(*channel + 2 * random.normal()), 0l, 255l));
        for (float& d : image.disparity.pixels())
            d *= static_cast<float>(1 + 0.001 * random.normal());
    }
    return images;
}

void disturb(std::vector<DepthImage>& images, unsigned seed) {
    SeededSequence random(seed);
    for (DepthImage& image : images)
        image.worldFromCamera = disturbed(image.worldFromCamera, 0.015, 0.5 * kDegree, random);
}

JointImages laid(const std::vector<DepthImage>& images, const std::vector<std::uint8_t>& isFollower = {}) {
    std::vector<ImageSketch> sketches;
    std::vector<ImageOutline> outlines;
    for (const DepthImage& image : images) {
        sketches.push_back(sketchOf(image, 1));
        outlines.push_back(outlineOf(sketches.back().depth));
    }
    return layImagesOnEachOther(sketches, 1, findPartners(outlines, 0.1f), isFollower);
}

struct Errors {
    double metres = 0, degrees = 0;
};

/// The worst between neighbours, of how they stand to each other.
Errors errorsBetweenNeighbours(const std::vector<Pose>& found, const std::vector<DepthImage>& true_) {
    Errors worst;
    for (std::size_t i = 0; i < found.size(); ++i) {
        const std::size_t next = (i + 1) % found.size();
        const Pose is = inverse(found[i]) * found[next];
        const Pose shouldBe = inverse(true_[i].worldFromCamera) * true_[next].worldFromCamera;
        worst.metres = std::max(worst.metres, glm::length(is.translation - shouldBe.translation));
        const double cosine = std::min(1.0, cosineBetween(is.rotation, shouldBe.rotation));
        worst.degrees = std::max(worst.degrees, std::acos(cosine) / kDegree);
    }
    return worst;
}

std::vector<Pose> posesOf(const std::vector<DepthImage>& images) {
    std::vector<Pose> poses;
    for (const DepthImage& image : images)
        poses.push_back(image.worldFromCamera);
    return poses;
}

bool areSame(const Pose& a, const Pose& b) {
    return a.rotation == b.rotation && a.translation == b.translation;
}

TEST(JointImages, PosesThatAreOffByPixelsAreFoundAgain) {
    const auto seeds = static_cast<unsigned>(tests::repetitions(5));
    for (unsigned seed = 1; seed <= seeds; ++seed) {
        std::vector<DepthImage> images = taken(truth(), seed);
        disturb(images, 100 + seed);
        const Errors before = errorsBetweenNeighbours(posesOf(images), truth());
        const JointImages found = laid(images);
        const Errors after = errorsBetweenNeighbours(found.worldFromCameras, truth());
        EXPECT_GT(before.metres, 0.02);
        EXPECT_GT(before.degrees, 0.5);
        EXPECT_LT(after.metres, 0.003) << "seed " << seed;
        EXPECT_LT(after.degrees, 0.04) << "seed " << seed;
        EXPECT_EQ(std::count(found.places.begin(), found.places.end(), ImagePlace::adjusted), kImages);
        EXPECT_LT(found.after.range, 0.3 * found.before.range);
        EXPECT_LT(found.after.grey, found.before.grey);
        EXPECT_LT(found.after.against, 0.1 * found.before.against);
        EXPECT_GT(found.movedPixels, 1);
    }
}

TEST(JointImages, ACaptureThatIsRightStaysAsItIs) {
    for (const std::vector<DepthImage>& images : {truth(), taken(truth(), 7)}) {
        const JointImages found = laid(images);
        EXPECT_LT(found.movedPixels, 0.2);
        EXPECT_GT(found.before.agreeing, 10000);
        for (std::size_t i = 0; i < images.size(); ++i) {
            EXPECT_EQ(found.places[i], ImagePlace::given);
            EXPECT_TRUE(areSame(found.worldFromCameras[i], images[i].worldFromCamera));
        }
    }
}

TEST(JointImages, OneWrongAmongManyThatAreRightIsFoundAndMovesNobody) {
    // Of so many images the pairs of one are less than a twentieth of all.
    constexpr int kMany = 54;
    constexpr std::size_t kWrong = 20, kHeldOut = 33;
    const std::vector<DepthImage> rightly = imagesOfBareRoom(kMany, resized(smallCamera(), 160, 120));
    std::vector<DepthImage> images = taken(rightly, 11);
    SeededSequence random(111);
    for (const std::size_t i : {kWrong, kHeldOut})
        images[i].worldFromCamera = disturbed(images[i].worldFromCamera, 0.03, 1 * kDegree, random);
    std::vector<std::uint8_t> isFollower(kMany, 0);
    for (const std::size_t i :
         {std::size_t{5}, std::size_t{12}, std::size_t{19}, std::size_t{26}, kHeldOut, std::size_t{40}})
        isFollower[i] = 1; // the others of these are right
    const JointImages found = laid(images, isFollower);
    EXPECT_LT(found.movedPixels, 0.25) << "else this tests nothing";
    for (std::size_t i = 0; i < images.size(); ++i) {
        const bool isWrong = i == kWrong || i == kHeldOut;
        EXPECT_EQ(found.places[i], isWrong ? ImagePlace::adjusted : ImagePlace::given) << i;
        EXPECT_EQ(areSame(found.worldFromCameras[i], images[i].worldFromCamera), !isWrong) << i;
    }
    const Errors after = errorsBetweenNeighbours(found.worldFromCameras, rightly);
    EXPECT_LT(after.metres, 0.004);
    EXPECT_LT(after.degrees, 0.06);
    EXPECT_LT(found.after.against, found.before.against);
}

TEST(JointImages, AnImageOfAnotherPlaceIsPutBackAndMovesNobody) {
    std::vector<DepthImage> images = taken(truth(), 3);
    disturb(images, 103);
    const Pose claimed = images[4].worldFromCamera;
    const DepthImage& other = truth()[9];
    images[4].colour = other.colour, images[4].disparity = other.disparity, images[4].flags = other.flags;
    const JointImages found = laid(images);
    EXPECT_NE(found.places[4], ImagePlace::adjusted);
    EXPECT_TRUE(areSame(found.worldFromCameras[4], claimed));
    std::vector<Pose> rest = found.worldFromCameras;
    std::vector<DepthImage> trueRest = truth();
    rest.erase(rest.begin() + 4);
    trueRest.erase(trueRest.begin() + 4);
    const Errors after = errorsBetweenNeighbours(rest, trueRest);
    EXPECT_LT(after.metres, 0.003);
    EXPECT_LT(after.degrees, 0.04);
}

TEST(JointImages, ThoseHeldOutAreLaidOnTheOthersWhichKnowNothingOfThem) {
    std::vector<DepthImage> images = taken(truth(), 5);
    disturb(images, 105);
    std::vector<std::uint8_t> isFollower(kImages, 0);
    isFollower[2] = isFollower[7] = 1;
    const JointImages found = laid(images, isFollower);
    const Errors after = errorsBetweenNeighbours(found.worldFromCameras, truth());
    EXPECT_LT(after.metres, 0.004);
    EXPECT_LT(after.degrees, 0.04);
    // Whatever those held out show, and wherever they are said to stand.
    for (const std::size_t i : {std::size_t{2}, std::size_t{7}})
        for (Rgb8& c : images[i].colour.pixels())
            c = {c.b, c.b, c.r};
    images[2].disparity = images[5].disparity;
    const JointImages again = laid(images, isFollower);
    for (std::size_t i = 0; i < images.size(); ++i)
        if (!isFollower[i]) {
            EXPECT_TRUE(areSame(found.worldFromCameras[i], again.worldFromCameras[i])) << i;
        }
}

TEST(JointImages, TheSameOnOneThread) {
    std::vector<DepthImage> images = taken(truth(), 6);
    disturb(images, 106);
    const JointImages many = laid(images);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const JointImages alone = laid(images);
    for (std::size_t i = 0; i < images.size(); ++i)
        EXPECT_TRUE(areSame(many.worldFromCameras[i], alone.worldFromCameras[i]));
    EXPECT_EQ(many.after.agreeing, alone.after.agreeing);
}

TEST(JointImages, FarFromTheOriginPosesAreFoundAsWell) {
    std::vector<DepthImage> images = taken(truth(), 8), far = images;
    disturb(images, 108);
    for (std::size_t i = 0; i < images.size(); ++i)
        far[i].worldFromCamera = {images[i].worldFromCamera.rotation,
                                  images[i].worldFromCamera.translation + glm::dvec3(5e5, 6e6, 300)};
    const Errors after = errorsBetweenNeighbours(laid(far).worldFromCameras, truth());
    EXPECT_LT(after.metres, 0.003);
    EXPECT_LT(after.degrees, 0.04);
}

TEST(JointImages, WithoutAnythingInCommonNothingMoves) {
    std::vector<DepthImage> images{truth()[0], truth()[1]};
    images[1].worldFromCamera.translation += glm::dvec3(1000, 0, 0);
    DepthImage blind = truth()[2];
    for (std::uint8_t& flags : blind.flags.pixels())
        flags = kNoSurface;
    images.push_back(blind);
    const JointImages found = laid(images);
    for (std::size_t i = 0; i < images.size(); ++i) {
        EXPECT_EQ(found.places[i], ImagePlace::given);
        EXPECT_TRUE(areSame(found.worldFromCameras[i], images[i].worldFromCamera));
    }
    EXPECT_EQ(found.before.agreeing, 0);
}

TEST(JointImages, PicturesOfHardlyAPixelDisturbNobody) {
    std::vector<DepthImage> images = taken(truth(), 9);
    for (const int size : {1, 2, 3, 5}) {
        const Camera tiny = resized(fineCamera(), size, size);
        images.push_back(imageOf(tiny, truth()[0].worldFromCamera, [](double, double) { return 0.5; }));
    }
    std::vector<ImageSketch> sketches;
    std::vector<ImageOutline> outlines;
    for (const DepthImage& image : images) {
        sketches.push_back(sketchOf(image, 2)); // the smallest is then nothing
        outlines.push_back(outlineOf(sketches.back().depth));
    }
    const JointImages found = layImagesOnEachOther(sketches, 2, findPartners(outlines, 0.1f), {});
    for (std::size_t i = 0; i < images.size(); ++i)
        EXPECT_TRUE(areSame(found.worldFromCameras[i], images[i].worldFromCamera)) << i;
}

TEST(ImageSketch, ASampleStandsWhereItsSquareStood) {
    const Camera camera = smallCamera();
    const auto disparity = [&](double x, double y) { return planeDisparity(camera, {0.3, 0.2, 0.9}, 2.0, x, y); };
    const ImageSketch sketch = sketchOf(imageOf(camera, {}, disparity), 2);
    const Camera& small = sketch.depth.camera;
    EXPECT_EQ(small.width, 80);
    for (int y = 0; y < small.height; y += 7)
        for (int x = 0; x < small.width; x += 7) {
            EXPECT_TRUE(isSurface(sketch.depth.flags(x, y)));
            EXPECT_NEAR(sketch.depth.disparity(x, y), planeDisparity(small, {0.3, 0.2, 0.9}, 2.0, x + 0.5, y + 0.5),
                        1e-5);
        }
    EXPECT_EQ(sketch.greys.size(), 3u);
    EXPECT_EQ(sketch.greys[2].width(), 20);
}

TEST(ImageSketch, SilhouettesAreLeftOutAndScatteredRangeIsGathered) {
    const Camera camera = smallCamera();
    DepthImage image = imageOf(camera, {}, [](double x, double) { return x < 81 ? 1.0 : 0.5; });
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x)
            if ((x + y) % 2 == 1) image.flags(x, y) = kNoSurface, image.disparity(x, y) = 0;
    const ImageSketch sketch = sketchOf(image, 2);
    for (int y = 0; y < sketch.depth.camera.height; ++y)
        for (int x = 0; x < sketch.depth.camera.width; ++x) {
            EXPECT_EQ(isSurface(sketch.depth.flags(x, y)), x != 40) << x;
            if (x != 40) {
                EXPECT_EQ(sketch.depth.disparity(x, y), x < 40 ? 1.f : 0.5f);
            }
        }
}

TEST(ImageSketch, ItSaysWhatItTakes) {
    const Camera camera = fineCamera();
    const ImageSketch sketch = sketchOf(truth()[0], 2);
    std::size_t bytes = sketch.depth.disparity.size() * sizeof(float) + sketch.depth.flags.size();
    for (const Image<float>& grey : sketch.greys)
        bytes += grey.size() * sizeof(float);
    EXPECT_EQ(bytesOfSketch(camera, 2), bytes);
}

} // namespace
} // namespace scene
