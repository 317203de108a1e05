#include "scene/refine/redundancy.h"

#include "tests/scene/known_scenes.h"
#include "tests/scene/scratch_folder.h"
#include "tests/scene/stored_images.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace scene {
namespace {

constexpr std::size_t kViews = 8;

std::vector<std::vector<Partner>> partnersOf(ImageStore& store) {
    std::vector<ImageOutline> outlines;
    for (std::size_t i = 0; i < store.size(); ++i)
        outlines.push_back(outlineOf(*store.borrow(i)));
    return findPartners(outlines);
}

struct Result {
    std::vector<KeepMap> kept;
    RedundancyFigures figures;
};

RedundancyOptions optionsOf(float preference, float baselineShare, int tileSize = kDefaultTileSize) {
    RedundancyOptions options;
    options.preference = preference, options.baselineShare = baselineShare, options.tileSize = tileSize;
    return options;
}

Result keepOf(ImageStore& store, const RedundancyOptions& options, std::size_t threads = 2) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    Result result;
    result.kept = findKept(store, partnersOf(store), options, result.figures);
    return result;
}

/// Calls visit(image, x, y) for each surface sample.
template <class Visit>
void forSamples(const std::vector<DepthImage>& images, Visit visit) {
    for (std::size_t i = 0; i < images.size(); ++i)
        for (int y = 0; y < images[i].camera.height; ++y)
            for (int x = 0; x < images[i].camera.width; ++x)
                if (isSurface(images[i].flags(x, y))) visit(i, x, y);
}

std::string at(std::size_t i, int x, int y) {
    return "image " + std::to_string(i) + " at " + std::to_string(x) + ", " + std::to_string(y);
}

/// Whether an image keeps the surface that a sample of another one means, and where its camera stands.
template <class IsKept>
bool isHeldElsewhere(const std::vector<DepthImage>& images, std::size_t i, int x, int y,
                     const ComparisonOptions& options, IsKept isKept) {
    for (std::size_t j = 0; j < images.size(); ++j) {
        if (j == i) continue;
        const Sighting seen = sightingOf(reprojectionInto(images[j], images[i]), static_cast<float>(x) + 0.5f,
                                         static_cast<float>(y) + 0.5f, images[i].disparity(x, y));
        if (compareWith(images[j], seen, options).relation == Relation::agrees &&
            isKept(j, static_cast<int>(seen.u), static_cast<int>(seen.v)))
            return true;
    }
    return false;
}

/// The room with holes: some samples absent, some floating.
std::vector<DepthImage> holedImages() {
    std::vector<DepthImage> images = imagesOfBareRoom(kViews);
    for (auto& image : images)
        for (int y = 0; y < 120; ++y)
            for (int x = 0; x < 160; ++x) {
                if ((x / 9 + y / 7) % 11 == 0) image.flags(x, y) = kNoSurface;
                if ((x * 7 + y * 3) % 53 == 0) image.flags(x, y) = kFloating;
            }
    return images;
}

TEST(Redundancy, BothSidesOfAThinBoardAreKept) {
    // 10 cm thick, seen squarely and at a slant from 6 m on either side: each says as well where the other's side is.
    const double turn = std::sin(glm::radians(15.0)), half = std::cos(glm::radians(15.0));
    for (const bool isSlanted : {false, true}) {
        const Pose front = isSlanted ? poseFromQuaternion({-3, 0, 0.8}, 0, turn, 0, half) : Pose{},
                   back = poseFromQuaternion({0, 0, 12}, 0, 1, 0, 0);
        const auto sideOf = [](const Pose& pose, double z, const char* name) {
            const glm::dvec3 normal = glm::transpose(pose.rotation) * glm::dvec3(0, 0, 1);
            DepthImage image = imageOf(smallCamera(), pose, [&](double x, double y) {
                return planeDisparity(smallCamera(), normal, z - pose.translation.z, x, y);
            });
            image.name = name;
            return image;
        };
        const std::vector<DepthImage> images{sideOf(front, 5.95, "front"), sideOf(back, 6.05, "back")};
        ImageStore store(images);
        ASSERT_FALSE(partnersOf(store)[0].empty()) << "else this tests nothing";
        const auto [kept, figures] = keepOf(store, {});
        EXPECT_EQ(figures.base, figures.samples) << isSlanted;
    }
}

