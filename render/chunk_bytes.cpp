#include "render/chunk_bytes.h"

#include "render/shaders/shared/unseen.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

namespace render {

namespace {

/// Stripes across a picture: nobody measured where in space they stand.
std::uint32_t colourAt(std::uint32_t x, std::uint32_t y) {
    constexpr std::uint32_t kStripe = 8; // samples
    return stripeColour((x + y) / kStripe % 2 == 0 ? 0.0f : 1.0f);
}

class Placeholder {
  public:
    explicit Placeholder(const scene::Tile& tile)
        : tile_(tile), right_(tile.width), below_(tile.height), q_(scene::maxQuantisedOf(tile) / 2) {}

    /// The first four are the corners, the others row by row over all of the tile.
    scene::TileVertex vertex(std::uint32_t i) const {
        if (i < 4) return at(i % 2 * right_, i / 2 * below_);
        const std::uint64_t cells = std::uint64_t{std::max(right_, 1u)} * std::max(below_, 1u);
        const auto cell = static_cast<std::uint32_t>((i - 4) * cells / std::max(tile_.vertexCount, 1u));
        return at(cell % std::max(right_, 1u), cell / std::max(right_, 1u));
    }

    /// The first is all of the tile; the others are nothing.
    scene::TileQuad quad(std::uint32_t i) const {
        if (i > 0 || tile_.vertexCount < 4) return {};
        return {0u | 1u << 16 | scene::kDrawUpper, 2u | 3u << 16 | scene::kDrawLower};
    }

    /// All are the largest that fits.
    scene::TileFacet facet() const {
        std::uint32_t log = 0;
        while ((2u << log) <= std::min(right_, below_))
            ++log;
        return {log << 12 | scene::kFacetUpper | scene::kFacetLower, static_cast<float>(q_), 0, 0};
    }

    scene::TileTexel texel(std::uint32_t i) const {
        const std::uint32_t x = i % (right_ + 1), y = i / (right_ + 1);
        return {colourAt(x, y), colourAt(x + 1, y)};
    }

  private:
    scene::TileVertex at(std::uint32_t x, std::uint32_t y) const {
        return {x | y << tile_.placeBits | q_ << 2 * tile_.placeBits, colourAt(x, y)};
    }

    const scene::Tile& tile_;
    std::uint32_t right_, below_, q_;
};

void writePlaceholder(const scene::TileBlock& block, const scene::TileChunk& chunk, std::byte* to) {
    const auto put = [&](const auto& value) {
        std::memcpy(to, &value, sizeof value);
        to += sizeof value;
    };
    const auto forTiles = [&](auto&& visit) {
        for (std::uint32_t i = chunk.firstTile; i < chunk.firstTile + chunk.tileCount; ++i)
            visit(scene::tileOf(block, i));
    };
    forTiles([&](const scene::Tile& tile) {
        for (std::uint32_t i = 0; i < tile.facetCount; ++i)
            put(Placeholder(tile).facet());
    });
    forTiles([&](const scene::Tile& tile) {
        for (std::uint32_t i = 0; i < tile.vertexCount; ++i)
            put(Placeholder(tile).vertex(i));
    });
    forTiles([&](const scene::Tile& tile) {
        for (std::uint32_t i = 0; i < tile.quadCount; ++i)
            put(Placeholder(tile).quad(i));
    });
    forTiles([&](const scene::Tile& tile) {
        for (std::uint32_t i = 0; i < scene::texelCountOf(tile); ++i)
            put(Placeholder(tile).texel(i));
    });
}

} // namespace

bool bringChunk(const scene::TileBlock& block, const IndexedChunk& chunk, std::byte* to) {
    const bool isSound = scene::isSound(block, chunk.chunk, chunk.number);
    if (isSound)
        scene::copyChunk(block, chunk.chunk, to);
    else
        writePlaceholder(block, chunk.chunk, to);
    scene::releaseChunk(block, chunk.chunk);
    return isSound;
}

} // namespace render
