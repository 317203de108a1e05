#include "render/draw_list.h"

#include "render/pipeline.h"
#include "render/shaders/shared/detail.h"
#include "render/shaders/shared/splat.h"
#include "render/shaders/shared/z_key.h"
#include "scene/footprint.h"

#include <glm/geometric.hpp>
#include <tbb/blocked_range.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace render {

namespace {

constexpr std::size_t kDrawsPerTask = 512;

static_assert(kRowPlaceBits == scene::kPlaceBits);

constexpr double kRounding = 1 + 1e-4; ///< what single precision may make of a measure

constexpr double kAnywhere = std::numeric_limits<double>::infinity();

/// What draws a tile: for the adaptive mesh its squares where it has no facets; scraps are points while those are
/// small.
Warp warpOf(const ResidentTile& tile, Warp wanted) {
    if (wanted != Warp::adaptive || tile.facetCount > 0) return wanted;
    return tile.placeBits == scene::kScrapPlaceBits ? Warp::points : Warp::mesh;
}

bool hasGaps(std::span<const ChunkPlace> places) {
    return std::any_of(places.begin(), places.end(), [](const ChunkPlace& place) { return !place.isThere(); });
}

std::uint32_t itemsOf(const ResidentTile& tile, Warp warp) {
    switch (warp) {
    case Warp::mesh:
        return tile.quadCount;
    case Warp::adaptive:
        return tile.facetCount;
    default:
        return tile.pointCount;
    }
}

uint classOf(const ResidentTile& tile, const ChunkPlace& place) {
    if (place.isDamaged) return kClassUnseen;
    return tile.middle.tier == scene::Tier::guess ? kClassFilled : kClassSeen;
}

scene::SampleBox boxOf(const TileBounds& bounds, std::uint32_t i) {
    return {{bounds.xMin[i], bounds.yMin[i], bounds.dMin[i]}, {bounds.xMax[i], bounds.yMax[i], bounds.dMax[i]}};
}

/// Stand-ins are drawn as wide as it takes: what is coarse must not open holes.
std::uint32_t footprintOf(const glm::dmat4& c, const scene::SampleBox& box, const Quality& quality, bool isStandIn) {
    constexpr double kStandInScale = 1.5; // closes what slopes open
    const double scale = isStandIn ? std::max(quality.footprintScale, kStandInScale) : quality.footprintScale;
    const int most = isStandIn ? std::max(quality.maxFootprint, kWidestStandIn) : quality.maxFootprint;
    return static_cast<std::uint32_t>(scene::footprintOf(c, box, scale, most));
}

/// Pixels.
constexpr std::uint32_t kSmallStandIn = 4;

/// Pixels. As squares of up to so many, scraps look much as their mesh would, and are drawn in less time; wider squares
/// stand out of their surface's rim, and show one colour where the mesh has a transition.
constexpr std::uint32_t kWidestScrapPoint = 2;

/// Order levels that stand-ins are pushed back by: where some of the finer samples are there, those are seen.
constexpr int kStandInLevels = 2;

/// detail of a TileDraw (shared/detail.h); nothing if no sample of the tile can be drawn. isFinest: of all that are
/// there.
std::optional<vec4> detailOf(const SourceView& source, const scene::SampleBox& box, double samplePixels,
                             bool isFinest) {
    const glm::dmat4& c = source.eyeImageFromSource;
    // w is affine in (x, y, d): its extremes stand in corners of the box.
    const auto along = [](double slope, double low, double high) -> std::pair<double, double> {
        const double a = slope * low, b = slope * high;
        return {std::min(a, b), std::max(a, b)};
    };
    const auto x = along(c[0].z, box.least.x, box.most.x), y = along(c[1].z, box.least.y, box.most.y),
               d = along(c[3].z, box.least.z, box.most.z);
    const double perW = samplePixels / source.pixelsPerSample;
    const double least = perW * (x.first + y.first + c[2].z + d.first),
                 most = perW * (x.second + y.second + c[2].z + d.second);
    const double overlap = static_cast<double>(kDetailOverlap), whole = 1 + static_cast<double>(kDetailBand);
    if (!isFinest && most * (1 + overlap) * kRounding <= 1) return std::nullopt;
    if (source.hasCoarser && least * (0.5 - 0.5 * overlap) >= whole * kRounding) return std::nullopt;
    const bool isWanted = isFinest || least * (1 + overlap) >= whole * kRounding;
    const bool isReplaced = source.hasCoarser && most * (0.5 - 0.5 * overlap) * kRounding > 1;
    if (isWanted && !isReplaced) return vec4(0);
    return vec4(static_cast<float>(perW), isFinest ? 0.0f : 1.0f, source.hasCoarser ? 1.0f : 0.0f, 0.0f);
}

/// The planes through the eye and the edges of its picture, and the one behind which nothing is seen: unit normals that
/// point inward, in the world.
struct ViewWedge {
    glm::dvec3 eyeInWorld{0};
    std::array<glm::dvec3, 5> inward;
};

ViewWedge wedgeOf(const scene::View& eye, double marginPixels) {
    const scene::Camera& c = eye.camera;
    const double left = (-marginPixels - c.cx) / c.fx, right = (c.width + marginPixels - c.cx) / c.fx,
                 top = (-marginPixels - c.cy) / c.fy, bottom = (c.height + marginPixels - c.cy) / c.fy;
    ViewWedge wedge{eye.worldFromEye.translation,
                    {glm::dvec3(1, 0, -left), {-1, 0, right}, {0, 1, -top}, {0, -1, bottom}, {0, 0, 1}}};
    for (glm::dvec3& normal : wedge.inward)
        normal = eye.worldFromEye.rotation * glm::normalize(normal);
    return wedge;
}

bool isOutside(const ViewWedge& wedge, const ImageSphere& sphere) {
    const double radius = sphere.radius * (1 + 1e-9);
    return std::any_of(wedge.inward.begin(), wedge.inward.end(), [&](const glm::dvec3& normal) {
        return glm::dot(normal, sphere.centre - wedge.eyeInWorld) < -radius;
    });
}

constexpr std::uint32_t kBatches = 8, kWarps = 4;
constexpr std::uint32_t kBucketsOfBatch = 2 * kWarps * 2; ///< near or far, warp, plain or not
constexpr std::uint32_t kBuckets = kBatches * kBucketsOfBatch;

/// Samples are put into a batch until they could cover the picture so many times. Those of one batch may hide each
/// other in vain; each further batch costs a look at the z-buffer, of which the first is dear.
constexpr std::array<double, kBatches - 1> kBatchCovers{1, 1.25, 1.5, 2, 2.5, 3.5, 5};

/// Fewer plain tiles go with the others: a dispatch more costs more than they save.
constexpr std::uint32_t kLeastPlain = 32;

/// With less than this to draw, looking costs more than it saves.
constexpr double kLeastCover = 3;

void placeInView(const SourceView& source, const ResidentTile& tile, const scene::SampleBox& box,
                 DrawList::Chosen& chosen) {
    const glm::dmat4& c = source.eyeImageFromSource;
    const glm::dvec3 middle = 0.5 * (box.least + box.most);
    const double w = c[0].z * middle.x + c[1].z * middle.y + c[2].z + c[3].z * middle.z;
    constexpr double kWidest = 4; // pixels: a sample nearby covers many, but not as many as one would think
    const double width = w > 0 ? std::min(source.pixelsPerSample / w, kWidest) : kWidest;
    chosen.area = static_cast<float>(tile.pointCount * width * width);
    const double scale = static_cast<double>(scene::orderScale(static_cast<int>(chosen.orderLevel)));
    chosen.orderDisparity = w > 0 ? static_cast<float>(middle.z / (w * scale)) : std::numeric_limits<float>::infinity();
}

/// Whether no sample of a box can be anywhere but before the eye (isBeforeEye in shared/tile_draw.h), whatever single
/// precision makes of it.
bool isAllBefore(const glm::dmat4& c, const scene::SampleBox& box) {
    constexpr double kMost = static_cast<double>(kMaxEyeDisparity), kMargin = 1e-4;
    double least = 0, magnitude = 0; // of kMost * w - d: affine, so that it is least in a corner
    const auto add = [&](int column, double low, double high) {
        const double slope = kMost * c[column].z - c[column].w;
        least += std::min(slope * low, slope * high);
        magnitude += std::max(std::abs(slope * low), std::abs(slope * high));
    };
    add(0, box.least.x, box.most.x), add(1, box.least.y, box.most.y), add(2, 1, 1), add(3, box.least.z, box.most.z);
    return least > kMargin * magnitude;
}

/// Pixels. Squares of tiles whose samples are wider may be shared among a subgroup's lanes (warp_mesh.comp).
constexpr int kWidestPlainSquare = 8;

/// How far a sample reaches in the eye, and whether the tile is plain: points of one pixel; splats of two at most; a
/// mesh before the eye, of small squares; and of meshes and facets, which ask it square by square or pixel by pixel,
/// all is of this level.
void findReach(const SourceView& source, const scene::SampleBox& box, const Quality& quality,
               DrawList::Chosen& chosen) {
    const glm::dmat4& c = source.eyeImageFromSource;
    const bool isWhole = chosen.detail.x == 0.0f && source.share == 1;
    switch (chosen.warp) {
    case Warp::points:
        chosen.reach = footprintOf(c, box, quality, chosen.isStandIn);
        chosen.isPlain = chosen.reach == 1;
        break;
    case Warp::splats: {
        const float radius = scene::splatRadiusOf(c, box, quality.splatScale, quality.maxSplat);
        chosen.reach = glm::floatBitsToUint(radius);
        chosen.isPlain = coversTwoAtMost(radius);
        break;
    }
    case Warp::mesh:
        chosen.isPlain = isWhole && isAllBefore(c, box) &&
                         scene::footprintOf(c, box, 1, kWidestPlainSquare + 1) <= kWidestPlainSquare;
        break;
    case Warp::adaptive:
        chosen.isPlain = isWhole;
        break;
    }
}

/// For all that was chosen, piece by piece.
template <class Visit>
void forChosen(DrawList& list, std::span<const TilePiece> pieces, Visit&& visit) {
    for (std::size_t p = 0; p < pieces.size(); ++p)
        for (std::uint32_t i = 0; i < list.counts[p]; ++i) {
            const std::size_t place = kDrawsPerTile * std::size_t{pieces[p].first} + i;
            visit(list.chosen[place], place);
        }
}

/// Positive floats order as their bits do; a bin is an eighth of an octave.
constexpr std::uint32_t kBinShift = 20, kBins = 1u << (31 - kBinShift);
std::uint32_t binOf(float orderDisparity) {
    return std::bit_cast<std::uint32_t>(std::max(orderDisparity, 0.0f)) >> kBinShift;
}

/// The bins that the batches go down to, descending; all of zero if everything goes into the first.
std::array<std::uint32_t, kBatches - 1> divide(DrawList& list, std::span<const TilePiece> pieces,
                                               double picturePixels) {
    std::array<std::uint32_t, kBatches - 1> ends{};
    if (picturePixels <= 0) return ends;
    std::vector<double> areas(kBins, 0.0);
    double all = 0;
    forChosen(list, pieces, [&](const DrawList::Chosen& chosen, std::size_t) {
        areas[binOf(chosen.orderDisparity)] += static_cast<double>(chosen.area);
        all += static_cast<double>(chosen.area);
    });
    if (all < kLeastCover * picturePixels) return ends;
    double sum = 0;
    std::size_t batch = 0;
    for (std::uint32_t bin = kBins; bin > 0 && batch < ends.size(); --bin) {
        sum += areas[bin - 1];
        while (batch < ends.size() && sum >= kBatchCovers[batch] * picturePixels)
            ends[batch++] = bin - 1;
    }
    return ends;
}

std::uint32_t bucketOf(const DrawList::Chosen& chosen, const std::array<std::uint32_t, kBatches - 1>& batchEnds) {
    constexpr std::array<std::uint32_t, kWarps> kRank{2, 1, 0, 3}; // of points, mesh, adaptive, splats
    const std::uint32_t bin = binOf(chosen.orderDisparity);
    std::uint32_t batch = 0;
    while (batch < batchEnds.size() && bin < batchEnds[batch])
        ++batch;
    // Points stand among the others: so they were measured before they looked at what is there already.
    const bool isFar = chosen.orderLevel == scene::kMaxOrderLevel && chosen.warp != Warp::points;
    const std::uint32_t ofWarp = (isFar ? kWarps : 0) + kRank[static_cast<std::size_t>(chosen.warp)];
    return batch * kBucketsOfBatch + 2 * ofWarp + (chosen.isPlain ? 0 : 1);
}

/// Whether all of a coarse tile is of the level that is asked for, or of a coarser one: then it stands for nothing.
bool isWhollyWanted(const SourceView& source, const scene::SampleBox& box, double samplePixels) {
    const std::optional<vec4> detail = detailOf(source, box, samplePixels, false);
    return detail && detail->x == 0.0f;
}

/// A coarser level, which comes after the captured images, stands where its own does, and its camera is halved again
/// and again: powers of two, so that this is what its own camera would give, to the bit.
void takeFrom(const SourceView& captured, SourceView& level) {
    const double wider = std::exp2(level.level);
    level.eyeImageFromSource = captured.eyeImageFromSource;
    level.eyeImageFromSource[0] *= wider, level.eyeImageFromSource[1] *= wider;
    level.eyeFromCamera = captured.eyeFromCamera;
    level.pixelsPerSample = captured.pixelsPerSample * wider;
    level.isNear = captured.isNear;
}

} // namespace

