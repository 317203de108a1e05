// Unseen truth: few scans of places of known geometry, many eyes; whatever a ray meets before what is drawn is asked of
// the geometry itself, not of the images.
//
// A point is *observed* by a scan if the scanner's ray towards it got an echo (not from the sky, nor from below the
// scan's last row) and no surface of the place stands on that ray before the point; or if the scanner itself stood
// there. Scans have samples, not rays without end, so at the rims of what a scan saw its own spacing is left open
// either way:
//   surely unseen    four rays to places a spacing beside the point, and the one to it, all end before the point by
//                    more than a spacing, or have no echo; for every scan
//   surely observed  all five reach the point and have an echo; for one scan
// A pixel's ray *meets the unseen* if some point of it before the true surface is surely unseen, and is *observed* if
// all its points up to a spacing before that surface are surely observed. What is neither is not counted; its share is
// told, and bounded.

#include "render/post/unseen.h"
#include "scene/coverage_levels.h"
#include "scene/image_store.h"
#include "scene/overlap.h"
#include "scene/project/cube_faces.h"
#include "scene/refine/cover.h"
#include "scene/refine/skins.h"
#include "scene/synthetic.h"
#include "scene/synthetic_tracer.h"
#include "tests/render/test_device.h"
#include "tests/repetitions.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include <tbb/parallel_for.h>

namespace render {
namespace {

constexpr int kColumns = 1200, kRows = 500;
constexpr int kPixelStep = 647; ///< of a picture's pixels every so many is asked about
constexpr double kEyeDistanceMetres = 0.063;

struct Place {
    scene::SyntheticScene truth;
    std::vector<scene::Pose> scanners;
    std::vector<scene::DepthImage> images;
    std::vector<scene::TileSet> sets;
    scene::Coverage coverage;
    scene::CoverFigures figures;
};

Place scanPlace(scene::SyntheticScene truth, std::size_t scans) {
    Place place{std::move(truth), {}, {}, {}, {}, {}};
    for (const scene::Pose& scanner : scene::scanPositions(place.truth)) {
        if (place.scanners.size() == scans) break;
        place.scanners.push_back(scanner);
        scene::Scan scan = scene::simulateScan(place.truth, scanner, kColumns, kRows);
        scan.name = "scan" + std::to_string(place.scanners.size());
        for (scene::DepthImage& face : scene::projectToCubeFaces(scan).faces)
            place.images.push_back(std::move(face));
    }
    scene::ImageStore store(place.images);
    std::vector<scene::ImageOutline> outlines;
    for (const scene::DepthImage& image : place.images)
        outlines.push_back(scene::outlineOf(image));
    const auto partners = scene::findPartners(outlines);
    tbb::parallel_for(std::size_t{0}, place.images.size(), [&](std::size_t i) {
        scene::SkinFigures figures;
        place.images[i].flags = scene::markSkins(store, i, partners[i], {}, figures);
    });
    scene::ImageStore marked(place.images);
    place.coverage = scene::cover(marked, {}, place.figures);
    for (const scene::DepthImage& image : place.images)
        place.sets.push_back(scene::cutIntoTiles(image));
    return place;
}

/// Where a scanner stood space is empty, whatever its rays met.
constexpr double kBodyMetres = scene::CoverOptions{}.bodyMetres;

/// The scans' own spacing, radians; cells of the grid are as wide as they are high.
constexpr double kSpacing = 2 * 3.14159265358979 / kColumns;

enum class Observation { surelyUnseen, unsure, surelyObserved };

class Truth {
  public:
    explicit Truth(const Place& place) : place_(place) {
        const scene::ScanOptions defaults;
        lowestForAny_ = std::sin(defaults.bottomRadians - kSpacing);
        lowestForAll_ = std::sin(defaults.bottomRadians + kSpacing);
    }

    /// Places that are asked about together; one look at the five rays of a scan to each answers both questions.
    static constexpr std::size_t kPlaces = scene::SyntheticTracer::kTogether / 5;