TEST(Redundancy, DropsNothingThatNobodyElseKeeps) {
    const std::vector<DepthImage> images = holedImages();
    ImageStore store(images);
    for (const RedundancyOptions& options : {RedundancyOptions{}, optionsOf(1.f, 0.f), optionsOf(100.f, 0.2f, 7)}) {
        const auto [kept, figures] = keepOf(store, options);
        std::int64_t samples = 0, base = 0, directional = 0;
        forSamples(images, [&](std::size_t i, int x, int y) {
            const Keep keep = kept[i](x, y);
            ++samples;
            base += keep == Keep::base;
            directional += keep == Keep::directional;
            if (keep == Keep::base) return;
            ASSERT_TRUE(isHeldElsewhere(images, i, x, y, options.comparison,
                                        [&](std::size_t j, int u, int v) { return kept[j](u, v) == Keep::base; }))
                << at(i, x, y) << ": the base has a hole";
        });
        EXPECT_EQ(figures.samples, samples);
        EXPECT_EQ(figures.base, base);
        EXPECT_EQ(figures.directional, directional);
        EXPECT_LT(base, samples * 7 / 10) << "hardly anything was redundant";
        EXPECT_EQ(directional > 0, options.baselineShare > 0);
        for (std::size_t i = 0; i < images.size(); ++i)
            for (int y = 0; y < 120; ++y)
                for (int x = 0; x < 160; ++x)
                    if (!isSurface(images[i].flags(x, y))) {
                        ASSERT_EQ(kept[i](x, y), Keep::no) << at(i, x, y) << " is no surface";
                    }
    }
}

TEST(Redundancy, ShowsEverySurfaceFromNearEveryCameraThatSawIt) {
    const std::vector<DepthImage> images = imagesOfBareRoom(kViews);
    ImageStore store(images);
    RedundancyOptions options;
    options.baselineShare = 0.8f;
    options.minPatchShare = 0;
    const auto [kept, figures] = keepOf(store, options);
    EXPECT_LT(figures.directional, figures.samples - figures.base) << "all that is not base is kept for its looks";
    forSamples(images, [&](std::size_t i, int x, int y) {
        if (kept[i](x, y) != Keep::no) return;
        const double range = glm::length(rayThrough(images[i].camera, x + 0.5, y + 0.5)) /
                             static_cast<double>(images[i].disparity(x, y));
        ASSERT_TRUE(isHeldElsewhere(images, i, x, y, options.comparison,
                                    [&](std::size_t j, int u, int v) {
                                        const double baseline = glm::distance(images[i].worldFromCamera.translation,
                                                                              images[j].worldFromCamera.translation);
                                        return kept[j](u, v) != Keep::no && baseline <= 0.8 * range * (1 + 1e-5);
                                    }))
            << at(i, x, y) << ": dropped, and no camera near it keeps that surface";
    });
}

TEST(Redundancy, SmallDirectionalPatchesAreLeftToTheBase) {
    const std::vector<DepthImage> images = imagesOfBareRoom(kViews);
    ImageStore store(images);
    RedundancyOptions options;
    options.baselineShare = 0.8f;
    options.minPatchShare = 0;
    const auto [all, allFigures] = keepOf(store, options);
    options.minPatchShare = 0.25f;
    const auto [kept, figures] = keepOf(store, options);
    EXPECT_EQ(figures.base, allFigures.base);
    EXPECT_LT(figures.directional, allFigures.directional);
    const int size = options.tileSize;
    for (std::size_t i = 0; i < images.size(); ++i)
        for (int y0 = 0; y0 < images[i].camera.height; y0 += size)
            for (int x0 = 0; x0 < images[i].camera.width; x0 += size) {
                int patch = 0;
                for (int y = y0; y < std::min(y0 + size, images[i].camera.height); ++y)
                    for (int x = x0; x < std::min(x0 + size, images[i].camera.width); ++x)
                        patch += kept[i](x, y) == Keep::directional;
                EXPECT_TRUE(patch == 0 || patch >= size * size / 4) << patch << " samples, " << at(i, x0, y0);
            }
}

