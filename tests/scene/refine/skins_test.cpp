#include "scene/refine/skins.h"

#include "tests/scene/known_scenes.h"
#include "tests/scene/random_poses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include <glm/geometric.hpp>
#include <random>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace scene {
namespace {

using Corners = std::array<std::array<int, 2>, 3>;

/// A triangle of an image's mesh.
struct MeshTriangle {
    int x, y;
    SampleFlag skin;
    Corners corners() const {
        return skin == kSkinUpper ? Corners{{{x, y}, {x + 1, y}, {x, y + 1}}}
                                  : Corners{{{x + 1, y}, {x + 1, y + 1}, {x, y + 1}}};
    }
};

std::vector<MeshTriangle> trianglesOf(const DepthImage& image) {
    std::vector<MeshTriangle> triangles;
    for (int y = 0; y + 1 < image.camera.height; ++y)
        for (int x = 0; x + 1 < image.camera.width; ++x)
            for (const SampleFlag skin : {kSkinUpper, kSkinLower}) {
                const MeshTriangle triangle{x, y, skin};
                const Corners corners = triangle.corners();
                if (std::all_of(corners.begin(), corners.end(),
                                [&](const auto& c) { return isSurface(image.flags(c[0], c[1])); }))
                    triangles.push_back(triangle);
            }
    return triangles;
}

/// How far the triangle's middle is from the surface that is really seen there, relative to its disparity.
double errorAtMiddle(const DepthImage& image, const MeshTriangle& triangle) {
    double x = 0, y = 0, d = 0;
    for (const auto& c : triangle.corners())
        x += (c[0] + 0.5) / 3, y += (c[1] + 0.5) / 3, d += static_cast<double>(image.disparity(c[0], c[1])) / 3;
    const glm::dvec3 ray = rayThrough(image.camera, x, y);
    const auto hit = castRay(bareRoom(), image.worldFromCamera.translation, image.worldFromCamera.rotation * ray);
    return std::abs(d * hit->distanceMetres / glm::length(ray) - 1);
}

std::vector<Partner> everyOther(std::size_t count, std::size_t self) {
    std::vector<Partner> partners;
    for (std::size_t i = 0; i < count; ++i)
        if (i != self) partners.push_back({static_cast<std::uint32_t>(i), 1.f});
    return partners;
}

TEST(PlanarSkins, AreTheTrianglesThatBridgeSilhouettesAndHardlyAnyOther) {
    int bridges = 0, missed = 0, surfaces = 0, lost = 0;
    for (const DepthImage& image : imagesOfBareRoom(6)) {
        SkinFigures figures;
        const Image<std::uint8_t> flags = markPlanarSkins(image, SkinOptions{}.planarity, figures);
        std::int64_t marked = 0;
        for (const MeshTriangle& triangle : trianglesOf(image)) {
            const bool isSkin = (flags(triangle.x, triangle.y) & triangle.skin) != 0;
            marked += isSkin;
            const double error = errorAtMiddle(image, triangle);
            if (error > 0.05) ++bridges, missed += !isSkin;
            if (error < 0.002) ++surfaces, lost += isSkin;
        }
        EXPECT_EQ(figures.planarSkins, marked);
        EXPECT_EQ(figures.triangles, 2 * 159 * 119);
        EXPECT_EQ(figures.samples, 160 * 120);
    }
    EXPECT_GT(bridges, 3000);
    EXPECT_EQ(missed, 0) << "of " << bridges;
    EXPECT_LT(lost, surfaces / 500) << lost << " of " << surfaces;
}

TEST(PlanarSkins, AreNoneOnSteepPlanesAndCreases) {
    const Camera camera = smallCamera();
    SkinFigures figures;
    const auto expectNone = [&](const DepthImage& image, const char* what) {
        const Image<std::uint8_t> flags = markPlanarSkins(image, 0.03f, figures);
        for (int y = 0; y < 119; ++y)
            for (int x = 0; x < 159; ++x) {
                // At the rim a diagonal has a neighbour on one side only, and at two corners none, to explain its
                // slope.
                if (x == 0 || y == 0 || x == 158 || y == 118) continue;
                ASSERT_EQ(flags(x, y), 0) << what << " at " << x << ", " << y;
            }
    };
    // The far rows fall by half from one to the next.
    expectNone(imageOf(camera, {}, [&](double, double y) { return 0.01 + 0.008 * y; }), "a floor");
    expectNone(imageOf(camera, {}, [&](double x, double) { return 0.3 + 0.02 * std::abs(x - 80.5); }), "a crease");
    const DepthImage step = imageOf(camera, {}, [&](double x, double) { return x < 80 ? 0.5 : 0.4; });
    figures = {};
    const Image<std::uint8_t> flags = markPlanarSkins(step, 0.03f, figures);
    EXPECT_EQ(figures.planarSkins, 2 * 119);
    for (int y = 0; y < 119; ++y)
        for (int x = 0; x < 159; ++x)
            ASSERT_EQ(flags(x, y), x == 79 ? kSkinUpper | kSkinLower : 0) << "at " << x << ", " << y;
}

/// The algorithm of Nyland et al. 1999, section 4.4, to the letter: A's mesh is drawn into B through an item buffer;
/// the triangles that are shown where B saw farther are skins and taken out; again, until a pass finds none.
class ItemBuffer {
  public:
    ItemBuffer(const DepthImage& source, const DepthImage& target, const ComparisonOptions& options)
        : source_(source), target_(target), into_(reprojectionInto(target, source)), options_(options),
          triangles_(trianglesOf(source)) {}