TileDraw tileDrawOf(const glm::dmat4& c, const ResidentTile& tile, int orderLevel) {
    const double perScale = 1.0 / static_cast<double>(scene::orderScale(orderLevel));
    const auto hOf = [&](const glm::dvec4& sample) {
        const glm::dvec4 h = c * sample;
        return glm::dvec4(h.x, h.y, h.z, h.w * perScale);
    };
    const double step =
        (static_cast<double>(tile.maxDisparity) - tile.minDisparity) / scene::maxQuantisedOf(tile.placeBits);
    TileDraw draw;
    draw.base = glm::vec4(hOf({tile.x0 + 0.5, tile.y0 + 0.5, 1.0, tile.minDisparity}));
    draw.perX = glm::vec4(hOf({1, 0, 0, 0}));
    draw.perY = glm::vec4(hOf({0, 1, 0, 0}));
    draw.perQ = glm::vec4(hOf({0, 0, 0, step}));
    draw.span = {tile.firstVertex, 0, 0, packMark(static_cast<uint>(orderLevel), classOf(tile, {}), tile.placeBits, 1)};
    draw.source = {static_cast<uint>(tile.x0), static_cast<uint>(tile.y0), (tile.width + 1) << 8 | tile.height << 20,
                   0};
    draw.detail = vec4(0);
    return draw;
}

