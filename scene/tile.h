#pragma once
// Tiles: the pieces of a depth image that are culled, stored and drawn (Nyland et al. 1999, section 4.5).
// What stands here is what the GPU reads and what tiles.bin holds, byte for byte.
//
// A tile keeps only the samples that are drawn, with disparity quantised between the tile's own extremes, and only the
// mesh squares that are not skins. Samples that another image keeps stay as border where a square touches a kept one,
// so that neighbouring pieces overlap by one triangle and no seam opens.

#include "scene/depth_image.h"

#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace scene {

inline constexpr int kDefaultTileSize = 32;
inline constexpr int kMaxTileSize = 63; ///< a vertex may stand one sample outside its tile, and has 6 bits
inline constexpr int kPlaceBits = 6;
/// Scraps: what is left of an image where others keep nearly all. Too little to be worth a tile each, it is gathered
/// over several tiles' places, in coordinates of 8 bits.
inline constexpr int kMaxScrapSize = 255;
inline constexpr int kScrapPlaceBits = 8;

/// A sample. place: x | y << bits | q << 2 bits, bits being the tile's placeBits; x and y from the tile's first sample,
/// q the quantised disparity: d = minDisparity + q (maxDisparity - minDisparity) / maxQuantisedOf(tile).
/// colour: r | g << 8 | b << 16 | flags << 24.
struct TileVertex {
    std::uint32_t place = 0, colour = 0;
    friend bool operator==(const TileVertex&, const TileVertex&) = default;
};
static_assert(sizeof(TileVertex) == 8);

/// A mesh square by its four vertices, counted from the tile's first: top = i00 | i10 << 16, bottom = i01 | i11 << 16.
/// kDrawUpper and kDrawLower say which of its two triangles (see SampleFlag) are drawn; a vertex that no drawn triangle
/// needs is 0.
struct TileQuad {
    std::uint32_t top = 0, bottom = 0;
    friend bool operator==(const TileQuad&, const TileQuad&) = default;
};
static_assert(sizeof(TileQuad) == 8);
inline constexpr std::uint32_t kDrawUpper = 1u << 15; ///< in top
inline constexpr std::uint32_t kDrawLower = 1u << 15; ///< in bottom
inline constexpr std::uint32_t kQuadIndexMask = 0x7fff;

/// Base and closed tiles together hold every piece of surface. Directional tiles hold surfaces that the base has
/// too, as they look from another direction: they are drawn only for eyes that look from near it, and leaving them out
/// opens no hole. Guess tiles hold what has no measured range (isGuess): a guess is believed only near where it was
/// made, so they are drawn for the same eyes as directional ones, as pixels of class filled. Closed tiles hold base
/// surface whose range nobody measured (isClosed): they are drawn as base ones, but as pixels of class filled.
enum class Tier : std::uint8_t { base = 0, directional = 1, guess = 2, closed = 3 };
inline constexpr int kTiers = 4;

/// Drawn for all eyes.
inline bool isForAllEyes(Tier tier) {
    return tier == Tier::base || tier == Tier::closed;
}
inline bool isMeasured(Tier tier) {
    return tier == Tier::base || tier == Tier::directional;
}

/// A rectangle of mesh squares that lie in one plane, within the tolerance it was made with: one piece of the adaptive
/// mesh (scene/facets.h). mark: x | y << 6 of its top left vertex | log2 of its side in squares << 12, and which halves
/// are drawn: kFacetUpper and kFacetLower as in a square. Over it quantised disparity is q + x perX + y perY, x and y
/// from its top left vertex.
struct TileFacet {
    std::uint32_t mark = 0;
    float q = 0, perX = 0, perY = 0;
    friend bool operator==(const TileFacet&, const TileFacet&) = default;
};
static_assert(sizeof(TileFacet) == 16);
inline constexpr std::uint32_t kFacetUpper = 1u << 16, kFacetLower = 1u << 17;

/// What facets are textured with: the colour of a sample and of the one to its right (r | g << 8 | b << 16), so that
/// two reads give the four about any place.
struct TileTexel {
    std::uint32_t here = 0, right = 0;
    friend bool operator==(const TileTexel&, const TileTexel&) = default;
};
static_assert(sizeof(TileTexel) == 8);

/// firstVertex, firstQuad, firstFacet and firstTexel count within the image's block. The first pointCount vertices are
/// kept samples; then comes border, which only the mesh uses; the last loneCount are, once more, those kept samples
/// that no square of the tile has for a corner. The extremes are over all vertices.
///
/// A tile of level L stands in the image halved L times (scene/pyramid.h): x0, y0 and its vertices count that image's
/// samples.
struct Tile {
    std::int32_t x0 = 0, y0 = 0; ///< first sample in the image
    float minDisparity = 0, maxDisparity = 0;
    std::uint32_t firstVertex = 0, pointCount = 0, vertexCount = 0;
    std::uint32_t firstQuad = 0, quadCount = 0;
    std::uint8_t width = 0, height = 0; ///< in samples; vertices have x <= width, y <= height
    Tier tier = Tier::base;
    std::uint8_t placeBits = kPlaceBits;          ///< kPlaceBits, or kScrapPlaceBits
    std::uint32_t firstFacet = 0, facetCount = 0; ///< none where facets would not pay: then the squares are drawn
    std::uint32_t firstTexel = 0;                 ///< of width + 1 a row, height + 1 rows, if there are facets
    std::uint8_t level = 0;
    /// What neighbours differ by in seven of eight squares, at most: 255ths of the range of the tile's disparities.
    std::uint8_t steepness = 0;
    std::uint16_t loneCount = 0;
    friend bool operator==(const Tile&, const Tile&) = default;
};
static_assert(sizeof(Tile) == 56);