    /// Every skin, as an index of trianglesOf(source).
    std::set<std::size_t> findSkins(int& passes) {
        std::set<std::size_t> skins;
        for (passes = 1;; ++passes) {
            const std::size_t before = skins.size();
            draw(skins);
            for (int y = 0; y < target_.camera.height; ++y)
                for (int x = 0; x < target_.camera.width; ++x) {
                    if (nearest_(x, y) <= 0) continue;
                    const Sighting at{static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, nearest_(x, y), 1};
                    if (compareWith(target_, at, options_).relation == Relation::inFront) skins.insert(item_(x, y));
                }
            if (skins.size() == before) return skins;
        }
    }

  private:
    void draw(const std::set<std::size_t>& skins) {
        nearest_ = Image<float>(target_.camera.width, target_.camera.height, 0.f);
        item_ = Image<std::size_t>(target_.camera.width, target_.camera.height, 0);
        for (std::size_t i = 0; i < triangles_.size(); ++i)
            if (!skins.contains(i)) drawTriangle(i);
    }

    void drawTriangle(std::size_t index) {
        std::array<Sighting, 3> p;
        const Corners corners = triangles_[index].corners();
        for (std::size_t i = 0; i < 3; ++i) {
            p[i] = sightingOf(into_, static_cast<float>(corners[i][0]) + 0.5f, static_cast<float>(corners[i][1]) + 0.5f,
                              source_.disparity(corners[i][0], corners[i][1]));
            if (!(p[i].w > 1e-3f)) return;
        }
        const auto [left, right] = std::minmax({p[0].u, p[1].u, p[2].u});
        const auto [top, bottom] = std::minmax({p[0].v, p[1].v, p[2].v});
        const float area = (p[1].u - p[0].u) * (p[2].v - p[0].v) - (p[1].v - p[0].v) * (p[2].u - p[0].u);
        if (area == 0) return;
        for (int y = std::max(0, static_cast<int>(top - 0.5f));
             y < std::min(target_.camera.height, static_cast<int>(bottom + 1)); ++y)
            for (int x = std::max(0, static_cast<int>(left - 0.5f));
                 x < std::min(target_.camera.width, static_cast<int>(right + 1)); ++x) {
                const float dx = static_cast<float>(x) + 0.5f - p[0].u, dy = static_cast<float>(y) + 0.5f - p[0].v;
                const float s = (dx * (p[2].v - p[0].v) - dy * (p[2].u - p[0].u)) / area;
                const float t = ((p[1].u - p[0].u) * dy - (p[1].v - p[0].v) * dx) / area;
                if (s < 0 || t < 0 || s + t > 1) continue;
                const float d =
                    p[0].disparity + s * (p[1].disparity - p[0].disparity) + t * (p[2].disparity - p[0].disparity);
                if (d > nearest_(x, y)) nearest_(x, y) = d, item_(x, y) = index;
            }
    }

