#include "scene/refine/cover.h"

#include "scene/coverage_ray.h"
#include "scene/refine/rim.h"
#include "scene/refine/skins.h"
#include "tests/repetitions.h"
#include "tests/scene/known_scenes.h"
#include "tests/scene/scratch_folder.h"
#include "tests/scene/stored_images.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <random>
#include <span>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace scene {
namespace {

const Camera kCamera{64, 48, 50, 50, 32, 24};

/// A wall 2 m before the camera, which looks along the world's z; its left half is at 1 m.
DepthImage stepImage(const Pose& worldFromCamera = {}) {
    DepthImage image = imageOf(kCamera, worldFromCamera, [](double x, double) { return x < kCamera.cx ? 1.0 : 0.5; });
    image.name = "step";
    for (int y = 0; y < kCamera.height; ++y) // the triangles between the halves
        image.flags(kCamera.width / 2 - 1, y) = kSkinUpper | kSkinLower;
    return image;
}

Coverage coverOf(std::vector<DepthImage> images, const CoverOptions& options = {}) {
    ImageStore store(std::move(images));
    CoverFigures figures;
    return cover(store, options, figures);
}

/// What the images' own samples say of a point: observed if it is before some image's sample there, or where a camera
/// stood. dx, dy: asked as many samples beside; stretch: of the point's disparity.
bool isObservedAt(const std::vector<DepthImage>& images, const glm::dvec3& p, double dx, double dy, double stretch) {
    return std::ranges::any_of(images, [&](const DepthImage& image) {
        const glm::dvec3 inCamera = inverse(image.worldFromCamera) * p;
        if (glm::length(inCamera) < stretch * CoverOptions{}.bodyMetres) return true;
        if (inCamera.z <= 0) return false;
        const glm::dvec2 at = project(image.camera, inCamera) + glm::dvec2(dx, dy);
        if (!(at.x >= 0 && at.y >= 0 && at.x < image.camera.width && at.y < image.camera.height)) return false;
        const int x = static_cast<int>(at.x), y = static_cast<int>(at.y);
        return isDrawable(image.flags(x, y)) && stretch / inCamera.z >= double{image.disparity(x, y)};
    });
}

/// Nothing within so many samples, nor within that share of depth, would change the answer.
bool isClear(const std::vector<DepthImage>& images, const glm::dvec3& p, bool observed, double samples, double share) {
    for (const double dx : {-1.0, -0.5, 0.0, 0.5, 1.0})
        for (const double dy : {-1.0, -0.5, 0.0, 0.5, 1.0})
            for (const double stretch : {1 - share, 1.0, 1 + share})
                if (isObservedAt(images, p, dx * samples, dy * samples, stretch) != observed) return false;
    return true;
}

/// Where a camera stood is told by cells of some centimetres.
bool isAtRimOfABody(const std::vector<DepthImage>& images, const glm::dvec3& p) {
    return std::ranges::any_of(images, [&](const DepthImage& image) {
        return std::abs(glm::distance(image.worldFromCamera.translation, p) - CoverOptions{}.bodyMetres) < 0.03;
    });
}

double distanceToSamples(const std::vector<DepthImage>& images, const glm::dvec3& p) {
    double least = 1e9;
    for (const DepthImage& image : images)
        for (int y = 0; y < image.camera.height; ++y)
            for (int x = 0; x < image.camera.width; ++x)
                if (isSurface(image.flags(x, y)) && image.disparity(x, y) > 0)
                    least = std::min(
                        least, glm::length(pointInWorld(image, x + 0.5, y + 0.5, double{image.disparity(x, y)}) - p));
    return least;
}

void expectAgrees(const Coverage& coverage, const std::vector<DepthImage>& images) {
    std::mt19937 random(11);
    const auto uniform = [&] {
        glm::dvec3 p;
        for (const int axis : {2, 1, 0}) // one after the other: the arguments of a call have no order
            p[axis] = static_cast<double>(random()) / 4294967296.0;
        return p;
    };
    int seen = 0, unseen = 0, surfaces = 0;
    for (int i = 0; i < tests::repetitions(40000); ++i) {
        const glm::dvec3 p = coverage.cornerInWorld + coverage.edgeMetres * uniform();
        const bool observed = isObservedAt(images, p, 0, 0, 1);
        const std::optional<CoverageCell> cell = cellAt(coverage, p);
        ASSERT_TRUE(cell);
        const Observed kept = cell->observed;
        if (kept == Observed::surface) { // cells there are some samples wide: it must be near one, no more
            if (++surfaces % 16 == 0) {
                ASSERT_LT(distanceToSamples(images, p), 2 * cell->edgeMetres + 0.02) << p.x << " " << p.y << " " << p.z;
            }
            continue;
        }
        if (!isClear(images, p, observed, 1.5, 0.07) || isAtRimOfABody(images, p)) continue;
        ++(observed ? seen : unseen);
        ASSERT_EQ(kept, observed ? Observed::empty : Observed::unseen) << p.x << " " << p.y << " " << p.z;
    }
    EXPECT_GT(surfaces, tests::repetitions(32));
    EXPECT_GT(seen, tests::repetitions(500));
    EXPECT_GT(unseen, tests::repetitions(500));
}

/// As the stages before leave them: silhouettes marked.
std::vector<DepthImage> markedImages(int count) {
    std::vector<DepthImage> images = imagesOfBareRoom(count);
    SkinFigures figures;
    for (DepthImage& image : images)
        image.flags = markPlanarSkins(image, SkinOptions{}.planarity, figures);
    return images;
}

TEST(Cover, AgreesWithTheSamplesOfOneImage) {
    expectAgrees(coverOf({stepImage()}), {stepImage()});
}

TEST(Cover, WhatEitherImageSawIsObserved) {
    std::vector<DepthImage> images{stepImage(), stepImage(poseFromQuaternion({1.2, 0.1, 0.4}, 0, -0.2, 0, 1))};
    images[1].name = "other";
    expectAgrees(coverOf(images), images);
}

TEST(Cover, AgreesWithImagesOfARoom) {
    const std::vector<DepthImage> images = markedImages(4);
    expectAgrees(coverOf(images), images);
}

TEST(Cover, ASurfaceIsKeptAsOne) {
    const Coverage coverage = coverOf({stepImage()});
    EXPECT_EQ(observedAt(coverage, {0.3, 0.05, 2}), Observed::surface);
    EXPECT_EQ(observedAt(coverage, {-0.3, 0.05, 1}), Observed::surface);
    EXPECT_EQ(observedAt(coverage, {0.3, 0.05, 1}), Observed::empty);
    EXPECT_EQ(observedAt(coverage, {0.01, 0.05, 1.5}), Observed::empty) << "just beside the nearer half";
    EXPECT_EQ(observedAt(coverage, {-0.3, 0.05, 1.5}), Observed::unseen);
}

TEST(Cover, ARayWithoutRangeProvesNothingAndSkyIsOpenWithoutEnd) {
    DepthImage image = stepImage();
    for (int y = 10; y < 30; ++y)
        for (int x = 40; x < 60; ++x)
            image.flags(x, y) = kNoSurface, image.disparity(x, y) = 0;
    const auto through = [](double x, double y, double z) { return z * rayThrough(kCamera, x, y); };
    EXPECT_EQ(observedAt(coverOf({image}), through(50, 20, 1.5)), Observed::unseen);
    EXPECT_EQ(observedAt(coverOf({image}), through(50, 40, 1.5)), Observed::empty);

    for (int y = 10; y < 30; ++y)
        for (int x = 40; x < 60; ++x)
            image.flags(x, y) = 0;
    EXPECT_EQ(observedAt(coverOf({image}), through(50, 20, 1.5)), Observed::empty);
    EXPECT_EQ(observedAt(coverOf({image}), through(50, 20, 2.05)), Observed::empty);

    for (int y = 10; y < 30; ++y)
        for (int x = 40; x < 60; ++x)
            image.flags(x, y) = kNoSurface | kInterpolated, image.disparity(x, y) = 0.8f; // a guess at 1.25 m
    EXPECT_EQ(observedAt(coverOf({image}), through(50, 20, 1.1)), Observed::empty);
    EXPECT_EQ(observedAt(coverOf({image}), through(50, 20, 1.5)), Observed::unseen);
}

/// Of an image's samples those that its own camera does not see for unseen space, as a share of all.
double hiddenShareOf(const Coverage& coverage, const DepthImage& image) {
    const glm::dvec3 eye = image.worldFromCamera.translation;
    int hidden = 0, samples = 0;
    for (int y = 0; y < image.camera.height; ++y)
        for (int x = 0; x < image.camera.width; ++x) {
            if (!isSurface(image.flags(x, y))) continue;
            const glm::dvec3 ray = pointInWorld(image, x + 0.5, y + 0.5, double{image.disparity(x, y)}) - eye;
            const double range = glm::length(ray);
            ++samples;
            hidden += firstUnseen(coverage, eye, ray / range, (1 - kSurfaceSlack) * range).has_value();
        }
    return static_cast<double>(hidden) / samples;
}

TEST(Cover, WhatWasMeasuredIsSeenFromWhereItWasMeasured) {
    // A disc with nothing about it, as scans are that were cut to what matters.
    const Camera camera{200, 200, 250, 250, 100, 100};
    DepthImage image = imageOf(camera, {}, [](double, double) { return 0.5; });
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x)
            if (std::hypot(x - 100, y - 100) > 50) image.flags(x, y) = kNoSurface;
    const auto coverWith = [&](double body) { return coverOf({image}, {.bodyMetres = body}); };
    const double byItself = hiddenShareOf(coverWith(CoverOptions{}.bodyMetres), image);
    const double without = hiddenShareOf(coverWith(0), image);
    std::printf("hidden: %.3f, without a body %.3f\n", byItself, without);
    EXPECT_LT(byItself, 0.05);
    EXPECT_GT(without, 0.2); // what this is about
}