    /// first: the scan to ask first, that which saw the places beside these; becomes the one that sees the last.
    std::array<Observation, kPlaces> observationsOf(std::span<const glm::dvec3> places, std::size_t& first) const {
        std::array<Observation, kPlaces> found;
        found.fill(Observation::surelyUnseen);
        std::array<std::size_t, kPlaces> open{}; ///< indices of those that no scan surely observed
        std::size_t openCount = places.size();
        std::iota(open.begin(), open.end(), std::size_t{0});
        for (std::size_t k = 0, begin = first; k < place_.scanners.size() && openCount > 0; ++k) {
            const std::size_t scan = (begin + k) % place_.scanners.size();
            const glm::dvec3 scanner = place_.scanners[scan].translation;
            const auto reached = reachOf(scanner, places, {open.data(), openCount});
            std::size_t still = 0;
            for (std::size_t i = 0; i < openCount; ++i) {
                const std::size_t at = open[i];
                if (reached[i] == Reach::all || glm::distance(places[at], scanner) < kBodyMetres) {
                    found[at] = Observation::surelyObserved;
                    first = scan;
                } else {
                    if (reached[i] == Reach::some) found[at] = Observation::unsure;
                    open[still++] = at;
                }
            }
            openCount = still;
        }
        return found;
    }
    double spacingAt(const glm::dvec3& p) const {
        double nearest = 1e9;
        for (const scene::Pose& scanner : place_.scanners)
            nearest = std::min(nearest, glm::length(p - scanner.translation));
        return nearest * kSpacing;
    }

  private:
    /// From the scanner to the point and to four places a spacing beside it.
    static std::array<glm::dvec3, 5> raysAbout(const glm::dvec3& scanner, const glm::dvec3& p) {
        const glm::dvec3 ray = p - scanner;
        const double step = glm::length(ray) * kSpacing;
        const glm::dvec3 side = glm::normalize(
            glm::cross(ray, std::abs(ray.z) < 0.9 * glm::length(ray) ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0)));
        const glm::dvec3 up = glm::normalize(glm::cross(side, ray));
        return {ray, ray + step * side, ray - step * side, ray + step * up, ray - step * up};
    }
    enum class Reach { none, some, all };

    /// Of those of the places. All: every ray has an echo, at the place or behind it. None: not one, by the scan's
    /// spacing.
    std::array<Reach, kPlaces> reachOf(const glm::dvec3& scanner, std::span<const glm::dvec3> places,
                                       std::span<const std::size_t> asked) const {
        std::array<glm::dvec3, 5 * kPlaces> rays;
        for (std::size_t i = 0; i < asked.size(); ++i)
            std::ranges::copy(raysAbout(scanner, places[asked[i]]), rays.begin() + static_cast<std::ptrdiff_t>(5 * i));
        const auto hits = place_.truth.tracer().castTogether(scanner, {rays.data(), 5 * asked.size()});
        std::array<Reach, kPlaces> reached{};
        for (std::size_t i = 0; i < asked.size(); ++i) {
            bool isAny = false, areAll = true;
            for (std::size_t r = 5 * i; r < 5 * (i + 1); ++r) {
                const double height = rays[r].z / glm::length(rays[r]);
                isAny = isAny || (hits[r] && height > lowestForAny_ && hits[r]->t > 1 - kSpacing);
                areAll = areAll && hits[r] && height > lowestForAll_ && hits[r]->t >= 1;
            }
            reached[i] = areAll ? Reach::all : isAny ? Reach::some : Reach::none;
        }
        return reached;
    }

    const Place& place_;
    double lowestForAny_, lowestForAll_; ///< sines of elevations
};

enum class RayTruth { meetsUnseen, observed, between };

RayTruth judge(const Place& place, const Truth& truth, const glm::dvec3& eye, const glm::dvec3& direction) {
    const auto hit = place.truth.tracer().cast(eye, direction);
    const double end = hit ? hit->t * glm::length(direction) : 100;
    const glm::dvec3 unit = glm::normalize(direction);
    bool isObserved = true;
    std::size_t scan = 0;
    double t = 0.01;
    for (bool isOver = false; !isOver;) {
        std::array<glm::dvec3, Truth::kPlaces> next;
        std::size_t count = 0;
        while (count < next.size() && !isOver) {
            const glm::dvec3 p = eye + t * unit;
            const double spacing = truth.spacingAt(p);
            isOver = t >= end || (hit && t > end - spacing);
            if (isOver) break;
            next[count++] = p;
            t += std::max(2 * spacing, 0.02);
        }
        const auto observations = truth.observationsOf({next.data(), count}, scan);
        for (std::size_t i = 0; i < count; ++i) {
            if (observations[i] == Observation::surelyUnseen) return RayTruth::meetsUnseen;
            isObserved = isObserved && observations[i] == Observation::surelyObserved;
        }
    }
    // A ray into the sky is never observed to its end, nor does it meet anything surely.
    return isObserved && hit ? RayTruth::observed : RayTruth::between;
}

constexpr scene::Camera kCamera{256, 192, 128, 128, 128, 96};
constexpr int kPixels = 2 * kCamera.width * kCamera.height; ///< of both eyes
/// Every pixel that is drawn wrongly is found; how many there are to be right about goes by one in so many.
constexpr int kCountedBy = 5;
constexpr int kAsked = kPixels / kPixelStep / kCountedBy * kCountedBy; ///< of a pose

/// What the geometry says of the pixels that are asked about, along a path. It does not depend on how they are drawn,
/// and is found when first asked for. A pixel is as wide as it is, and what is drawn
/// in it may reach into it from beside: it counts where its middle and four places `reach` pixels away, across and
/// down, agree.
class PathTruth {
  public:
    PathTruth(const Place& place, int poses)
        : place_(place), truth_(place), known_(static_cast<std::size_t>(poses) * kAsked) {
        for (const scene::View& head : scene::walkPath(place.truth, poses, kCamera)) {
            const auto [left, right] = scene::eyesOf(kCamera, head.worldFromEye, kEyeDistanceMetres);
            eyes_.push_back({left, right});
        }
    }
    int poses() const { return static_cast<int>(eyes_.size()); }
    std::span<const scene::View> eyes(int pose) const { return eyes_[static_cast<std::size_t>(pose)]; }

