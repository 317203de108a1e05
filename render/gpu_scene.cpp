#include "render/gpu_scene.h"

#include "render/device.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace render {

namespace {

constexpr std::array kPageBindings{Binding::texels, Binding::texels};

constexpr std::uint32_t kTilesPerPiece = 2048; ///< some microseconds of culling: worth a task

/// What of a block's tile goes to the device.
struct TileSource {
    std::span<const scene::TileVertex> vertices;
    std::span<const scene::TileQuad> quads;
};

TileSource sourceOf(const scene::TileBlock& block, const scene::Tile& tile) {
    return {block.vertices.subspan(tile.firstVertex, tile.vertexCount),
            block.quads.subspan(tile.firstQuad, tile.quadCount)};
}

template <class T>
Buffer uploadOrDummy(const Device& device, std::vector<T>& values) {
    if (values.empty()) values.emplace_back(); // a buffer cannot be empty; nothing ever reads this one
    return uploadTexels(device, std::as_bytes(std::span(values)));
}

} // namespace

GpuScene::GpuScene(const Device& device, std::span<const scene::TileBlock> blocks, std::size_t pageBytes)
    : pageLayout_(makeSetLayout(device, kPageBindings)) {
    layOut(blocks, std::min(pageBytes, device.limits().maxTexelBufferElements * kTexelBytes));
    upload(device, blocks);
}

void GpuScene::layOut(std::span<const scene::TileBlock> blocks, std::size_t pageBytes) {
    const std::size_t maxVertices = pageBytes / sizeof(scene::TileVertex);
    const std::size_t maxQuads = pageBytes / sizeof(scene::TileQuad);
    std::uint32_t page = 0, vertices = 0, quads = 0;
    for (const scene::TileBlock& block : blocks) {
        const auto image = static_cast<std::uint32_t>(images_.size());
        const std::size_t firstTile = tiles_.size();
        for (const scene::Tile& tile : block.tiles) {
            assert(tile.vertexCount <= maxVertices && tile.quadCount <= maxQuads);
            if (vertices + tile.vertexCount > maxVertices || quads + tile.quadCount > maxQuads)
                ++page, vertices = 0, quads = 0;
            tiles_.push_back({image, page, vertices, tile.pointCount, quads, tile.quadCount, tile.x0, tile.y0,
                              tile.minDisparity, tile.maxDisparity, tile.placeBits,
                              scene::middleOf(tile, block.camera, block.worldFromCamera)});
            bounds_.append(tile, block.camera);
            vertices += tile.vertexCount, quads += tile.quadCount;
        }
        images_.push_back({block.camera, block.worldFromCamera, bounds_.extentOf(firstTile, block.tiles.size())});
        for (std::size_t first = firstTile; first < tiles_.size(); first += pieces_.back().count)
            pieces_.push_back(pieceFrom(first));
    }
    pages_.resize(tiles_.empty() ? 0 : page + 1);
}

TilePiece GpuScene::pieceFrom(std::size_t first) const {
    const auto isBase = [](const ResidentTile& tile) { return tile.middle.tier == scene::Tier::base; };
    TilePiece piece{tiles_[first].image, static_cast<std::uint32_t>(first), 0};
    const bool wantsBase = isBase(tiles_[first]);
    double reach = 0;
    for (std::size_t i = first; i < tiles_.size() && piece.count < kTilesPerPiece; ++i, ++piece.count) {
        if (isBase(tiles_[i]) != wantsBase) break;
        reach = std::max(reach, scene::reachOf(tiles_[i].middle));
    }
    if (!wantsBase) piece.reachMetres = reach;
    return piece;
}

void GpuScene::upload(const Device& device, std::span<const scene::TileBlock> blocks) {
    if (pages_.empty()) return;
    pool_ = makeSetPool(device, pages_.size(), kPageBindings);
    std::vector<scene::TileVertex> vertices;
    std::vector<scene::TileQuad> quads;
    std::uint32_t page = 0;
    const auto flush = [&] {
        Page& made = pages_[page];
        made.vertices = uploadOrDummy(device, vertices);
        made.quads = uploadOrDummy(device, quads);
        made.vertexView = makeTexelView(device, made.vertices);
        made.quadView = makeTexelView(device, made.quads);
        const std::array<Bound, 2> bound{
            {{made.vertices.handle(), made.vertexView}, {made.quads.handle(), made.quadView}}};
        made.set = allocateSet(device, pool_, pageLayout_, bound);
        bytesResident_ += made.vertices.size() + made.quads.size();
        vertices.clear(), quads.clear();
    };

    std::size_t index = 0;
    for (const scene::TileBlock& block : blocks)
        for (const scene::Tile& tile : block.tiles) {
            if (tiles_[index].page != page) {
                flush();
                page = tiles_[index].page;
            }
            const TileSource source = sourceOf(block, tile);
            vertices.insert(vertices.end(), source.vertices.begin(), source.vertices.end());
            quads.insert(quads.end(), source.quads.begin(), source.quads.end());
            ++index;
        }
    flush();
}

} // namespace render