TEST(Cover, NoBodyReachesThroughWhatIsNearerThanItsSize) {
    // A wall 10 cm before one of two cameras that look either way from one place.
    const DepthImage near = imageOf(kCamera, {}, [](double, double) { return 10.0; });
    Pose turned;
    turned.rotation = glm::dmat3(-1, 0, 0, 0, 1, 0, 0, 0, -1);
    const DepthImage far = imageOf(kCamera, turned, [](double, double) { return 0.5; });
    const Coverage coverage = coverOf({near, far});
    EXPECT_EQ(observedAt(coverage, {0, 0, 0.05}), Observed::empty);
    EXPECT_EQ(observedAt(coverage, {0, 0, 0.15}), Observed::unseen);
    EXPECT_EQ(observedAt(coverage, {0.15, 0, 0}), Observed::unseen);
    EXPECT_EQ(observedAt(coverage, {0, 0, -1.5}), Observed::empty);
}

TEST(Cover, FacesOfOneScanLeaveNoSeamBetweenThem) {
    const auto wall = [](double, double) { return 0.5; };
    const Camera square{48, 48, 24, 24, 24, 24};
    std::vector<DepthImage> faces{
        imageOf(square, {}, wall),
        imageOf(square, poseFromQuaternion({0, 0, 0}, 0, std::sqrt(0.5), 0, std::sqrt(0.5)), wall)};
    faces[0].name = "front", faces[1].name = "right";
    const Coverage coverage = coverOf(faces);
    for (double t = 0.1; t < 1.9; t += 0.003)
        ASSERT_NE(observedAt(coverage, {t, 0.05 * t, t}), Observed::unseen) << t;
}

