#include "scene/tile.h"

#include "scene/pyramid.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace scene {

namespace {

constexpr std::uint32_t kNowhere = std::numeric_limits<std::uint32_t>::max();

bool isKept(std::uint8_t flags) {
    return isDrawable(flags) && (flags & kRedundant) == 0;
}

Tier tierOf(std::uint8_t flags) {
    const bool isDirectional = (flags & kDirectional) != 0;
    // Of a piece of surface that another image holds, a look that nobody measured is worth no more than a guess.
    if (isGuess(flags) || (isClosed(flags) && isDirectional)) return Tier::guess;
    if (isClosed(flags)) return Tier::closed;
    return isDirectional ? Tier::directional : Tier::base;
}

/// Which samples a tile is cut from; by its top left sample a square belongs to it.
struct Cut {
    Tier tier = Tier::base;
    int x0 = 0, y0 = 0, width = 0, height = 0;
    std::uint32_t placeBits = kPlaceBits;
};

struct Place {
    int x = 0, y = 0;
};

/// A few steep squares, at rims or of noise, do not make a tile steep.
constexpr std::ptrdiff_t kSteepSquares = 7, kOfSquares = 8;
constexpr double kMostSteep = std::numeric_limits<decltype(Tile::steepness)>::max();

struct Taken {
    int x = 0, y = 0;
    bool isLone = true; ///< no corner of a square, of those that were appended
};

static_assert(kMaxScrapSize * kMaxScrapSize <= std::numeric_limits<decltype(Tile::loneCount)>::max());

/// Collects one tile: kept samples first, then the border its triangles need, then lone samples once more.
/// part.eachSample(visit), part.eachSquare(visit): call visit(x, y) for what may belong to the tile, counted from the
/// cut's first. But for scraps row by row: renderers pass over rows.
template <class Part>
class TileCutter {
  public:
    TileCutter(const DepthImage& image, const Cut& cut, const Part& part)
        : image_(image), tier_(cut.tier), x0_(cut.x0), y0_(cut.y0), width_(cut.width), height_(cut.height),
          placeBits_(cut.placeBits), part_(part), vertexAt_((width_ + 1) * (height_ + 1), kNowhere) {}

    void appendTo(TileSet& set) {
        Tile tile;
        tile.x0 = x0_, tile.y0 = y0_;
        tile.width = static_cast<std::uint8_t>(width_), tile.height = static_cast<std::uint8_t>(height_);
        tile.tier = tier_;
        tile.placeBits = static_cast<std::uint8_t>(placeBits_);
        tile.firstVertex = static_cast<std::uint32_t>(set.vertices.size());
        tile.firstQuad = static_cast<std::uint32_t>(set.quads.size());

        part_.eachSample([&](int x, int y) {
            if (isKept(flagsAt(x, y)) && tierOf(flagsAt(x, y)) == tier_) take(x, y);
        });
        tile.pointCount = static_cast<std::uint32_t>(taken_.size());

        part_.eachSquare([&](int x, int y) { appendQuad(x, y, set); });
        repeatLone(tile);
        tile.vertexCount = static_cast<std::uint32_t>(taken_.size());
        tile.quadCount = static_cast<std::uint32_t>(set.quads.size()) - tile.firstQuad;
        if (taken_.empty()) return;

        quantise(tile, set);
        set.tiles.push_back(tile);
    }

  private:
    std::uint8_t flagsAt(int x, int y) const { return image_.flags(x0_ + x, y0_ + y); }
    bool isInside(int x, int y) const { return x0_ + x < image_.camera.width && y0_ + y < image_.camera.height; }

    std::uint32_t take(int x, int y) {
        std::uint32_t& index = vertexAt_[static_cast<std::size_t>(y) * (width_ + 1) + x];
        if (index == kNowhere) {
            index = static_cast<std::uint32_t>(taken_.size());
            taken_.push_back({x, y});
        }
        return index;
    }