    const DepthImage &source_, &target_;
    Reprojection into_;
    ComparisonOptions options_;
    std::vector<MeshTriangle> triangles_;
    Image<float> nearest_;
    Image<std::size_t> item_;
};

// Without planarity, so that reprojection has to find every skin by itself.
TEST(SkinsByReprojection, AreAllThatThePapersRepeatedPassesFind) {
    const std::vector<DepthImage> images = imagesOfBareRoom(6);
    ImageStore store(images);
    int bothFound = 0, paperAlone = 0, deepest = 0;
    for (std::size_t a = 0; a < images.size(); ++a) {
        const auto triangles = trianglesOf(images[a]);
        for (const std::size_t b : {(a + 1) % 6, (a + 5) % 6, (a + 2) % 6}) {
            SkinOptions options;
            options.planarity = 1e9f;
            SkinFigures figures;
            const Image<std::uint8_t> flags =
                markSkins(store, a, {{static_cast<std::uint32_t>(b), 1.f}}, options, figures);
            int passes = 0;
            for (const std::size_t i : ItemBuffer(images[a], images[b], options.comparison).findSkins(passes)) {
                const MeshTriangle& triangle = triangles[i];
                const bool isOurs = (flags(triangle.x, triangle.y) & triangle.skin) != 0;
                (isOurs ? bothFound : paperAlone) += 1;
                EXPECT_GT(errorAtMiddle(images[a], triangle), 1e-4)
                    << "the paper cuts a true surface: image " << a << " in " << b;
            }
            deepest = std::max(deepest, passes);
        }
    }
    EXPECT_GT(bothFound, 1000);
    EXPECT_GE(deepest, 3) << "no skin hides another: the scene asks too little";
    // A triangle may be seen through at a pixel that is none of the places we ask.
    EXPECT_LE(paperAlone, bothFound / 100) << paperAlone << " beside " << bothFound;
}

TEST(SkinsByReprojection, LeaveTrueSurfacesAlone) {
    const std::vector<DepthImage> images = imagesOfBareRoom(8);
    ImageStore store(images);
    int surfaces = 0, lost = 0, bridges = 0, missed = 0;
    for (std::size_t a = 0; a < images.size(); ++a) {
        SkinFigures figures;
        const Image<std::uint8_t> flags = markSkins(store, a, everyOther(images.size(), a), {}, figures);
        EXPECT_EQ(figures.floating, 0) << "image " << a << " has true samples only";
        for (const MeshTriangle& triangle : trianglesOf(images[a])) {
            const double error = errorAtMiddle(images[a], triangle);
            const bool isSkin = (flags(triangle.x, triangle.y) & triangle.skin) != 0;
            if (error < 0.002) ++surfaces, lost += isSkin;
            if (error > 0.02) ++bridges, missed += !isSkin;
        }
    }
    EXPECT_LT(lost, surfaces / 500) << lost << " of " << surfaces;
    EXPECT_LT(missed, bridges / 50) << missed << " of " << bridges;
}

TEST(FloatingSamples, AreFoundAndTrueOnesAreNot) {
    std::vector<DepthImage> images = imagesOfBareRoom(8);
    RandomPlaces random(7);
    std::set<std::pair<int, int>> outliers;
    while (outliers.size() < 300) {
        const int x = random.integerBetween(2, 157), y = random.integerBetween(2, 117);
        if (!outliers.insert({x, y}).second) continue;
        images[0].disparity(x, y) *= static_cast<float>(random.between(1.25, 3));
    }
    const DepthImage image = images[0];
    const std::vector<DepthImage> all = images;
    ImageStore store(std::move(images));
    SkinFigures figures;
    const Image<std::uint8_t> flags = markSkins(store, 0, everyOther(8, 0), {}, figures);
    int found = 0, hidden = 0;
    for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 160; ++x) {
            const bool isFloating = (flags(x, y) & kFloating) != 0;
            if (!outliers.contains({x, y})) {
                ASSERT_FALSE(isFloating) << "a true sample at " << x << ", " << y;
                continue;
            }
            // An outlier before a surface that nobody else sees cannot be known.
            const bool isSeen = std::any_of(all.begin() + 1, all.end(), [&](const DepthImage& other) {
                const Sighting at = sightingOf(reprojectionInto(other, image), static_cast<float>(x) + 0.5f,
                                               static_cast<float>(y) + 0.5f, image.disparity(x, y));
                return compareWith(other, at, {}).relation == Relation::inFront;
            });
            hidden += !isSeen;
            found += isFloating;
        }
    EXPECT_EQ(figures.floating, found);
    EXPECT_LT(hidden, 100) << "the views see too little of each other for this test";
    EXPECT_GE(found, 300 - hidden - 6) << "an outlier may by chance lie on some other surface";
}

