#include "scene/tile_chunks.h"

#include "scene/checksum.h"
#include "scene/facets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include <sys/mman.h>
#include <unistd.h>

namespace scene {

namespace {

std::array<std::span<const std::byte>, 4> partsOf(const TileBlock& block, const TileChunk& chunk) {
    return {std::as_bytes(block.facets.subspan(chunk.firstFacet, chunk.facetCount)),
            std::as_bytes(block.vertices.subspan(chunk.firstVertex, chunk.vertexCount)),
            std::as_bytes(block.quads.subspan(chunk.firstQuad, chunk.quadCount)),
            std::as_bytes(block.texels.subspan(chunk.firstTexel, chunk.texelCount))};
}

bool isSound(const TileBlock& block, const Tile& tile) {
    const auto isWithin = [&](std::uint32_t pair) {
        return (pair & kQuadIndexMask) < tile.vertexCount && (pair >> 16 & kQuadIndexMask) < tile.vertexCount;
    };
    for (const TileQuad& quad : block.quads.subspan(tile.firstQuad, tile.quadCount))
        if (!isWithin(quad.top) || !isWithin(quad.bottom)) return false;
    for (const TileFacet& facet : block.facets.subspan(tile.firstFacet, tile.facetCount)) {
        const std::uint32_t side = 1u << log2SideOf(facet);
        if ((facet.mark & 63u) + side > tile.width || (facet.mark >> 6 & 63u) + side > tile.height) return false;
        if (!std::isfinite(facet.q) || !std::isfinite(facet.perX) || !std::isfinite(facet.perY)) return false;
    }
    return true;
}

/// Facets and texels of a tile without facets stand nowhere.
bool follows(const TileChunk& chunk, const TileChunk& next) {
    const bool facetsFollow = chunk.facetCount == 0 || next.facetCount == 0 ||
                              (next.firstFacet == chunk.firstFacet + chunk.facetCount &&
                               next.firstTexel == chunk.firstTexel + chunk.texelCount);
    return next.firstVertex == chunk.firstVertex + chunk.vertexCount &&
           next.firstQuad == chunk.firstQuad + chunk.quadCount && facetsFollow;
}

} // namespace

std::vector<TileChunk> chunksOf(const TileBlock& block, std::size_t maxBytes) {
    std::vector<TileChunk> chunks;
    const std::size_t count = block.tiles.size() + block.coarser.size();
    for (std::size_t i = 0; i < count; ++i) {
        const Tile& tile = tileOf(block, i);
        TileChunk alone;
        alone.firstTile = static_cast<std::uint32_t>(i), alone.tileCount = 1;
        alone.firstVertex = tile.firstVertex, alone.vertexCount = tile.vertexCount;
        alone.firstQuad = tile.firstQuad, alone.quadCount = tile.quadCount;
        alone.firstFacet = tile.firstFacet, alone.facetCount = tile.facetCount;
        alone.firstTexel = tile.firstTexel, alone.texelCount = texelCountOf(tile);
        alone.tier = tile.tier, alone.level = tile.level;
        if (!chunks.empty()) {
            TileChunk& last = chunks.back();
            if (last.tier == tile.tier && last.level == tile.level && last.bytes() + alone.bytes() <= maxBytes &&
                follows(last, alone)) {
                if (last.facetCount == 0) last.firstFacet = alone.firstFacet, last.firstTexel = alone.firstTexel;
                ++last.tileCount;
                last.vertexCount += alone.vertexCount, last.quadCount += alone.quadCount;
                last.facetCount += alone.facetCount, last.texelCount += alone.texelCount;
                continue;
            }
        }
        chunks.push_back(alone);
    }
    return chunks;
}

std::uint64_t checksumOf(const TileBlock& block, const TileChunk& chunk) {
    Checksum sum;
    for (const std::span<const std::byte> part : partsOf(block, chunk))
        sum.add(part);
    return sum.value();
}

bool isSound(const TileBlock& block, const TileChunk& chunk, std::size_t number) {
    if (block.chunkSums.empty()) return true; // made in this process
    if (checksumOf(block, chunk) != block.chunkSums[number]) return false;
    for (std::uint32_t i = chunk.firstTile; i < chunk.firstTile + chunk.tileCount; ++i)
        if (!isSound(block, tileOf(block, i))) return false;
    return true;
}

bool SoundTiles::isSound(std::size_t tile) {
    if (block_.chunkSums.empty()) return true;
    if (chunks_.empty()) {
        chunks_ = chunksOf(block_);
        own_ = std::vector<std::atomic<std::uint8_t>>(block_.verdicts == nullptr ? chunks_.size() : 0);
    }
    std::atomic<std::uint8_t>* const verdicts = block_.verdicts != nullptr ? block_.verdicts : own_.data();
    const auto after = std::upper_bound(chunks_.begin(), chunks_.end(), tile,
                                        [](std::size_t t, const TileChunk& chunk) { return t < chunk.firstTile; });
    const auto number = static_cast<std::size_t>(after - chunks_.begin()) - 1;
    // Two threads may find out the same at the same time.
    std::uint8_t verdict = verdicts[number].load(std::memory_order_relaxed);
    if (verdict == 0) {
        verdict = scene::isSound(block_, chunks_[number], number) ? 1 : 2;
        verdicts[number].store(verdict, std::memory_order_relaxed);
    }
    return verdict == 1;
}

void copyChunk(const TileBlock& block, const TileChunk& chunk, std::byte* to) {
    for (const std::span<const std::byte> part : partsOf(block, chunk)) {
        if (!part.empty()) std::memcpy(to, part.data(), part.size());
        to += part.size();
    }
}

void releaseChunk(const TileBlock& block, const TileChunk& chunk) {
    if (!block.isMapped) return;
    static const auto kPage = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
    for (const std::span<const std::byte> part : partsOf(block, chunk)) {
        // Whole pages: what lies beside may be in use, and costs nothing but a look at the system's cache if it is.
        const auto first = (reinterpret_cast<std::uintptr_t>(part.data()) + kPage - 1) / kPage * kPage;
        const auto end = reinterpret_cast<std::uintptr_t>(part.data() + part.size()) / kPage * kPage;
        if (first < end) madvise(reinterpret_cast<void*>(first), end - first, MADV_DONTNEED);
    }
}

} // namespace scene