/// The first image's left half lost its range, rightly guessed; nobody else looks there.
TEST(Redundancy, OpenGuessesAreKeptOnceAndNeverForWhatWasMeasured) {
    std::vector<DepthImage> images = imagesOfBareRoom(1);
    for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 80; ++x)
            images[0].flags(x, y) = kNoSurface | kInterpolated;
    images.push_back(images[0]); // the same guesses again
    images.push_back(imagesOfBareRoom(1)[0]);
    for (int y = 0; y < 120; ++y)
        for (int x = 40; x < 120; ++x)
            images[2].flags(x, y) = kNoSurface; // measured in the left quarter, and enough to be a partner
    ImageStore store(images);
    const auto [kept, figures] = keepOf(store, {});
    EXPECT_EQ(figures.samples, 2 * 80 * 120 + 2 * 40 * 120);
    EXPECT_EQ(figures.base, 120 * 120);
    int guesses = 0;
    for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 80; ++x) {
            const int mine = (kept[0](x, y) != Keep::no) + (kept[1](x, y) != Keep::no);
            if (x < 39) {
                EXPECT_EQ(mine, 0) << "measured by another, at " << x << ", " << y;
            }
            if (x > 41) {
                EXPECT_EQ(mine, 1) << "at " << x << ", " << y;
            }
            guesses += mine;
        }
    EXPECT_EQ(figures.guesses, guesses);
}

TEST(Redundancy, KeepsOneOfTwoEqualImages) {
    std::vector<DepthImage> images = imagesOfBareRoom(1);
    images.push_back(images[0]);
    ImageStore store(images);
    const auto [kept, figures] = keepOf(store, {});
    EXPECT_EQ(figures.base, 160 * 120) << "of twice as many";
    EXPECT_EQ(figures.directional, 0);
    forSamples(images, [&](std::size_t i, int x, int y) {
        ASSERT_NE(kept[i](x, y) == Keep::no, kept[1 - i](x, y) == Keep::no) << at(i, x, y);
    });
}

TEST(Redundancy, PrefersTheImageThatSamplesBetter) {
    const DepthImage far = imageOf(smallCamera(), {}, [](double, double) { return 0.25; });
    const DepthImage near = imageOf(smallCamera(), {glm::dmat3(1.0), {0, 0, 2}}, [](double, double) { return 0.5; });
    for (const bool nearFirst : {false, true}) {
        ImageStore store(nearFirst ? std::vector{near, far} : std::vector{far, near});
        const auto [kept, figures] = keepOf(store, optionsOf(1.5f, 0.f));
        const Image<Keep> keptNear = kept[nearFirst ? 0 : 1].whole(), keptFar = kept[nearFirst ? 1 : 0].whole();
        EXPECT_EQ(std::count(keptNear.pixels().begin(), keptNear.pixels().end(), Keep::base), 160 * 120);
        EXPECT_EQ(keptFar(80, 60), Keep::no);
        EXPECT_EQ(keptFar(10, 10), Keep::base) << "what only the far one sees";
    }
}

/// Places where what is kept borders on what is not, within images: the seams.
int seamsOf(const std::vector<KeepMap>& kept) {
    int seams = 0;
    for (const KeepMap& map : kept) {
        const Image<Keep> image = map.whole();
        for (int y = 0; y + 1 < image.height(); ++y)
            for (int x = 0; x + 1 < image.width(); ++x)
                seams += ((image(x, y) == Keep::no) != (image(x + 1, y) == Keep::no)) +
                         ((image(x, y) == Keep::no) != (image(x, y + 1) == Keep::no));
    }
    return seams;
}

TEST(Redundancy, KeepsFewerSamplesInLargerPiecesTheGreaterThePreference) {
    ImageStore store(imagesOfBareRoom(kViews));
    std::int64_t base = std::numeric_limits<std::int64_t>::max();
    int seams = std::numeric_limits<int>::max();
    for (const float preference : {1.f, 2.f, 100.f}) {
        const auto [kept, figures] = keepOf(store, optionsOf(preference, 0.f));
        EXPECT_LE(figures.base, base) << "preference " << preference;
        EXPECT_LE(seamsOf(kept), seams) << "preference " << preference;
        base = figures.base, seams = seamsOf(kept);
    }
}

