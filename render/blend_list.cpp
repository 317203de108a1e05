#include "render/blend_list.h"

#include <glm/geometric.hpp>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cmath>

namespace render {

namespace {

constexpr std::size_t kBlendedPerTask = 512;

scene::SampleBox samplesOf(const TileBounds& bounds, std::uint32_t i) {
    return {{bounds.xMin[i], bounds.yMin[i], bounds.dMin[i]}, {bounds.xMax[i], bounds.yMax[i], bounds.dMax[i]}};
}

bool isWhole(const ChunkPlace& place) {
    return place.isThere() && !place.isDamaged;
}

} // namespace

bool mayBeBlended(const TilePiece& piece, const glm::dvec3& eyeFromCamera, const scene::BlendOptions& options) {
    return piece.isBase ||
           scene::mayBeNear(glm::length(eyeFromCamera), piece.reachMetres, {.nearBaseline = options.baseline});
}

void chooseBlendDraws(const SceneIndex& scene, std::span<const ChunkPlace> places, std::span<const SourceView> sources,
                      const VisibleTiles& visible, const scene::BlendOptions& options, bool hasPolygons,
                      BlendList& list) {
    const std::vector<ResidentTile>& tiles = scene.tiles;
    const std::vector<TilePiece>& pieces = scene.pieces;
    const float unit = scene::blendUnitOf(sources.size());
    // Every piece chooses in its own part of the scratch arrays; then the parts are put together in order.
    list.counts.assign(visible.pieces.size(), 0);
    list.firstOfPiece.resize(visible.pieces.size());
    std::uint32_t room = 0;
    for (std::size_t p = 0; p < visible.pieces.size(); ++p) {
        list.firstOfPiece[p] = room;
        room += visible.counts[p];
    }
    list.numbers.resize(room);
    list.spots.resize(room);
    tbb::parallel_for(std::size_t{0}, visible.pieces.size(), [&](std::size_t p) {
        const TilePiece& piece = pieces[visible.pieces[p]];
        if (piece.image >= sources.size()) return; // a coarser level
        const glm::dvec3& eyeFromCamera = sources[piece.image].eyeFromCamera;
        if (!mayBeBlended(piece, eyeFromCamera, options)) return;
        for (std::uint32_t i = 0; i < visible.counts[p]; ++i) {
            const std::uint32_t number = visible.slots[piece.first + i];
            const ResidentTile& tile = tiles[number];
            if (tile.pointCount == 0 || !isWhole(places[tile.chunk])) continue;
            if (hasPolygons && !scene::isMeasured(tile.middle.tier)) continue;
            const auto spot = scene::blendSpotOf(sources[tile.image].eyeImageFromSource,
                                                 samplesOf(scene.bounds, number), tile.middle, eyeFromCamera, options);
            if (!spot) continue;
            const float weight = sources[tile.image].share * spot->weight;
            if (unit * weight < 0.5f) continue; // would count nothing anywhere
            const std::uint32_t place = list.firstOfPiece[p] + list.counts[p]++;
            list.numbers[place] = number;
            list.spots[place] = *spot;
            list.spots[place].weight = weight;
        }
    });

    list.runs.clear();
    list.items = 0;
    list.tiles = 0;
    for (std::size_t p = 0; p < visible.pieces.size(); ++p)
        for (std::uint32_t i = 0; i < list.counts[p]; ++i) {
            const std::uint32_t place = list.firstOfPiece[p] + i, number = list.numbers[place];
            const ResidentTile& tile = tiles[number];
            const std::uint32_t page = places[tile.chunk].page;
            if (list.runs.empty() || list.runs.back().page != page) list.runs.push_back({page, list.tiles, 0});
            ++list.runs.back().count;
            list.items += tile.pointCount;
            list.numbers[list.tiles] = number;
            list.spots[list.tiles] = list.spots[place];
            ++list.tiles;
        }
}

void writeBlendDraws(const SceneIndex& scene, std::span<const ChunkPlace> places, std::span<const SourceView> sources,
                     const BlendList& list, std::span<BlendDraw> draws) {
    const std::vector<ResidentTile>& tiles = scene.tiles;
    const float unit = scene::blendUnitOf(sources.size());
    const tbb::blocked_range<std::size_t> all(0, list.tiles, kBlendedPerTask);
    tbb::parallel_for(all, [&](const tbb::blocked_range<std::size_t>& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const ResidentTile& tile = tiles[list.numbers[i]];
            const scene::BlendSpot& spot = list.spots[i];
            BlendDraw draw;
            draw.tile = tileDrawOf(sources[tile.image].eyeImageFromSource, tile);
            draw.tile.span.y = places[tile.chunk].firstTexel + tile.firstVertex;
            draw.tile.span.z = tile.pointCount;
            draw.spot = vec4(spot.xx, spot.xy, spot.yy, unit * spot.weight);
            draw.reach = vec4(spot.reachX, spot.reachY, spot.tolerance, 0.0f);
            draws[i] = draw;
        }
    });
}

} // namespace render