void findSourceViews(std::span<const ResidentImage> images, const scene::View& eye, const Quality& quality,
                     std::span<const ImageSphere> spheres, double marginPixels, std::span<const float> shares,
                     std::vector<SourceView>& views) {
    std::vector<std::uint8_t> isOut(spheres.size(), 0);
    const ViewWedge wedge = wedgeOf(eye, marginPixels);
    for (std::size_t i = 0; i < spheres.size(); ++i)
        isOut[i] = isOutside(wedge, spheres[i]) ? 1 : 0;
    views.resize(images.size());
    for (std::size_t i = 0; i < images.size(); ++i) {
        const ResidentImage& image = images[i];
        SourceView& view = views[i] = {};
        view.captured = image.captured, view.level = image.level, view.hasCoarser = image.hasCoarser;
        if (!shares.empty()) view.share = shares[image.captured];
        view.isOut = view.share <= 0 || (!spheres.empty() && isOut[image.captured] != 0);
        if (view.isOut) continue;
        if (image.level > 0) {
            takeFrom(views[image.captured], view);
            continue;
        }
        view.eyeImageFromSource = scene::eyeImageFromSourceImage(eye, image.camera, image.worldFromCamera);
        view.eyeFromCamera = eye.worldFromEye.translation - image.worldFromCamera.translation;
        view.pixelsPerSample = std::sqrt(eye.camera.fx * eye.camera.fy / (image.camera.fx * image.camera.fy));
        view.isNear = glm::length(view.eyeFromCamera) <=
                      2 * static_cast<double>(quality.preference.nearBaseline) * image.middleReach;
    }
}