    bool isDrawn(int ax, int ay, int bx, int by, int cx, int cy) const {
        if (!isInside(ax, ay) || !isInside(bx, by) || !isInside(cx, cy)) return false;
        const std::uint8_t a = flagsAt(ax, ay), b = flagsAt(bx, by), c = flagsAt(cx, cy);
        if (!isDrawable(a) || !isDrawable(b) || !isDrawable(c)) return false;
        // A triangle between tiers is the base's, so that the base has no cracks of its own; but where a corner that is
        // kept was not measured, it is not what was seen.
        const auto has = [&](Tier tier) {
            return (isKept(a) && tierOf(a) == tier) || (isKept(b) && tierOf(b) == tier) ||
                   (isKept(c) && tierOf(c) == tier);
        };
        if (isGuess(a) || isGuess(b) || isGuess(c))
            return tier_ == Tier::guess && (isKept(a) || isKept(b) || isKept(c));
        for (const Tier tier : {Tier::closed, Tier::base, Tier::guess, Tier::directional})
            if (has(tier)) return tier_ == tier;
        return false;
    }

    void appendQuad(int x, int y, TileSet& set) {
        const std::uint8_t skins = flagsAt(x, y);
        const bool upper = (skins & kSkinUpper) == 0 && isDrawn(x, y, x + 1, y, x, y + 1);
        const bool lower = (skins & kSkinLower) == 0 && isDrawn(x + 1, y, x + 1, y + 1, x, y + 1);
        if (!upper && !lower) return;
        const std::uint32_t i10 = take(x + 1, y), i01 = take(x, y + 1);
        const std::uint32_t i00 = upper ? take(x, y) : 0, i11 = lower ? take(x + 1, y + 1) : 0;
        taken_[i10].isLone = taken_[i01].isLone = false;
        if (upper) taken_[i00].isLone = false;
        if (lower) taken_[i11].isLone = false;
        float steepest = 0;
        const auto differ = [&](int ax, int ay, int bx, int by) {
            const float a = image_.disparity(x0_ + ax, y0_ + ay), b = image_.disparity(x0_ + bx, y0_ + by);
            steepest = std::max(steepest, std::abs(a - b));
        };
        if (upper) differ(x, y, x + 1, y), differ(x, y, x, y + 1);
        if (lower) differ(x + 1, y + 1, x + 1, y), differ(x + 1, y + 1, x, y + 1);
        steps_.push_back(steepest);
        set.quads.push_back({i00 | i10 << 16 | (upper ? kDrawUpper : 0), i01 | i11 << 16 | (lower ? kDrawLower : 0)});
    }

    void repeatLone(Tile& tile) {
        for (std::uint32_t i = 0; i < tile.pointCount; ++i) {
            const Taken taken = taken_[i];
            if (!taken.isLone) continue;
            taken_.push_back(taken);
            ++tile.loneCount;
        }
    }

    void quantise(Tile& tile, TileSet& set) {
        tile.minDisparity = std::numeric_limits<float>::max();
        tile.maxDisparity = 0;
        for (const Taken& place : taken_) {
            const float disparity = image_.disparity(x0_ + place.x, y0_ + place.y);
            assert(std::isfinite(disparity) && disparity >= 0);
            tile.minDisparity = std::min(tile.minDisparity, disparity);
            tile.maxDisparity = std::max(tile.maxDisparity, disparity);
        }
        const double range = static_cast<double>(tile.maxDisparity) - tile.minDisparity;
        const std::uint32_t maxQuantised = maxQuantisedOf(placeBits_);
        const double scale = range > 0 ? maxQuantised / range : 0.0;
        if (range > 0 && !steps_.empty()) {
            const auto most = steps_.begin() + (std::ssize(steps_) * kSteepSquares + kOfSquares - 1) / kOfSquares - 1;
            std::nth_element(steps_.begin(), most, steps_.end());
            tile.steepness = static_cast<std::uint8_t>(std::min(std::ceil(kMostSteep * (*most / range)), kMostSteep));
        }
        for (const Taken& place : taken_) {
            const int x = x0_ + place.x, y = y0_ + place.y;
            const double above = static_cast<double>(image_.disparity(x, y)) - tile.minDisparity;
            const auto q = std::min(static_cast<std::uint32_t>(std::lround(above * scale)), maxQuantised);
            const Rgb8 c = image_.colour(x, y);
            set.vertices.push_back({static_cast<std::uint32_t>(place.x) |
                                        static_cast<std::uint32_t>(place.y) << placeBits_ | q << 2 * placeBits_,
                                    c.r | static_cast<std::uint32_t>(c.g) << 8 | static_cast<std::uint32_t>(c.b) << 16 |
                                        static_cast<std::uint32_t>(image_.flags(x, y)) << 24});
        }
    }