TEST(Guesses, ThatOthersMeasuredAreSurfacesAndThatOthersSawThroughAreNothing) {
    std::vector<DepthImage> images = imagesOfBareRoom(8);
    const DepthImage truth = images[0];
    // Columns of guesses, by turns right, too near, and of one image alone.
    for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 160; x += 8) {
            images[0].flags(x, y) = kNoSurface | kInterpolated;
            if (x % 16 == 8) images[0].disparity(x, y) *= 1.5f;
        }
    ImageStore store(images);
    SkinFigures figures;
    const Image<std::uint8_t> flags = markSkins(store, 0, everyOther(8, 0), {}, figures);
    int right = 0, wrong = 0, rightRefuted = 0, wrongConfirmed = 0;
    for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 160; x += 8) {
            const bool isConfirmed = isSurface(flags(x, y)), isRefuted = !isDrawable(flags(x, y));
            if (x % 16 == 8)
                wrong += isRefuted, wrongConfirmed += isConfirmed;
            else
                right += isConfirmed, rightRefuted += isRefuted;
            if (isConfirmed) {
                EXPECT_NE(flags(x, y) & kInterpolated, 0) << "its range still is not its own";
            }
        }
    EXPECT_EQ(figures.confirmed, right + wrongConfirmed);
    EXPECT_EQ(figures.refuted, wrong + rightRefuted);
    EXPECT_EQ(figures.guesses, 20 * 120 - figures.confirmed - figures.refuted);
    EXPECT_GT(right, 600);
    EXPECT_GT(wrong, 600);
    EXPECT_LE(rightRefuted, 2);
    EXPECT_LE(wrongConfirmed, 20) << "by chance on another surface";

    ImageStore alone(std::vector<DepthImage>{images[0]});
    const Image<std::uint8_t> open = markSkins(alone, 0, {}, {}, figures);
    for (int y = 0; y < 120; ++y)
        EXPECT_TRUE(isGuess(open(0, y)) && isGuess(open(8, y))) << "nobody speaks against it";
}

TEST(Skins, TellHowFarApartSurfacesAreAndWhatIsInsideOfThingsThatOthersSeeThrough) {
    // A wall, which the second image has 3 cm farther away; it saw neither the block before it nor the pole.
    const DepthImage wall = imageOf(smallCamera(), {}, [](double x, double y) {
        const bool isBlock = x > 60 && x < 80 && y > 40 && y<60, isPole = x> 100 && x < 105;
        return isBlock || isPole ? 0.5 : 0.25;
    });
    Pose beside;
    beside.translation.x = 0.3;
    const DepthImage other = imageOf(smallCamera(), beside, [](double, double) { return 1 / 4.03; });
    ImageStore store({wall, other});
    SkinFigures figures;
    const Image<std::uint8_t> flags = markSkins(store, 0, everyOther(2, 0), {}, figures);
    ASSERT_EQ(figures.words.size(), 1u);
    EXPECT_GT(figures.words[0].agrees, 10000);
    EXPECT_NEAR(figures.words[0].apartMetres, 0.03, 2e-4) << "across, though most rays go at a slant";
    EXPECT_EQ(figures.floating, 20 * 20 + 5 * 120);
    EXPECT_EQ(figures.floatingInside, 14 * 14) << "of the block; the pole has no inside";
    // From the other side a wall of 6 cm is not one that lies 6 cm off.
    const Pose behind = poseFromQuaternion({0, 0, 8.06}, 0, 1, 0, 0);
    ImageStore sides({imageOf(smallCamera(), {}, [](double, double) { return 0.25; }),
                      imageOf(smallCamera(), behind, [](double, double) { return 0.25; })});
    SkinFigures ofSides;
    markSkins(sides, 0, everyOther(2, 0), {}, ofSides);
    EXPECT_GT(ofSides.words.at(0).agrees, 10000);
    EXPECT_EQ(ofSides.words.at(0).apartMetres, 0);
}

TEST(Skins, TellHowFarApartDenseSurfacesAreThoughNoiseSlopesThem) {
    // Samples 2 mm apart that scatter by as much: of neighbours most of the slope is noise.
    const Camera dense{200, 150, 2000, 2000, 100, 75};
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0, 0.002);
    Pose beside;
    beside.translation.x = 0.05;
    const auto wallAt = [&](double metres, const Pose& from) {
        return imageOf(dense, from, [&, metres](double, double) { return 1 / (metres + noise(random)); });
    };
    ImageStore store({wallAt(4, {}), wallAt(4.04, beside)});
    SkinFigures figures;
    markSkins(store, 0, everyOther(2, 0), {}, figures);
    EXPECT_LT(figures.words.at(0).apartMetres, 0.041);
    EXPECT_GT(figures.words.at(0).apartMetres, 0.035) << "a tenth is lost to slopes that noise makes";
}

TEST(Skins, AreTheSameBytesOnOneThreadAndOnTwoAndWithAnEmptyImageAmongThePartners) {
    std::vector<DepthImage> images = imagesOfBareRoom(4);
    for (auto& flags : images[3].flags.pixels())
        flags = kNoSurface;
    ImageStore store(std::move(images));
    const auto marked = [&](std::size_t threads, std::size_t index) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        SkinFigures figures;
        return markSkins(store, index, everyOther(4, index), {}, figures);
    };
    const Image<std::uint8_t> one = marked(1, 0);
    for (int run = 0; run < 3; ++run)
        EXPECT_TRUE(marked(2, 0) == one) << "run " << run;
    EXPECT_TRUE(marked(2, 3) == store.borrow(3)->flags) << "nothing to mark where there is no surface";
}

} // namespace
} // namespace scene