void chooseDraws(const SceneIndex& scene, std::span<const ChunkPlace> places, std::span<const SourceView> sources,
                 const VisibleTiles& visible, const Quality& quality, DrawList& list, double picturePixels) {
    const bool isDetailed = detailPixelsOf(quality) > 0;
    const bool mayStandIn = hasGaps(places);
    const auto standsIn = [&](std::uint32_t number) {
        const auto finer = scene.finerThan(number);
        return std::any_of(finer.begin(), finer.end(), [&](std::uint32_t chunk) { return !places[chunk].isThere(); });
    };
    const auto samplePixelsOf = [&](const SourceView& source, const ResidentTile& tile) {
        const bool isFar = tile.middle.tier == scene::Tier::base && !source.isNear;
        return isFar ? std::max(quality.samplePixels, quality.farSamplePixels) : quality.samplePixels;
    };
    /// How a visible tile is drawn, if it is.
    const auto choose = [&](std::uint32_t number) -> std::optional<DrawList::Chosen> {
        const ResidentTile& tile = scene.tiles[number];
        const SourceView& source = sources[tile.image];
        if (!places[tile.chunk].isThere()) return std::nullopt;
        const bool isStandIn =
            mayStandIn && source.level > 0 && standsIn(number) &&
            !(isDetailed && isWhollyWanted(source, boxOf(scene.bounds, number), samplePixelsOf(source, tile)));
        if (source.level > 0 && !isDetailed && !isStandIn) return std::nullopt;
        // Where its samples are seen small, squares alone leave no gaps that would be seen.
        const bool isSmall = isStandIn && footprintOf(source.eyeImageFromSource, boxOf(scene.bounds, number), quality,
                                                      true) <= kSmallStandIn;
        const auto warpOfTile = [&] {
            if (isSmall) return Warp::points;
            if (isStandIn) return warpOf(tile, Warp::adaptive);
            const Warp warp = warpOf(tile, quality.warp);
            const bool isWideScrap =
                quality.warp == Warp::adaptive && warp == Warp::points &&
                footprintOf(source.eyeImageFromSource, boxOf(scene.bounds, number), quality, false) > kWidestScrapPoint;
            return isWideScrap ? Warp::mesh : warp;
        };
        const Warp warp = warpOfTile();
        if (itemsOf(tile, warp) == 0) return std::nullopt;
        std::optional<vec4> detail = vec4(0);
        if (isDetailed)
            detail = detailOf(source, boxOf(scene.bounds, number), samplePixelsOf(source, tile),
                              source.level == 0 || isStandIn);
        if (!detail) return std::nullopt;
        const auto level = scene::orderLevelOf(tile.middle, source.eyeFromCamera, quality.preference);
        if (!level) return std::nullopt;
        const bool isByArea = quality.preference.areaLevels > 0;
        const double area =
            isByArea ? scene::sampleAreaInEye(source.eyeImageFromSource, boxOf(scene.bounds, number)) : 0;
        const int behind = isStandIn ? kStandInLevels : 0;
        const int orderLevel =
            std::min(scene::withArea(*level, area, quality.preference) + behind, scene::kMaxOrderLevel);
        DrawList::Chosen chosen{.tile = number,
                                .orderLevel = static_cast<std::uint32_t>(orderLevel),
                                .isStandIn = isStandIn,
                                .warp = warp,
                                .detail = *detail};
        if (picturePixels > 0) placeInView(source, tile, boxOf(scene.bounds, number), chosen);
        findReach(source, boxOf(scene.bounds, number), quality, chosen);
        return chosen;
    };

    // Every piece chooses in its own part of the scratch arrays; then the parts are put together in order.
    const std::vector<TilePiece>& pieces = scene.pieces;
    list.chosen.resize(kDrawsPerTile * scene.tiles.size());
    list.counts.assign(pieces.size(), 0);
    tbb::parallel_for(std::size_t{0}, pieces.size(), [&](std::size_t p) {
        if (visible.counts[p] == 0) return;
        const TilePiece& piece = pieces[p];
        const SourceView& source = sources[piece.image];
        if (!isDetailed && !mayStandIn && source.level > 0) return;
        if (piece.reachMetres < kAnywhere &&
            !scene::mayBeNear(glm::length(source.eyeFromCamera), piece.reachMetres, quality.preference))
            return;
        // All of a piece may be too fine, or too coarse. A piece's tiles are alike in what samplePixelsOf asks.
        if (isDetailed && !detailOf(source, piece.box, samplePixelsOf(source, scene.tiles[piece.first]),
                                    source.level == 0 || mayStandIn))
            return;
        const auto add = [&](const DrawList::Chosen& chosen) {
            list.chosen[kDrawsPerTile * piece.first + list.counts[p]++] = chosen;
        };
        for (std::uint32_t i = 0; i < visible.counts[p]; ++i) {
            std::optional<DrawList::Chosen> chosen = choose(visible.slots[piece.first + i]);
            if (!chosen) continue;
            add(*chosen);
            if (!chosen->isStandIn || chosen->warp == Warp::points) continue;
            chosen->warp = Warp::points;
            findReach(source, boxOf(scene.bounds, chosen->tile), quality, *chosen);
            add(*chosen);
        }
    });

    // What is likely seen comes first, so that the rest finds itself hidden early.
    const std::array<std::uint32_t, kBatches - 1> batchEnds = divide(list, pieces, picturePixels);
    std::uint32_t pages = 1;
    for (const ChunkPlace& place : places)
        if (place.isThere()) pages = std::max(pages, place.page + 1);
    std::vector<std::uint32_t>& firsts = list.firsts;
    const auto countBuckets = [&] {
        firsts.assign(std::size_t{kBuckets} * pages + 1, 0);
        forChosen(list, pieces, [&](DrawList::Chosen& chosen, std::size_t) {
            chosen.bucket = bucketOf(chosen, batchEnds) * pages + places[scene.tiles[chosen.tile].chunk].page;
            ++firsts[chosen.bucket + 1];
        });
    };
    countBuckets();
    forChosen(list, pieces, [&](DrawList::Chosen& chosen, std::size_t) {
        const std::size_t count = chosen.bucket + 1; // of its own, and of those that are not plain beside it
        const bool mayJoin = chosen.isPlain && chosen.warp != Warp::splats; // plain splats leave out corners
        if (mayJoin && firsts[count] < kLeastPlain && firsts[count + pages] > 0) chosen.isPlain = false;
    });
    countBuckets();
    for (std::size_t i = 1; i < firsts.size(); ++i)
        firsts[i] += firsts[i - 1];
    list.tiles = firsts.back();
    list.order.resize(list.tiles);
    forChosen(list, pieces, [&](const DrawList::Chosen& chosen, std::size_t place) {
        list.order[firsts[chosen.bucket]++] = static_cast<std::uint32_t>(place);
    });
    list.runs.clear();
    list.items = 0;
    std::uint32_t run = 0; // of its batch
    for (std::uint32_t i = 0; i < list.tiles; ++i) {
        DrawList::Chosen& chosen = list.chosen[list.order[i]];
        const ResidentTile& tile = scene.tiles[chosen.tile];
        const DrawRun next{places[tile.chunk].page, i, 0, chosen.warp, chosen.bucket / (kBucketsOfBatch * pages),
                           chosen.isPlain};
        if (list.runs.empty() || !areOfOneRun(list.runs.back(), next) || list.runs.back().count == kMaxWorkgroups) {
            run = list.runs.empty() || list.runs.back().batch != next.batch ? 0 : run + 1;
            list.runs.push_back(next);
        }
        chosen.batch = next.batch, chosen.run = run;
        ++list.runs.back().count;
        list.items += itemsOf(tile, chosen.warp);
    }
}

