#include "scene/tile.h"

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
    if (isGuess(flags)) return Tier::guess;
    return (flags & kDirectional) != 0 ? Tier::directional : Tier::base;
}

/// Collects one tile: kept samples first, then the border its triangles need.
class TileCutter {
  public:
    TileCutter(const DepthImage& image, Tier tier, int x0, int y0, int width, int height)
        : image_(image), tier_(tier), x0_(x0), y0_(y0), width_(width), height_(height),
          vertexAt_((width + 1) * (height + 1), kNowhere) {}

    void appendTo(TileSet& set) {
        Tile tile;
        tile.x0 = x0_, tile.y0 = y0_;
        tile.width = static_cast<std::uint8_t>(width_), tile.height = static_cast<std::uint8_t>(height_);
        tile.tier = tier_;
        tile.firstVertex = static_cast<std::uint32_t>(set.vertices.size());
        tile.firstQuad = static_cast<std::uint32_t>(set.quads.size());

        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < width_; ++x)
                if (isKept(flagsAt(x, y)) && tierOf(flagsAt(x, y)) == tier_) take(x, y);
        tile.pointCount = static_cast<std::uint32_t>(taken_.size());

        for (int y = 0; y < height_; ++y)
            for (int x = 0; x < width_; ++x)
                appendQuad(x, y, set);
        tile.vertexCount = static_cast<std::uint32_t>(taken_.size());
        tile.quadCount = static_cast<std::uint32_t>(set.quads.size()) - tile.firstQuad;
        if (taken_.empty()) return;

        quantise(tile, set);
        set.tiles.push_back(tile);
    }

  private:
    struct Place {
        int x, y;
    };

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
        // A triangle between tiers is the base's, so that the base has no cracks of its own.
        const auto has = [&](Tier tier) {
            return (isKept(a) && tierOf(a) == tier) || (isKept(b) && tierOf(b) == tier) ||
                   (isKept(c) && tierOf(c) == tier);
        };
        if (isGuess(a) || isGuess(b) || isGuess(c))
            return tier_ == Tier::guess && (isKept(a) || isKept(b) || isKept(c));
        return tier_ == Tier::base ? has(Tier::base) : has(tier_) && !has(Tier::base);
    }

    void appendQuad(int x, int y, TileSet& set) {
        const std::uint8_t skins = flagsAt(x, y);
        const bool upper = (skins & kSkinUpper) == 0 && isDrawn(x, y, x + 1, y, x, y + 1);
        const bool lower = (skins & kSkinLower) == 0 && isDrawn(x + 1, y, x + 1, y + 1, x, y + 1);
        if (!upper && !lower) return;
        const std::uint32_t i10 = take(x + 1, y), i01 = take(x, y + 1);
        const std::uint32_t i00 = upper ? take(x, y) : 0, i11 = lower ? take(x + 1, y + 1) : 0;
        set.quads.push_back({i00 | i10 << 16 | (upper ? kDrawUpper : 0), i01 | i11 << 16 | (lower ? kDrawLower : 0)});
    }

    void quantise(Tile& tile, TileSet& set) const {
        tile.minDisparity = std::numeric_limits<float>::max();
        tile.maxDisparity = 0;
        for (const Place& place : taken_) {
            const float disparity = image_.disparity(x0_ + place.x, y0_ + place.y);
            assert(std::isfinite(disparity) && disparity >= 0);
            tile.minDisparity = std::min(tile.minDisparity, disparity);
            tile.maxDisparity = std::max(tile.maxDisparity, disparity);
        }
        const double range = static_cast<double>(tile.maxDisparity) - tile.minDisparity;
        const double scale = range > 0 ? kMaxQuantisedDisparity / range : 0.0;
        for (const Place& place : taken_) {
            const int x = x0_ + place.x, y = y0_ + place.y;
            const double above = static_cast<double>(image_.disparity(x, y)) - tile.minDisparity;
            const auto q = std::min(static_cast<std::uint32_t>(std::lround(above * scale)), kMaxQuantisedDisparity);
            const Rgb8 c = image_.colour(x, y);
            set.vertices.push_back(
                {static_cast<std::uint32_t>(place.x) | static_cast<std::uint32_t>(place.y) << 6 | q << 12,
                 c.r | static_cast<std::uint32_t>(c.g) << 8 | static_cast<std::uint32_t>(c.b) << 16 |
                     static_cast<std::uint32_t>(image_.flags(x, y)) << 24});
        }
    }

    const DepthImage& image_;
    Tier tier_;
    int x0_, y0_, width_, height_;
    std::vector<std::uint32_t> vertexAt_;
    std::vector<Place> taken_;
};

} // namespace

TileSet cutIntoTiles(const DepthImage& image, int tileSize) {
    assert(tileSize >= 1 && tileSize <= kMaxTileSize);
    TileSet set;
    for (const Tier tier : {Tier::base, Tier::directional, Tier::guess})
        for (int y0 = 0; y0 < image.camera.height; y0 += tileSize)
            for (int x0 = 0; x0 < image.camera.width; x0 += tileSize)
                TileCutter(image, tier, x0, y0, std::min(tileSize, image.camera.width - x0),
                           std::min(tileSize, image.camera.height - y0))
                    .appendTo(set);
    return set;
}

} // namespace scene