    const DepthImage& image_;
    Tier tier_;
    int x0_, y0_, width_, height_;
    std::uint32_t placeBits_;
    const Part& part_;
    std::vector<std::uint32_t> vertexAt_;
    std::vector<Taken> taken_;
    std::vector<float> steps_; ///< of each square, the greatest difference in disparity along its triangles' sides
};

/// All that stands in a tile's place.
struct Whole {
    int width, height;
    template <class Visit>
    void eachSample(const Visit& visit) const {
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                visit(x, y);
    }
    template <class Visit>
    void eachSquare(const Visit& visit) const {
        eachSample(visit);
    }
};

/// Places this small hold too few samples for scraps to save anything.
constexpr int kLeastScrapPlace = 16;

/// Which surfaces share a scrap: those whose disparities have the same power of four below them.
Image<std::int8_t> distancesOf(const DepthImage& image) {
    constexpr std::int8_t kInfinitelyFar = std::numeric_limits<std::int8_t>::min(); // below any float's
    Image<std::int8_t> distances(image.camera.width, image.camera.height, kInfinitelyFar);
    for (std::size_t i = 0; i < distances.size(); ++i)
        if (const float disparity = image.disparity.pixels()[i]; disparity > 0)
            distances.pixels()[i] = static_cast<std::int8_t>(std::ilogb(disparity) >> 1);
    return distances;
}

/// Of each square, by its top left sample, whether one of its corners is kept, in whatever tier: else it belongs to no
/// tile. Of most images little is kept.
Image<std::uint8_t> squaresOfKept(const DepthImage& image) {
    Image<std::uint8_t> squares(image.camera.width, image.camera.height, 0);
    for (int y = 0; y < image.camera.height; ++y)
        for (int x = 0; x < image.camera.width; ++x) {
            if (!isKept(image.flags(x, y))) continue;
            for (int j = std::max(y - 1, 0); j <= y; ++j)
                for (int i = std::max(x - 1, 0); i <= x; ++i)
                    squares(i, j) = 1;
        }
    return squares;
}

/// Cuts one tier of an image: full places into tiles of their own, the rest into scraps.
class TierCutter {
  public:
    TierCutter(const DepthImage& image, const Image<std::uint8_t>& squaresOfKept, const Image<std::int8_t>& distances,
               Tier tier, int tileSize)
        : image_(image), squaresOfKept_(squaresOfKept), distances_(distances), tier_(tier), tileSize_(tileSize),
          columns_(placesIn(image.camera.width)), rows_(placesIn(image.camera.height)),
          isScrap_(static_cast<std::size_t>(columns_) * rows_) {
        for (int i = 0; i < std::max(image.camera.width, image.camera.height); ++i)
            placeOf_.push_back(i / tileSize);
        for (int row = 0; row < rows_; ++row)
            for (int column = 0; column < columns_; ++column)
                isScrap_[static_cast<std::size_t>(row) * columns_ + column] = isSparse(column, row);
    }

    void appendTo(TileSet& set) {
        for (int row = 0; row < rows_; ++row)
            for (int column = 0; column < columns_; ++column)
                if (!isScrap_[static_cast<std::size_t>(row) * columns_ + column]) {
                    const Cut cut = cutAt(column * tileSize_, row * tileSize_, tileSize_, kPlaceBits);
                    TileCutter(image_, cut, Whole{cut.width, cut.height}).appendTo(set);
                }
        if (tileSize_ < kLeastScrapPlace) return;
        const int side = kMaxScrapSize / tileSize_ * tileSize_;
        for (int y0 = 0; y0 < image_.camera.height; y0 += side)
            for (int x0 = 0; x0 < image_.camera.width; x0 += side)
                appendScraps(cutAt(x0, y0, side, kScrapPlaceBits), set);
    }

  private:
    int placesIn(int samples) const { return (samples + tileSize_ - 1) / tileSize_; }

    Cut cutAt(int x0, int y0, int side, int placeBits) const {
        return {tier_,
                x0,
                y0,
                std::min(side, image_.camera.width - x0),
                std::min(side, image_.camera.height - y0),
                static_cast<std::uint32_t>(placeBits)};
    }