void writeDraws(const SceneIndex& scene, std::span<const ChunkPlace> places, std::span<const SourceView> sources,
                const DrawList& list, std::span<TileDraw> draws) {
    assert(draws.size() >= list.tiles);
    const tbb::blocked_range<std::size_t> all(0, list.tiles, kDrawsPerTask);
    tbb::parallel_for(all, [&](const tbb::blocked_range<std::size_t>& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const DrawList::Chosen& chosen = list.chosen[list.order[i]];
            const ResidentTile& tile = scene.tiles[chosen.tile];
            const ChunkPlace& place = places[tile.chunk];
            const SourceView& source = sources[tile.image];
            TileDraw draw = tileDrawOf(source.eyeImageFromSource, tile, static_cast<int>(chosen.orderLevel));
            draw.span.x += place.firstTexel;
            draw.span.z = itemsOf(tile, chosen.warp);
            std::uint32_t footprint = 1;
            if (chosen.warp == Warp::points) {
                draw.span.y = place.firstTexel + tile.firstVertex;
                footprint = chosen.reach;
            } else if (chosen.warp == Warp::splats) {
                draw.span.y = place.firstTexel + tile.firstVertex;
                draw.span.x = chosen.reach;
            } else if (chosen.warp == Warp::mesh) {
                draw.span.y = place.firstTexel + tile.firstQuad;
            } else {
                draw.span.x = place.firstTexel + tile.firstTexel, draw.span.y = place.firstTexel / 2 + tile.firstFacet;
            }
            draw.span.w = packMark(chosen.orderLevel, classOf(tile, place), tile.placeBits, footprint);
            draw.source.z |= source.level;
            draw.source.w = packSource(source.captured, source.share);
            draw.detail = vec4(chosen.detail.x, chosen.detail.y, chosen.detail.z, static_cast<float>(chosen.run));
            draws[i] = draw;
        }
    });
}

} // namespace render
