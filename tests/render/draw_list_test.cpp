#include "render/draw_list.h"
#include "render/draw_order.h"
#include "render/shaders/shared/detail.h"
#include "render/shaders/shared/splat.h"
#include "tests/render/test_scenes.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <optional>
#include <random>
#include <set>

namespace render {
namespace {

constexpr double kMargin = 3; ///< pixels

struct Many {
    SceneIndex scene;
    std::vector<ChunkPlace> places; ///< a tile to a chunk
    std::vector<SourceView> sources{1};
    VisibleTiles visible;
};

/// All visible; every third without samples, 700 to a page.
Many manyTiles(std::uint32_t count) {
    Many many;
    std::mt19937 random(2);
    const scene::Camera camera = cameraOf(2000, 2000, 1.5);
    many.sources[0].eyeImageFromSource =
        scene::eyeImageFromSourceImage({cameraOf(640, 480, 1.5), poseAt({0.1, 0, 0.2}, 0.1, 0)}, camera, {});
    for (std::uint32_t i = 0; i < count; ++i) {
        scene::Tile tile;
        tile.x0 = static_cast<int>(random() % 1900), tile.y0 = static_cast<int>(random() % 1900),
        tile.width = tile.height = 32;
        tile.minDisparity = static_cast<float>(random() % 1000) / 500, tile.maxDisparity = tile.minDisparity + 0.1f;
        many.scene.bounds.append(tile, camera);
        ResidentTile resident;
        resident.chunk = i;
        many.places.push_back({i / 700, 2 * i});
        resident.pointCount = i % 3 == 1 ? 0 : 10 + i % 7, resident.quadCount = 5;
        resident.x0 = tile.x0, resident.y0 = tile.y0;
        resident.minDisparity = tile.minDisparity, resident.maxDisparity = tile.maxDisparity;
        resident.middle = scene::middleOf(tile, camera, {});
        many.scene.tiles.push_back(resident);
        many.visible.slots.push_back(i);
    }
    for (std::uint32_t first = 0; first < count; first += 100) {
        many.scene.pieces.push_back({0, first, std::min(100u, count - first)});
        many.visible.counts.push_back(many.scene.pieces.back().count);
    }
    many.visible.pieces = numbersOf(many.scene.pieces);
    return many;
}

DrawList listOf(const Many& many, const Quality& quality, std::vector<TileDraw>& draws, double picturePixels = 0) {
    DrawList list;
    chooseDraws(many.scene, many.places, many.sources, many.visible, quality, list, picturePixels, 0);
    draws.assign(list.tiles, {});
    writeDraws(many.scene, many.places, many.sources, list, draws);
    return list;
}

TEST(DrawList, TakesRoomForWhatIsInViewAlone) {
    Many many = manyTiles(20000);
    many.visible.pieces = {3, 150}, many.visible.counts = {100, 100};
    std::vector<TileDraw> draws;
    const DrawList list = listOf(many, {}, draws);
    EXPECT_EQ(list.tiles, 200u - 66);
    EXPECT_LE(list.chosen.size(), kDrawsPerTile * 200);
}

TEST(DrawList, GoesPageByPage) {
    const Many many = manyTiles(2000);
    std::vector<TileDraw> draws;
    const DrawList list = listOf(many, {}, draws);
    EXPECT_EQ(list.tiles, 2000u - 667) << "tiles without samples are left out";
    std::uint32_t next = 0, page = 0;
    std::uint64_t items = 0;
    for (const DrawRun& run : list.runs) {
        EXPECT_EQ(run.first, next);
        EXPECT_TRUE(next == 0 || run.page > page);
        EXPECT_EQ(run.number, &run - list.runs.data());
        next += run.count, page = run.page;
        for (std::uint32_t i = run.first; i < run.first + run.count; ++i)
            items += draws[i].span.z;
    }
    EXPECT_EQ(next, list.tiles);
    EXPECT_EQ(items, list.items);
}

/// By how many tiles of scraps are drawn as what, seen by an eye of that horizontal field of view, in radians.
std::array<std::uint32_t, 2> pointsAndMesh(Many many, double fieldOfView) {
    many.sources[0].eyeImageFromSource =
        scene::eyeImageFromSourceImage({cameraOf(640, 480, fieldOfView), {}}, cameraOf(2000, 2000, 1.5), {});
    for (ResidentTile& tile : many.scene.tiles)
        tile.placeBits = scene::kScrapPlaceBits;
    std::vector<TileDraw> draws;
    std::array<std::uint32_t, 2> counts{};
    for (const DrawRun& run : listOf(many, {.warp = Warp::adaptive}, draws).runs) {
        EXPECT_TRUE(run.warp == Warp::points || run.warp == Warp::mesh);
        counts[run.warp == Warp::mesh ? 1 : 0] += run.count;
    }
    return counts;
}

TEST(DrawList, ScrapsOfTheAdaptiveMeshArePointsWhileThoseAreSmall) {
    const Many many = manyTiles(600);
    const auto fromAfar = pointsAndMesh(many, 1.5), fromNearby = pointsAndMesh(many, 0.05);
    EXPECT_EQ(fromAfar[0], 400u) << "those that have samples";
    EXPECT_EQ(fromAfar[1], 0u);
    EXPECT_EQ(fromNearby[0], 0u);
    EXPECT_GE(fromNearby[1], 400u) << "and squares";
}

TEST(DrawList, PointsAreSquaresWhereTheSurfaceSlopesByMoreThanThreePixels) {
    Many many = manyTiles(600);
    const TileBounds& bounds = many.scene.bounds;
    std::vector<double> steps; // pixels; samples themselves are half a pixel apart
    for (std::uint32_t i = 0; i < 600; ++i) {
        ResidentTile& tile = many.scene.tiles[i];
        tile.steepness = 0.001 * i, tile.pointCount = 10;
        const scene::SampleBox box{{bounds.xMin[i], bounds.yMin[i], bounds.dMin[i]},
                                   {bounds.xMax[i], bounds.yMax[i], bounds.dMax[i]}};
        steps.push_back(tile.steepness * scene::boxInEye(many.sources[0].eyeImageFromSource, box).slopeStep);
    }
    for (const int widest : {2, 4, 8}) {
        Quality quality{.warp = Warp::points};
        quality.maxFootprint = widest, quality.drawsSquaresNear = true;
        const auto steep = std::ranges::count_if(steps, [&](double step) { return step > std::min(widest, 3); });
        std::vector<TileDraw> draws;
        std::int64_t squares = 0;
        for (const DrawRun& run : listOf(many, quality, draws).runs)
            squares += run.warp == Warp::mesh ? run.count : 0;
        EXPECT_EQ(squares, steep) << widest;
        EXPECT_GT(steep, 50);
        EXPECT_LT(steep, 550);
    }
}

TEST(DrawList, WhatReachesBehindTheEyeIsSquaresHoweverFlat) {
    Many many = manyTiles(60);
    many.sources[0].eyeImageFromSource[2].z = -10; // behind it, all that is not nearer than most
    for (ResidentTile& tile : many.scene.tiles)
        tile.steepness = 0, tile.pointCount = 10;
    for (const Warp warp : {Warp::points, Warp::splats}) {
        Quality quality{.warp = warp};
        quality.drawsSquaresNear = true;
        std::vector<TileDraw> draws;
        for (const DrawRun& run : listOf(many, quality, draws).runs)
            EXPECT_EQ(run.warp, Warp::mesh);
        EXPECT_EQ(draws.size(), 60u);
    }
}

/// Scraps of any disparity from nought on to that, which an eye 0.2 m before their camera looks at.
Many scrapsUpTo(double disparity) {
    Many many = manyTiles(60);
    for (std::uint32_t i = 0; i < 60; ++i) {
        ResidentTile& tile = many.scene.tiles[i];
        tile.placeBits = scene::kScrapPlaceBits, tile.pointCount = 10;
        many.scene.bounds.dMin[i] = 0, many.scene.bounds.dMax[i] = static_cast<float>(disparity);
    }
    return many;
}

TEST(DrawList, ScrapsThatReachBehindTheEyeAreDrawnAsTheirMiddleIsSeen) {
    // At 5 they are beside the eye: middles at 3 and 4.95 are seen 0.8 and 30 pixels wide.
    for (const Warp warp : {Warp::points, Warp::splats, Warp::adaptive}) {
        Quality quality{.warp = warp};
        quality.drawsSquaresNear = true;
        std::vector<TileDraw> draws;
        const Warp small = warp == Warp::adaptive ? Warp::points : warp;
        for (const DrawRun& run : listOf(scrapsUpTo(6), quality, draws).runs)
            EXPECT_TRUE(run.warp == small && run.reach != Reach::wide);
        EXPECT_EQ(draws.size(), 60u);
        for (const DrawRun& run : listOf(scrapsUpTo(9.9), quality, draws).runs)
            EXPECT_TRUE(run.warp == Warp::mesh && run.reach == Reach::wide) << "the nearest may cover the picture";
        EXPECT_EQ(draws.size(), 60u);
    }
    std::vector<TileDraw> draws;
    for (const DrawRun& run : listOf(scrapsUpTo(6), {.warp = Warp::mesh}, draws).runs)
        EXPECT_EQ(run.reach, Reach::wide) << "whatever their middle";
    EXPECT_EQ(draws.size(), 60u);
    Many sloping = scrapsUpTo(6);
    for (ResidentTile& tile : sloping.scene.tiles)
        tile.steepness = 0.2;
    Quality quality{.warp = Warp::points};
    quality.drawsSquaresNear = true;
    for (const DrawRun& run : listOf(sloping, quality, draws).runs)
        EXPECT_EQ(run.warp, Warp::mesh) << "neighbours are many pixels apart";
    EXPECT_EQ(draws.size(), 60u);
}

TEST(DrawList, PointsOfOnePixelAreTwoWhereSlopesWouldMakeALatticeOfThem) {
    Many many = manyTiles(600);
    const scene::View eye{cameraOf(640, 480, 0.5), {glm::dmat3(1), {0.2, 0, 0}}};
    many.sources[0].eyeImageFromSource = scene::eyeImageFromSourceImage(eye, cameraOf(2000, 2000, 1.5), {});
    const glm::dmat4& c = many.sources[0].eyeImageFromSource;
    const TileBounds& bounds = many.scene.bounds;
    const auto boxOfTile = [&](std::uint32_t i) {
        return scene::SampleBox{{bounds.xMin[i], bounds.yMin[i], bounds.dMin[i]},
                                {bounds.xMax[i], bounds.yMax[i], bounds.dMax[i]}};
    };
    const double width = scene::boxInEye(c, boxOfTile(0)).sampleWidth; // the same for all: nothing is turned
    Quality quality{.warp = Warp::points};
    quality.footprintScale = 1 / width; // one pixel is what is drawn
    int steep = 0;
    for (std::uint32_t i = 0; i < 600; ++i) {
        ResidentTile& tile = many.scene.tiles[i];
        tile.steepness = 0.00019 * i, tile.pointCount = 10;
        steep += tile.steepness * scene::boxInEye(c, boxOfTile(i)).slopeStep > 1 ? 1 : 0;
    }
    ASSERT_GT(width, 1.05);
    EXPECT_GT(steep, 50);
    EXPECT_LT(steep, 550);
    for (const bool closes : {true, false}) {
        quality.drawsSquaresNear = closes;
        std::vector<TileDraw> draws;
        listOf(many, quality, draws);
        int wide = 0;
        for (const TileDraw& draw : draws)
            wide += footprintOf(draw) == 2 ? 1 : 0;
        EXPECT_EQ(wide, closes ? steep : 0);
    }
}

/// Whether the warps' shaders for plain tiles do all that this draw wants.
bool isPlainIndeed(const TileDraw& draw, Warp warp) {
    switch (warp) {
    case Warp::points:
        return footprintOf(draw) == 1;
    case Warp::splats:
        return coversTwoAtMost(splatRadiusOf(draw));
    case Warp::mesh:
        return !isByDetail(draw) && !mayReachBehind(draw);
    default:
        return !isByDetail(draw);
    }
}

/// The same of small tiles.
bool isSmallIndeed(const TileDraw& draw, Warp warp) {
    return warp == Warp::points ? footprintOf(draw) <= 2 : warp == Warp::mesh && !mayReachBehind(draw);
}

TEST(DrawList, PlainTilesHaveRunsOfTheirOwn) {
    Many many = manyTiles(2000);
    // So near the camera that some samples are pixels and some are wider, and some squares reach behind the eye.
    many.sources[0].eyeImageFromSource = scene::eyeImageFromSourceImage(
        {cameraOf(1500, 1500, 1.5), poseAt({0.1, 0, 0.6}, 0.1, 0)}, cameraOf(2000, 2000, 1.5), {});
    for (const Warp warp : {Warp::points, Warp::splats, Warp::mesh}) {
        std::vector<TileDraw> draws;
        std::uint32_t plain = 0, small = 0, others = 0, joined = 0;
        for (const DrawRun& run : listOf(many, {.warp = warp}, draws).runs)
            for (std::uint32_t i = run.first; i < run.first + run.count; ++i) {
                EXPECT_TRUE(run.reach != Reach::plain || isPlainIndeed(draws[i], warp)) << i;
                EXPECT_TRUE(run.reach != Reach::small || isSmallIndeed(draws[i], warp)) << i;
                (run.reach == Reach::plain ? plain : run.reach == Reach::small ? small : others) += 1;
                joined += run.reach != Reach::plain && isPlainIndeed(draws[i], warp);
            }
        EXPECT_GT(plain, 100u);
        EXPECT_GT(others, 100u);
        EXPECT_TRUE(warp == Warp::points ? small > 100 : small == 0) << "all is of one level";
        if (warp == Warp::mesh) continue; // its squares may be wide, too
        EXPECT_LT(joined, 100u) << "a few of each page at most";
    }
}

TEST(DrawList, IsDividedWhereThereIsMuchToDraw) {
    const Many many = manyTiles(50000);
    DrawList list;
    const auto batchesFor = [&](std::uint64_t leastItems, double picturePixels) {
        chooseDraws(many.scene, many.places, many.sources, many.visible, {}, list, picturePixels, leastItems);
        return list.runs.back().batch + 1;
    };
    batchesFor(0, 0);
    const std::uint64_t items = list.items;
    EXPECT_GT(batchesFor(items, 240 * 180), 1u);
    EXPECT_EQ(batchesFor(items + 1, 240 * 180), 1u);
    EXPECT_EQ(batchesFor(items, 1e9), 1u) << "which is hardly covered";
}

TEST(DrawList, SquaresBeforeTheEyeOfWhichSomeAreOfAnotherLevelAreSmall) {
    Many many = manyTiles(2000);
    many.sources[0].hasCoarser = true, many.sources[0].pixelsPerSample = 0.32; // as this eye sees samples
    Quality quality{.warp = Warp::points};
    quality.drawsSquaresNear = true, quality.samplePixels = 0.7;
    for (ResidentTile& tile : many.scene.tiles)
        tile.steepness = 1; // squares, whatever their size
    std::vector<TileDraw> draws;
    std::uint32_t small = 0;
    for (const DrawRun& run : listOf(many, quality, draws).runs)
        for (std::uint32_t i = run.first; run.warp == Warp::mesh && i < run.first + run.count; ++i) {
            EXPECT_EQ(run.reach == Reach::plain, !isByDetail(draws[i])) << i;
            EXPECT_TRUE(run.reach != Reach::small || isSmallIndeed(draws[i], run.warp)) << i;
            small += run.reach == Reach::small;
        }
    EXPECT_GT(small, 50u);
}

TEST(DrawList, IsTheSameOnAnyNumberOfThreads) {
    const Many many = manyTiles(50000); // enough for several parts to be put in order at the same time
    for (const double picturePixels : {0.0, 240.0 * 180}) { // as cards draw, and as processors do
        std::vector<std::vector<TileDraw>> draws(2);
        for (std::size_t run = 0; run < 2; ++run) {
            const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, run + 1);
            listOf(many, {}, draws[run], picturePixels);
        }
        ASSERT_EQ(draws[0].size(), draws[1].size());
        EXPECT_EQ(std::memcmp(draws[0].data(), draws[1].data(), draws[0].size() * sizeof(TileDraw)), 0);
    }
}

TEST(DrawList, OfManyTilesHasEachOnceAndRunsFromTopToBottom) {
    const Many many = manyTiles(50000);
    std::vector<TileDraw> draws;
    const DrawList list = listOf(many, {.maxFootprint = 2, .footprintScale = 3}, draws, 240 * 180);
    std::vector<int> drawn(50000, 0);
    std::set<std::uint32_t> bands;
    std::uint32_t batches = 0, next = 0;
    float farthestBefore = std::numeric_limits<float>::infinity(); // of the batch before
    float nearest = 0, farthest = farthestBefore;
    for (const DrawRun& run : list.runs) {
        EXPECT_EQ(run.first, next);
        next += run.count;
        if (run.number == 0 && run.first > 0) {
            EXPECT_GT(run.batch, batches);
            batches = run.batch, farthestBefore = farthest, nearest = 0;
        }
        EXPECT_EQ(run.batch, batches);
        std::pair<std::uint32_t, std::uint32_t> before;
        for (std::uint32_t i = run.first; i < next; ++i) {
            const DrawList::Chosen& chosen = list.chosen[list.order[i]];
            ++drawn[chosen.tile];
            const TileBounds& of = many.scene.bounds;
            const std::uint32_t t = chosen.tile;
            const glm::dvec4 seen = many.sources[many.scene.tiles[t].image].eyeImageFromSource *
                                    glm::dvec4(0.5 * (of.xMin[t] + of.xMax[t]), 0.5 * (of.yMin[t] + of.yMax[t]), 1,
                                               0.5 * (static_cast<double>(of.dMin[t]) + of.dMax[t]));
            if (seen.z > 0) {
                EXPECT_EQ(chosen.band, bandOf(seen.y / seen.z)) << t;
            }
            bands.insert(chosen.band);
            const std::pair place(chosen.band, chosen.tile);
            EXPECT_TRUE(i == run.first || place > before);
            before = place;
            EXPECT_EQ(many.places[chosen.tile].page, run.page);
            EXPECT_EQ(draws[i].detail.w, static_cast<float>(run.number));
            nearest = std::max(nearest, chosen.orderDisparity);
            farthest = std::min(farthest, chosen.orderDisparity);
        }
        EXPECT_LE(nearest, farthestBefore * 1.125f) << "bins are an eighth of an octave";
    }
    EXPECT_EQ(next, list.tiles);
    EXPECT_EQ(batches, 2u);
    EXPECT_GT(bands.size(), 5u) << "tiles stand high and low";
    for (std::size_t i = 0; i < drawn.size(); ++i)
        EXPECT_EQ(drawn[i], many.scene.tiles[i].pointCount > 0 ? 1 : 0) << i;
}

/// What is chosen of all pieces, or of those that the eye and the knobs want: tile, warp and order level of each draw.
std::vector<std::array<std::uint32_t, 3>> chosenFrom(const SceneIndex& index, std::span<const ChunkPlace> places,
                                                     const scene::View& eye, const Quality& quality, bool isOfAll) {
    SourceViews sources;
    VisibleTiles visible;
    findSourceViews(index, eye, quality, kMargin, {}, {}, sources);
    if (isOfAll) sources.of = sourceViewsOf(index.images, eye, quality);
    if (isOfAll)
        visible.pieces = numbersOf(index.pieces);
    else
        index.findPiecesOf(sources.seen, visible.pieces);
    const auto planesFor = [&](const TilePiece& piece) -> std::optional<ImagePlanes> {
        const SourceView& source = sources.of[piece.image];
        if (!isOfAll && !mayBeChosen(piece, source, quality, hasGaps(places))) return std::nullopt;
        return planesOf(source.eyeImageFromSource, eye.camera.width, eye.camera.height, kMargin,
                        index.images[piece.image].extent);
    };
    cull(index.bounds, index.pieces, planesFor, visible);
    DrawList list;
    chooseDraws(index, places, sources.of, visible, quality, list);
    std::vector<std::array<std::uint32_t, 3>> found;
    for (const std::uint32_t place : list.order) {
        const DrawList::Chosen& chosen = list.chosen[place];
        found.push_back({chosen.tile, static_cast<std::uint32_t>(chosen.warp), chosen.orderLevel});
    }
    std::sort(found.begin(), found.end());
    return found;
}

TEST(DrawList, PiecesThatArePassedOverHoldNothingThatIsDrawn) {
    CutScene room = roomInAllTiers();
    room = cutInLevels(std::move(room.images));
    const std::vector<scene::TileBlock> blocks = room.blocks();
    SceneIndex index(blocks, 16 << 10);
    index.findFiner();
    std::vector<ChunkPlace> places;
    for (std::uint32_t i = 0; i < index.chunks.size(); ++i)
        places.push_back({i % 3, 2 * i});
    std::mt19937 random(8);
    std::size_t drawn = 0, standIns = 0;
    for (int i = 0; i < 60; ++i) {
        const scene::View eye{cameraOf(320, 240, 0.6 + 0.02 * i),
                              poseAt({0.05 * (i % 7) - 0.1, 0.02 * (i % 5), 0.1 * (i % 11) - 0.5}, 0.5 * i, 0.1)};
        Quality quality;
        quality.warp = i % 2 == 0 ? Warp::points : Warp::adaptive;
        quality.samplePixels = 0.75 * (i % 4);
        quality.farSamplePixels = i % 3 == 0 ? 4 : 0;
        quality.preference.nearBaseline = i % 5 == 0 ? 0 : 0.1f;
        const auto all = chosenFrom(index, places, eye, quality, true);
        EXPECT_EQ(chosenFrom(index, places, eye, quality, false), all) << i;
        drawn += all.size();
        std::vector<ChunkPlace> some = places;
        for (std::size_t k = 0; k < some.size(); ++k)
            if (index.chunks[k].chunk.level < 2 && random() % 2 == 0) some[k] = {};
        const auto ofSome = chosenFrom(index, some, eye, quality, true);
        EXPECT_EQ(chosenFrom(index, some, eye, quality, false), ofSome) << i;
        if (quality.samplePixels > 0) continue;
        for (const auto& [tile, warp, level] : ofSome)
            standIns += index.images[index.tiles[tile].image].level > 0 ? 1 : 0;
    }
    EXPECT_GT(drawn, 1000u);
    EXPECT_GT(standIns, 100u);
}

// A coarse sample of a measured and three closed ones is measured: it stands for all four.
TEST(DrawList, BaseTilesStandInForClosedOnesThatAreMissing) {
    std::vector<scene::DepthImage> images{takeRoom(cameraOf(200, 150, 1.4), poseAt({}, 0, 0))};
    std::mt19937 random(9);
    for (std::uint8_t& flags : images[0].flags.pixels())
        if (random() % 4 != 0) flags |= scene::kInterpolated;
    const CutScene room = cutInLevels(std::move(images));
    const std::vector<scene::TileBlock> blocks = room.blocks();
    SceneIndex index(blocks, 16 << 10);
    index.findFiner();
    int coarse = 0;
    for (std::uint32_t i = 0; i < index.tiles.size(); ++i) {
        const ResidentTile& tile = index.tiles[i];
        if (index.images[tile.image].level != 1 || tile.middle.tier != scene::Tier::base) continue;
        ++coarse;
        const auto finer = index.finerThan(i);
        for (const scene::Tier tier : {scene::Tier::base, scene::Tier::closed})
            EXPECT_TRUE(std::any_of(finer.begin(), finer.end(), [&](std::uint32_t chunk) {
                return index.chunks[chunk].chunk.tier == tier;
            })) << i;
    }
    EXPECT_GT(coarse, 5);
}

TEST(DrawList, FootprintsStayWithinTheirLimit) {
    const Many many = manyTiles(1000);
    for (const int limit : {1, 3}) {
        Quality quality;
        quality.maxFootprint = limit;
        quality.footprintScale = 12; // the image has three times the pixels of the eye
        std::vector<TileDraw> draws;
        const DrawList list = listOf(many, quality, draws);
        std::uint32_t largest = 0;
        for (std::uint32_t i = 0; i < list.tiles; ++i) {
            EXPECT_GE(footprintOf(draws[i]), 1);
            largest = std::max(largest, static_cast<std::uint32_t>(footprintOf(draws[i])));
        }
        EXPECT_EQ(largest, static_cast<std::uint32_t>(limit));
    }
}

TEST(DrawList, CountsFromWhereAChunkLiesAndLeavesOutWhatIsNotThere) {
    Many many = manyTiles(300);
    std::vector<TileDraw> draws;
    const std::uint32_t all = listOf(many, {}, draws).tiles;
    EXPECT_EQ(draws[1].span.y, 4u) << "the third tile, the second having no samples";
    many.places[0] = many.places[2] = many.places[1] = {};
    EXPECT_EQ(listOf(many, {}, draws).tiles, all - 2);
    EXPECT_EQ(draws[0].span.y, 6u);
}

TEST(DrawList, OfNothingIsEmpty) {
    DrawList list;
    chooseDraws({}, {}, {}, {}, {}, list);
    EXPECT_EQ(list.tiles, 0u);
    EXPECT_TRUE(list.runs.empty());
}

} // namespace
} // namespace render