TEST(Redundancy, GivesTheSameBytesOnOneThreadAndOnTwo) {
    ImageStore store(holedImages());
    const Result one = keepOf(store, {}, 1);
    for (int run = 0; run < 3; ++run) {
        const Result two = keepOf(store, {}, 2);
        EXPECT_TRUE(two.kept == one.kept) << "run " << run;
        EXPECT_EQ(two.figures.base, one.figures.base);
        EXPECT_EQ(two.figures.directional, one.figures.directional);
    }
}

TEST(Redundancy, IsTheSameWithRoomForTwoImagesAtATime) {
    std::vector<DepthImage> images = holedImages();
    for (std::size_t i = 0; i < images.size(); ++i)
        images[i].name = std::to_string(i);
    ASSERT_GE(images.size(), 4u);
    ImageStore all(images);
    const auto partners = partnersOf(all);
    RedundancyFigures figures;
    const auto kept = findKept(all, partners, {}, figures);
    const ScratchFolder folder;
    for (const std::size_t room : {2, 3})
        for (const std::size_t threads : {1, 3}) {
            ImageStore few(writeImages(images, folder.path()), room * bytesOf(images[0].camera));
            RedundancyFigures figuresOfFew;
            std::size_t advanced = 0;
            const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
            EXPECT_TRUE(findKept(few, partners, {}, figuresOfFew, [&] { ++advanced; }) == kept) << room;
            EXPECT_EQ(figuresOfFew.base, figures.base);
            EXPECT_EQ(figuresOfFew.directional, figures.directional);
            EXPECT_EQ(advanced, images.size());
            // Each thread that rates tiles holds an image of its own.
            EXPECT_LE(few.peakBytes(), std::max(room, threads) * bytesOf(images[0].camera)) << room;
        }
}

TEST(KeepMap, HoldsWhatWasSetOfEachSample) {
    const Image<Keep> truth = [] {
        Image<Keep> keeps(21, 13);
        std::mt19937 random(3);
        for (Keep& keep : keeps.pixels())
            keep = static_cast<Keep>(random() % 3);
        return keeps;
    }();
    KeepMap map(21, 13), base(21, 13, Keep::base);
    EXPECT_FALSE(map.mayHaveAnyIn({0, 0, 21, 13}));
    for (int y = 0; y < 13; ++y)
        for (int x = 0; x < 21; ++x) {
            EXPECT_EQ(base(x, y), Keep::base);
            map.set(x, y, truth(x, y)), base.set(x, y, truth(x, y));
        }
    EXPECT_TRUE(map == base);
    EXPECT_TRUE(map.whole() == truth && base.whole() == truth);
    for (int y = 0; y < 13; ++y)
        for (int x = 0; x < 21; ++x)
            EXPECT_EQ(map.has(x, y), truth(x, y) != Keep::no);
    KeepMap one(21, 13);
    one.set(20, 12, Keep::directional);
    EXPECT_TRUE(one.mayHaveAnyIn({16, 8, 21, 13}));
    EXPECT_FALSE(one.mayHaveAnyIn({0, 0, 16, 13}));
    EXPECT_FALSE(one.mayHaveAnyIn({21, 13, 20, 12})) << "an empty box";
}

TEST(Redundancy, OfNothingAndOfSky) {
    RedundancyFigures figures;
    ImageStore none(std::vector<DepthImage>{});
    EXPECT_TRUE(findKept(none, {}, {}, figures).empty());
    // Two images that see the same sky, infinitely far: one of them keeps it.
    std::vector<DepthImage> images(2, imageOf(smallCamera(), {}, [](double, double) { return 0.0; }));
    ImageStore sky(images);
    const auto kept = findKept(sky, {{{1, 1.f}}, {{0, 1.f}}}, {}, figures);
    EXPECT_EQ(figures.base, 160 * 120);
    EXPECT_EQ(figures.directional, 0);
}

} // namespace
} // namespace scene