/// Of a cube about the scanner.
std::vector<DepthImage> facesOfAScan() {
    const Camera square{24, 24, 12, 12, 12, 12};
    const double half = std::sqrt(0.5);
    const std::vector<Pose> looks{{},
                                  poseFromQuaternion({0, 0, 0}, 0, half, 0, half),
                                  poseFromQuaternion({0, 0, 0}, 0, 1, 0, 0),
                                  poseFromQuaternion({0, 0, 0}, 0, -half, 0, half),
                                  poseFromQuaternion({0, 0, 0}, half, 0, 0, half),
                                  poseFromQuaternion({0, 0, 0}, -half, 0, 0, half)};
    std::vector<DepthImage> faces;
    for (const Pose& look : looks) {
        faces.push_back(imageOf(square, look, [](double, double) { return 0.5; }));
        faces.back().name = std::to_string(faces.size());
    }
    return faces;
}

TEST(Cover, AFaceIsContinuedByThoseBesideItAlone) {
    const std::vector<DepthImage> faces = facesOfAScan();
    for (std::size_t i = 0; i < faces.size(); ++i) {
        int beside = 0;
        for (const DepthImage& other : faces)
            beside += Rim::mayShow(faces[i].camera, faces[i].worldFromCamera.rotation, other.camera,
                                   other.worldFromCamera.rotation);
        EXPECT_EQ(beside, 4) << "not by itself, nor by the opposite one";
    }
}

TEST(Cover, OfFacesOfAScanOneIsHeldAtATime) {
    const std::vector<DepthImage> faces = facesOfAScan();
    const ScratchFolder folder;
    const std::vector<StoredImage> stored = writeImages(faces, folder.path());
    const std::size_t bytes = bytesOf(faces[0].camera);
    ImageStore all(stored, faces.size() * bytes), few(stored, bytes);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    CoverFigures figures;
    EXPECT_EQ(cover(few, {}, figures), cover(all, {}, figures));
    EXPECT_EQ(few.peakBytes(), bytes);
    EXPECT_GT(figures.emptyCubicMetres, 0);
}

TEST(Cover, IsTheSameOnAnyNumberOfThreads) {
    const std::vector<DepthImage> images = markedImages(3);
    const Coverage many = coverOf(images);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(coverOf(images), many);
}