    bool isSparse(int column, int row) const {
        if (tileSize_ < kLeastScrapPlace) return false;
        const Cut cut = cutAt(column * tileSize_, row * tileSize_, tileSize_, kPlaceBits);
        int kept = 0;
        for (int y = cut.y0; y < cut.y0 + cut.height; ++y)
            for (int x = cut.x0; x < cut.x0 + cut.width; ++x)
                kept += isKept(image_.flags(x, y)) && tierOf(image_.flags(x, y)) == tier_;
        return kept * kScrapShare < tileSize_ * tileSize_;
    }

    bool isScrapAt(int x, int y) const {
        const int row = placeOf_[static_cast<std::size_t>(y)], column = placeOf_[static_cast<std::size_t>(x)];
        return isScrap_[static_cast<std::size_t>(row) * columns_ + column] != 0;
    }

    /// What may belong to one scrap. A square is as far as its top right sample, which any triangle of it has.
    struct Scrap {
        int distance = 0;
        std::vector<Place> samples{}, squares{};
        template <class Visit>
        void eachSample(const Visit& visit) const {
            for (const Place& place : samples)
                visit(place.x, place.y);
        }
        template <class Visit>
        void eachSquare(const Visit& visit) const {
            for (const Place& place : squares)
                visit(place.x, place.y);
        }
    };

    /// That of a distance; there are few.
    static Scrap& scrapOf(std::vector<Scrap>& scraps, int distance) {
        const auto it = std::ranges::find(scraps, distance, &Scrap::distance);
        return it != scraps.end() ? *it : scraps.emplace_back(Scrap{distance});
    }

    void appendScraps(const Cut& cut, TileSet& set) const {
        std::vector<Scrap> scraps;
        for (int y = 0; y < cut.height; ++y)
            for (int x = 0; x < cut.width; ++x) {
                const int column = cut.x0 + x, row = cut.y0 + y;
                if (squaresOfKept_(column, row) == 0 || !isScrapAt(column, row)) continue;
                const std::uint8_t flags = image_.flags(column, row);
                if (isKept(flags) && tierOf(flags) == tier_)
                    scrapOf(scraps, distances_(column, row)).samples.push_back({x, y});
                if (column + 1 < image_.camera.width && isDrawable(image_.flags(column + 1, row)))
                    scrapOf(scraps, distances_(column + 1, row)).squares.push_back({x, y});
            }
        std::ranges::sort(scraps, {}, &Scrap::distance);
        for (const Scrap& scrap : scraps)
            TileCutter(image_, cut, scrap).appendTo(set);
    }

    const DepthImage& image_;
    const Image<std::uint8_t>& squaresOfKept_;
    const Image<std::int8_t>& distances_; ///< see distancesOf
    Tier tier_;
    int tileSize_, columns_, rows_;
    std::vector<std::uint8_t> isScrap_;
    std::vector<int> placeOf_; ///< of a row or column of samples
};

} // namespace

TileSet cutIntoTiles(const DepthImage& image, int tileSize) {
    assert(tileSize >= 1 && tileSize <= kMaxTileSize);
    TileSet set;
    const Image<std::uint8_t> squares = squaresOfKept(image);
    const Image<std::int8_t> distances = distancesOf(image);
    for (const Tier tier : {Tier::base, Tier::closed, Tier::directional, Tier::guess})
        TierCutter(image, squares, distances, tier, tileSize).appendTo(set);
    return set;
}

WorldExtent boxAroundSamples(const TileBlock& block, double tolerance) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    WorldExtent box{glm::dvec3(kInfinity), glm::dvec3(-kInfinity)};
    for (const std::span<const Tile> tiles : {block.tiles, block.coarser})
        for (const Tile& tile : tiles) {
            const Camera camera = cameraAtLevel(block.camera, tile.level);
            for (const TileVertex& vertex : block.vertices.subspan(tile.firstVertex, tile.vertexCount)) {
                const VertexPlace place = placeOf(tile, vertex);
                const double disparity = static_cast<double>(disparityOf(tile, vertex));
                if (disparity <= 0) return {};
                const glm::dvec3 ray = rayThrough(camera, tile.x0 + static_cast<double>(place.x) + 0.5,
                                                  tile.y0 + static_cast<double>(place.y) + 0.5);
                for (const double share : {1 - tolerance, 1 + tolerance}) {
                    const glm::dvec3 p = block.worldFromCamera * (ray / (share * disparity));
                    box.least = glm::min(box.least, p), box.most = glm::max(box.most, p);
                }
            }
        }
    return box;
}

} // namespace scene