    struct Pixel {
        std::size_t eye;
        int x, y;
    };
    /// Other ones in each pose. k: below kAsked.
    static Pixel pixelOf(int pose, int k) {
        const int i = k * kPixelStep + 7 * pose % kPixelStep, ofEye = i % (kPixels / 2);
        return {static_cast<std::size_t>(i / (kPixels / 2)), ofEye % kCamera.width, ofEye / kCamera.width};
    }

    /// Both may be asked by many threads at a time, about other pixels each.
    RayTruth ofMiddle(int pose, int k) {
        Known& known = knownOf(pose, k);
        const Pixel pixel = pixelOf(pose, k);
        if (!known.middle) known.middle = judgeAt(eyes(pose)[pixel.eye], pixel.x + 0.5, pixel.y + 0.5);
        return *known.middle;
    }
    /// Between where the middle and the four places do not agree; four times as dear.
    RayTruth ofWhole(int pose, int k, double reach) {
        if (ofMiddle(pose, k) == RayTruth::between) return RayTruth::between;
        Known& known = knownOf(pose, k);
        const Pixel pixel = pixelOf(pose, k);
        const scene::View& eye = eyes(pose)[pixel.eye];
        if (!known.whole || known.reach != reach) {
            known.reach = reach, known.whole = known.middle;
            for (const double dy : {-reach, reach})
                for (const double dx : {-reach, reach})
                    if (known.whole != RayTruth::between &&
                        judgeAt(eye, pixel.x + 0.5 + dx, pixel.y + 0.5 + dy) != *known.middle)
                        known.whole = RayTruth::between;
        }
        return *known.whole;
    }

  private:
    struct Known {
        std::optional<RayTruth> middle, whole;
        double reach = 0; ///< of whole
    };
    Known& knownOf(int pose, int k) {
        return known_[static_cast<std::size_t>(pose) * kAsked + static_cast<std::size_t>(k)];
    }
    RayTruth judgeAt(const scene::View& eye, double u, double v) const {
        return judge(place_, truth_, eye.worldFromEye.translation,
                     eye.worldFromEye.rotation * scene::rayThrough(eye.camera, u, v));
    }

