#include "render/gpu_scene.h"

#include "render/device.h"
#include "scene/pyramid.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace render {

namespace {

constexpr std::array kPageBindings{Binding::texels, Binding::texels, Binding::texels, Binding::texels};

constexpr std::uint32_t kTilesPerPiece = 2048; ///< some microseconds of culling: worth a task

/// The bytes of a block's tile that go to the device, by binding.
std::array<std::span<const std::byte>, 4> sourceOf(const scene::TileBlock& block, const scene::Tile& tile) {
    return {std::as_bytes(block.vertices.subspan(tile.firstVertex, tile.vertexCount)),
            std::as_bytes(block.quads.subspan(tile.firstQuad, tile.quadCount)),
            std::as_bytes(block.facets.subspan(tile.firstFacet, tile.facetCount)),
            std::as_bytes(block.texels.subspan(tile.firstTexel, scene::texelCountOf(tile)))};
}

/// In the middle by distance from the camera; infinite for the sky.
double middleReachOf(const scene::TileBlock& block) {
    std::vector<double> reaches;
    for (const scene::Tile& tile : block.tiles)
        reaches.push_back(scene::reachOf(scene::middleOf(tile, block.camera, block.worldFromCamera)));
    if (reaches.empty()) return 0;
    const auto middle = reaches.begin() + std::ssize(reaches) / 2;
    std::nth_element(reaches.begin(), middle, reaches.end());
    return *middle;
}

} // namespace

/// How far the page is filled that is being laid out: texels, by binding.
struct GpuScene::Filling {
    std::uint32_t page = 0;
    std::array<std::size_t, 4> texels{};
    std::size_t room = 0; ///< of each
};

GpuScene::GpuScene(const Device& device, std::span<const scene::TileBlock> blocks, std::size_t pageBytes)
    : pageLayout_(makeSetLayout(device, kPageBindings)) {
    layOut(blocks, std::min(pageBytes, device.limits().maxTexelBufferElements * kTexelBytes));
    upload(device, blocks);
}

void GpuScene::layOut(std::span<const scene::TileBlock> blocks, std::size_t pageBytes) {
    Filling filling;
    filling.room = pageBytes / kTexelBytes;
    capturedImages_ = blocks.size();
    std::vector<ResidentImage> captured;
    for (const scene::TileBlock& block : blocks) {
        captured.push_back({block.camera,
                            block.worldFromCamera,
                            {},
                            static_cast<std::uint32_t>(captured.size()),
                            0,
                            !block.coarser.empty(),
                            middleReachOf(block)});
        layOutImage(captured.back(), block.tiles, filling);
    }
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        std::span<const scene::Tile> left = blocks[i].coarser;
        while (!left.empty()) {
            const std::uint8_t level = left.front().level;
            std::size_t count = 0;
            while (count < left.size() && left[count].level == level)
                ++count;
            ResidentImage image = captured[i];
            image.camera = scene::cameraAtLevel(image.camera, level);
            image.level = level;
            image.hasCoarser = count < left.size();
            layOutImage(image, left.first(count), filling);
            left = left.subspan(count);
        }
    }
    pages_.resize(tiles_.empty() ? 0 : filling.page + 1);
}

void GpuScene::layOutImage(const ResidentImage& image, std::span<const scene::Tile> tiles, Filling& filling) {
    const auto number = static_cast<std::uint32_t>(images_.size());
    const std::size_t firstTile = tiles_.size();
    for (const scene::Tile& tile : tiles) {
        const std::array<std::size_t, 4> needed{tile.vertexCount, tile.quadCount, 2 * std::size_t{tile.facetCount},
                                                scene::texelCountOf(tile)};
        bool fits = true;
        for (std::size_t i = 0; i < needed.size(); ++i) {
            assert(needed[i] <= filling.room);
            fits = fits && filling.texels[i] + needed[i] <= filling.room;
        }
        if (!fits) ++filling.page, filling.texels = {};
        const auto first = [&](std::size_t binding) { return static_cast<std::uint32_t>(filling.texels[binding]); };
        ResidentTile resident;
        resident.image = number, resident.page = filling.page;
        resident.firstVertex = first(0), resident.pointCount = tile.pointCount;
        resident.firstQuad = first(1), resident.quadCount = tile.quadCount;
        resident.firstFacet = first(2) / 2, resident.facetCount = tile.facetCount;
        resident.firstTexel = first(3), resident.texelsInRow = tile.width + 1u;
        resident.x0 = tile.x0, resident.y0 = tile.y0;
        resident.minDisparity = tile.minDisparity, resident.maxDisparity = tile.maxDisparity;
        resident.placeBits = tile.placeBits;
        resident.middle = scene::middleOf(tile, image.camera, image.worldFromCamera);
        tiles_.push_back(resident);
        bounds_.append(tile, image.camera);
        for (std::size_t i = 0; i < needed.size(); ++i)
            filling.texels[i] += needed[i];
    }
    images_.push_back(image);
    images_.back().extent = bounds_.extentOf(firstTile, tiles.size());
    for (std::size_t first = firstTile; first < tiles_.size(); first += pieces_.back().count)
        pieces_.push_back(pieceFrom(first));
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
    std::array<std::vector<std::byte>, 4> bytes;
    std::uint32_t page = 0;
    const auto flush = [&] {
        Page& made = pages_[page];
        std::array<Bound, 4> bound;
        for (std::size_t i = 0; i < bytes.size(); ++i) {
            if (bytes[i].empty()) bytes[i].resize(kTexelBytes); // a buffer cannot be empty; nothing ever reads this one
            made.buffers[i] = uploadTexels(device, bytes[i]);
            made.views[i] = makeTexelView(device, made.buffers[i]);
            bound[i] = {made.buffers[i].handle(), made.views[i]};
            bytesResident_ += made.buffers[i].size();
            bytes[i].clear();
        }
        made.set = allocateSet(device, pool_, pageLayout_, bound);
    };

    std::size_t index = 0;
    const auto append = [&](const scene::TileBlock& block, std::span<const scene::Tile> tiles) {
        for (const scene::Tile& tile : tiles) {
            if (tiles_[index].page != page) {
                flush();
                page = tiles_[index].page;
            }
            const auto source = sourceOf(block, tile);
            for (std::size_t i = 0; i < source.size(); ++i)
                bytes[i].insert(bytes[i].end(), source[i].begin(), source[i].end());
            ++index;
        }
    };
    for (const scene::TileBlock& block : blocks)
        append(block, block.tiles);
    for (const scene::TileBlock& block : blocks)
        append(block, block.coarser);
    flush();
}

} // namespace render