TEST(Cover, FarFromTheOriginItIsTheSame) {
    const Coverage here = coverOf({stepImage()});
    const Coverage there = coverOf({stepImage({glm::dmat3(1.0), {1e7, -2e7, 3e6}})});
    EXPECT_NEAR(there.edgeMetres, here.edgeMetres, 1e-7);
    EXPECT_EQ(observedAt(there, {1e7 + 0.3, -2e7 + 0.05, 3e6 + 1}), Observed::empty);
    EXPECT_EQ(observedAt(there, {1e7 - 0.3, -2e7 + 0.05, 3e6 + 1.5}), Observed::unseen);
    EXPECT_LE(std::abs(std::ssize(there.nodes) - std::ssize(here.nodes)), std::ssize(here.nodes) / 100);
}

TEST(Cover, WhatWouldTakeTooMuchIsKeptCoarser) {
    ImageStore store(markedImages(3));
    CoverFigures fine, coarse;
    cover(store, {}, fine);
    CoverOptions options;
    options.maxNodes = fine.nodes / 3;
    cover(store, options, coarse);
    EXPECT_LE(coarse.nodes, options.maxNodes);
    EXPECT_LT(coarse.cellsPerSample, fine.cellsPerSample);
    EXPECT_NEAR(coarse.unseenCubicMetres, fine.unseenCubicMetres, 0.1 * fine.unseenCubicMetres);
}

TEST(Cover, IsTheFinestThatMayBeAndAsIfNoFinerOneHadBeenTried) {
    ImageStore store(markedImages(3));
    std::map<double, Coverage> known; ///< without limit, by cells for a sample
    const auto unlimited = [&](double cellsPerSample) -> const Coverage& {
        const auto [at, isNew] = known.try_emplace(cellsPerSample);
        CoverFigures figures;
        if (isNew) at->second = cover(store, {.cellsPerSample = cellsPerSample}, figures);
        return at->second;
    };
    const std::size_t all = unlimited(CoverOptions().cellsPerSample).nodes.size();
    // From what fits, over what an estimate alone cannot tell, to what is given up several times.
    constexpr std::array kShares{0.5, 2.0, 1.0, 0.98, 0.85, 0.2, 0.03};
    for (const double share : std::span(kShares).first(tests::repetitions(kShares.size()))) {
        CoverFigures kept;
        CoverOptions options;
        options.maxNodes = static_cast<std::size_t>(share * static_cast<double>(all));
        std::size_t advanced = 0;
        const Coverage coverage = cover(store, options, kept, [&] { ++advanced; });
        EXPECT_EQ(advanced, 3 * store.size()) << share;
        EXPECT_EQ(kept.nodes, coverage.nodes.size()) << share;
        EXPECT_LE(kept.nodes, options.maxNodes) << share;
        EXPECT_EQ(kept.cellsPerSample == 1, share >= 1) << share;
        EXPECT_EQ(unlimited(kept.cellsPerSample), coverage) << share;
        if (kept.cellsPerSample == 1) continue;
        EXPECT_GT(unlimited(2 * kept.cellsPerSample).nodes.size(), options.maxNodes) << share;
    }
}

TEST(Cover, NoLimitIsNone) {
    ImageStore store(markedImages(2));
    CoverFigures figures;
    const Coverage usual = cover(store, {}, figures);
    EXPECT_EQ(cover(store, {.maxNodes = std::numeric_limits<std::size_t>::max()}, figures), usual);
}

TEST(Cover, ThereIsATreeHoweverFewNodesItMayHave) {
    ImageStore store(markedImages(2));
    CoverFigures figures;
    std::size_t advanced = 0;
    cover(store, {.maxNodes = 1}, figures, [&] { ++advanced; });
    EXPECT_GT(figures.emptyCubicMetres, 0);
    EXPECT_LT(figures.cellsPerSample, 1e-3);
    EXPECT_EQ(advanced, 3 * store.size());
}

TEST(Cover, WithoutSamplesNothingIsKnownButWhereCamerasStood) {
    EXPECT_EQ(observedAt(coverOf({}), {0, 0, 0}), Observed::unseen);
    DepthImage blind = stepImage();
    std::ranges::fill(blind.flags.pixels(), kNoSurface);
    DepthImage another = blind;
    another.worldFromCamera.translation.x = 1;
    const Coverage coverage = coverOf({blind, another});
    EXPECT_EQ(observedAt(coverage, {0, 0, 1e-4}), Observed::empty);
    EXPECT_EQ(observedAt(coverage, {0.9, 0.1, 0}), Observed::empty);
    EXPECT_EQ(observedAt(coverage, {0.5, 0, 0}), Observed::unseen);
}

} // namespace
} // namespace scene