/// Texels of a tile with facets.
inline std::uint32_t texelCountOf(const Tile& tile) {
    return tile.facetCount > 0 ? (tile.width + 1u) * (tile.height + 1u) : 0;
}

inline std::uint32_t firstLoneOf(const Tile& tile) {
    return tile.firstVertex + tile.vertexCount - tile.loneCount;
}

inline std::uint32_t maxQuantisedOf(std::uint32_t placeBits) {
    return (1u << (32 - 2 * placeBits)) - 1;
}
inline std::uint32_t maxQuantisedOf(const Tile& tile) {
    return maxQuantisedOf(tile.placeBits);
}

/// A vertex' place taken apart.
struct VertexPlace {
    std::uint32_t x = 0, y = 0, q = 0;
};
inline VertexPlace placeOf(const Tile& tile, const TileVertex& vertex) {
    const std::uint32_t mask = (1u << tile.placeBits) - 1;
    return {vertex.place & mask, vertex.place >> tile.placeBits & mask, vertex.place >> 2 * tile.placeBits};
}

inline constexpr int kMaxLevels = 8; ///< the finest included

/// The tiles of one image, owned: those of its own samples, and those of coarser levels, ascending.
struct TileSet {
    std::vector<Tile> tiles, coarser;
    std::vector<TileVertex> vertices;
    std::vector<TileQuad> quads;
    std::vector<TileFacet> facets;
    std::vector<TileTexel> texels;
};

/// Metres along the world's axes.
struct WorldExtent {
    glm::dvec3 least{-std::numeric_limits<double>::infinity()}, most{std::numeric_limits<double>::infinity()};
    bool isFinite() const { return std::isfinite(least.x + least.y + least.z + most.x + most.y + most.z); }
};

/// The tiles of one image, lent, with the camera that makes them points: what a renderer is given.
struct TileBlock {
    Camera camera;
    Pose worldFromCamera;
    std::span<const Tile> tiles, coarser;
    std::span<const TileVertex> vertices;
    std::span<const TileQuad> quads;
    std::span<const TileFacet> facets;
    std::span<const TileTexel> texels;
    /// By chunk (scene/tile_chunks.h), where what the tiles hold is yet to be checked when it is first needed.
    std::span<const std::uint64_t> chunkSums;
    /// By chunk: what was found of them already (SoundTiles); null if that is not kept. 0: not asked yet, 1: sound, 2:
    /// not.
    std::atomic<std::uint8_t>* verdicts = nullptr;
    bool isMapped = false; ///< from a file: memory that it takes can be given back, and is read again when needed
    WorldExtent
        samplesInWorld{}; ///< about all of them, those of coarser levels, too; without end where nobody found it
};

/// Reads all that a block holds. tolerance: by this share of a sample's disparity, less than 1, what is drawn may be
/// off (facets are). With a sample infinitely far away it is without end.
WorldExtent boxAroundSamples(const TileBlock& block, double tolerance);

inline TileBlock lend(const TileSet& set, const Camera& camera, const Pose& worldFromCamera) {
    return {camera,     worldFromCamera, set.tiles, set.coarser, set.vertices, set.quads,
            set.facets, set.texels,      {},        nullptr,     false,        {}};
}

/// Cuts an image into tiles of tileSize x tileSize samples (1 to kMaxTileSize). A sample is kept if it is drawable and
/// not redundant; a triangle is drawn if it is no skin, its three samples are drawable and at least one is kept, by the
/// tier of its kept samples (closed, base, guess, directional); with a guess among them it is one. A place in the
/// image gives up to four tiles, one of each tier; those without kept samples and triangles are left out. Where fewer
/// than one sample in kScrapShare is kept, what there is goes into scraps: so that each step of their disparities
/// stays small, every scrap holds surfaces of like distance. Tier by tier, so that what is drawn only from near can be
/// passed over together.
TileSet cutIntoTiles(const DepthImage& image, int tileSize = kDefaultTileSize);

inline constexpr int kScrapShare = 32;

/// Disparity of a vertex of this tile.
inline float disparityOf(const Tile& tile, const TileVertex& vertex) {
    const float step = (tile.maxDisparity - tile.minDisparity) / static_cast<float>(maxQuantisedOf(tile));
    return tile.minDisparity + static_cast<float>(placeOf(tile, vertex).q) * step;
}

} // namespace scene