    const Place& place_;
    Truth truth_;
    std::vector<std::array<scene::View, 2>> eyes_;
    std::vector<Known> known_;
};

/// Points are squares of up to Quality::maxFootprint pixels and stand out of their surface's rim by half of that.
struct How {
    Warp warp = Warp::mesh;
    double reach = 1;
    int every = 2; ///< of the path's poses, 200 of 400; all of them in long tests alone, else one in kSparsely
    /// Of the coverage's tree; 0: all. Fewer are brought where a device has no room for the finest cells, here wider
    /// than a sample of these scans, and it is the same truth still. Few places decide what is missed of one pixel in a
    /// thousand, and one pose sees several pixels of such a place: of the coarsest many poses are asked.
    int levels = 0;
    double leastCellMetres = 0; ///< than which cells are then wider
};

constexpr int kPoses = 400, kSparsely = 4;

struct Count {
    std::atomic<std::int64_t> unseen{0}, missed{0}, observed{0}, wronged{0}, between{0};
};

/// A way of drawing the place, and what came of it.
struct Row {
    Row(const How& asked, std::size_t nodeCount, double finest) : how(asked), nodes(nodeCount), finestMetres(finest) {}
    How how;
    std::size_t nodes = 0;
    double finestMetres = 0;
    std::unique_ptr<GpuCoverage> coverage{};
    Count count{};
};

std::unique_ptr<Row> rowOf(const Place& place, const How& how) {
    const scene::Coverage coverage = how.levels == 0 ? place.coverage : scene::coarsened(place.coverage, how.levels);
    auto row = std::make_unique<Row>(how, coverage.nodes.size(), scene::finestCellOf(coverage));
    EXPECT_GE(row->finestMetres, how.leastCellMetres);
    row->coverage = std::make_unique<GpuCoverage>(testDevice(), coverage);
    return row;
}

void count(PathTruth& truth, int pose, const std::vector<EyeImage>& pictures, double reach, Count& count) {
    tbb::parallel_for(0, kAsked, [&](int k) {
        const PathTruth::Pixel pixel = PathTruth::pixelOf(pose, k);
        const bool isUnseen = pictures[pixel.eye].pixelClass(pixel.x, pixel.y) == 3;
        const RayTruth wrong = isUnseen ? RayTruth::observed : RayTruth::meetsUnseen;
        const bool mayBeWrong = truth.ofMiddle(pose, k) == wrong, isCounted = k % kCountedBy == 0;
        if (!mayBeWrong && !isCounted) return;
        const RayTruth whole = truth.ofWhole(pose, k, reach);
        if (whole == wrong) ++(isUnseen ? count.wronged : count.missed);
        if (isCounted)
            (whole == RayTruth::meetsUnseen ? count.unseen
             : whole == RayTruth::observed  ? count.observed
                                            : count.between) += kCountedBy;
    });
}

void expectTruth(const Row& row) {
    const Count& count = row.count;
    const double all = static_cast<double>(count.unseen + count.observed + count.between);
    const double missed = static_cast<double>(count.missed) / static_cast<double>(count.unseen);
    const double wronged = static_cast<double>(count.wronged) / static_cast<double>(count.observed);
    std::printf("%llu nodes, cells down to %.1f mm; %lld pixels meet the unseen, %.3f %% of them not shown so; "
                "%lld are of what was observed, %.3f %% of them called unseen; %.1f %% lie between\n",
                static_cast<unsigned long long>(row.nodes), 1e3 * row.finestMetres,
                static_cast<long long>(count.unseen), 100 * missed, static_cast<long long>(count.observed),
                100 * wronged, 100 * static_cast<double>(count.between) / all);
    EXPECT_GT(count.unseen, 1000);
    EXPECT_GT(count.observed, 1000);
    EXPECT_LE(missed, 0.001);
    EXPECT_LE(wronged, 0.01);
}

/// At each pose what is alike in two ways that follow each other is warped once.
void expectTruth(const Place& place, const std::vector<How>& ways) {
    std::vector<scene::TileBlock> blocks;
    for (std::size_t i = 0; i < place.sets.size(); ++i)
        blocks.push_back(lend(place.sets[i], place.images[i].camera, place.images[i].worldFromCamera));
    const GpuScene gpuScene(testDevice(), blocks);
    std::vector<std::unique_ptr<Row>> rows;
    for (const How& how : ways)
        rows.push_back(rowOf(place, how));
    Renderer renderer(testDevice(), gpuScene, kCamera.width, kCamera.height, 2);
    renderer.letFramesStand(true);
    PathTruth truth(place, kPoses);
    Quality quality;
    quality.unseenPocketMetres = 0;
    quality.holes.radius = 4; // as the presets have it
    for (int pose = 0; pose < truth.poses(); ++pose)
        for (const std::unique_ptr<Row>& row : rows) {
            if (pose % (row->how.every > 1 || tests::areLong() ? row->how.every : kSparsely) != 0) continue;
            quality.warp = row->how.warp;
            renderer.useCoverage(row->coverage.get());
            renderer.draw(truth.eyes(pose), quality);
            count(truth, pose, renderer.readBack(), row->how.reach, row->count);
        }
    for (const std::unique_ptr<Row>& row : rows)
        expectTruth(*row);
}

class UnseenTruth : public RenderTest {};

TEST_F(UnseenTruth, InARoom) {
    const Place place = scanPlace(scene::makeRoom(), 2);
    expectTruth(place, {{Warp::points, 2.5, 5}, {}, {.every = 1, .levels = kFewestLevels, .leastCellMetres = 0.02}});
}

TEST_F(UnseenTruth, AtAStreetCorner) {
    const Place place = scanPlace(scene::makeStreetCorner(), 3);
    const int finer = scene::levelsOf(place.coverage) - 2;
    ASSERT_GT(finer, kFewestLevels);
    expectTruth(place, {{Warp::points, 2.5, 5},
                        {},
                        {.every = 5, .levels = finer, .leastCellMetres = 0.018},
                        // The fewest levels that a device is brought.
                        {.every = 1, .levels = kFewestLevels, .leastCellMetres = 0.3}});
}

} // namespace
} // namespace render
