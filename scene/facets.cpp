#include "scene/facets.h"

#include <algorithm>
#include <cmath>

namespace scene {

namespace {

/// A facet must stand for at least so many squares on average: below, the squares themselves are as fast.
constexpr std::uint32_t kLeastSquaresPerFacet = 3;

constexpr int kLargestLog2 = 5;

/// The squares of one tile on their grid.
class Squared {
  public:
    Squared(const TileSet& set, const Tile& tile)
        : width_(tile.width), height_(tile.height), stride_(tile.width + 1),
          quantised_(static_cast<std::size_t>(stride_) * (height_ + 1)), halves_(quantised_.size()),
          leastDisparity_(static_cast<double>(tile.minDisparity)) {
        const double range = static_cast<double>(tile.maxDisparity) - leastDisparity_;
        step_ = range / maxQuantisedOf(tile);
        const auto placed = [&](std::uint32_t index) {
            return placeOf(tile, set.vertices[tile.firstVertex + (index & kQuadIndexMask)]);
        };
        for (std::uint32_t i = 0; i < tile.vertexCount; ++i) {
            const VertexPlace p = placed(i);
            quantised_[at(static_cast<int>(p.x), static_cast<int>(p.y))] = p.q;
        }
        for (std::uint32_t i = tile.firstQuad; i < tile.firstQuad + tile.quadCount; ++i) {
            const TileQuad& quad = set.quads[i];
            // The diagonal is there whichever half is drawn: its top end stands one to the right of the square's place.
            const VertexPlace diagonal = placed(quad.top >> 16);
            std::uint8_t& halves = halves_[at(static_cast<int>(diagonal.x) - 1, static_cast<int>(diagonal.y))];
            if ((quad.top & kDrawUpper) != 0) halves |= 1;
            if ((quad.bottom & kDrawLower) != 0) halves |= 2;
        }
    }

    std::vector<TileFacet> facets(float tolerance) {
        tolerance_ = static_cast<double>(tolerance);
        const int side = 1 << kLargestLog2;
        for (int y = 0; y < height_; y += side)
            for (int x = 0; x < width_; x += side)
                divide(x, y, kLargestLog2);
        // Those that are drawn side by side should take alike long.
        std::stable_sort(facets_.begin(), facets_.end(),
                         [](const TileFacet& a, const TileFacet& b) { return log2SideOf(a) > log2SideOf(b); });
        return std::move(facets_);
    }

  private:
    std::size_t at(int x, int y) const { return static_cast<std::size_t>(y) * stride_ + x; }
    bool isInside(int x, int y) const { return x < width_ && y < height_; }
    double q(int x, int y) const { return quantised_[at(x, y)]; }

    void divide(int x, int y, int log2Side) {
        if (!isInside(x, y)) return;
        if (log2Side == 0) {
            single(x, y);
            return;
        }
        const int side = 1 << log2Side;
        if (isWhole(x, y, side)) {
            TileFacet facet = fit(x, y, side);
            if (isFlat(facet, x, y, side)) {
                append(facet, x, y, log2Side, 3);
                return;
            }
        }
        const int half = side / 2;
        for (const int v : {y, y + half})
            for (const int u : {x, x + half})
                divide(u, v, log2Side - 1);
    }

    void single(int x, int y) {
        const std::uint8_t halves = halves_[at(x, y)];
        if (halves == 0) return;
        if (halves == 3) {
            TileFacet facet = fit(x, y, 1);
            if (isFlat(facet, x, y, 1)) {
                append(facet, x, y, 0, 3);
                return;
            }
        }
        if ((halves & 1) != 0) {
            TileFacet facet;
            facet.q = static_cast<float>(q(x, y));
            facet.perX = static_cast<float>(q(x + 1, y) - q(x, y));
            facet.perY = static_cast<float>(q(x, y + 1) - q(x, y));
            append(facet, x, y, 0, 1);
        }
        if ((halves & 2) != 0) {
            TileFacet facet;
            facet.perX = static_cast<float>(q(x + 1, y + 1) - q(x, y + 1));
            facet.perY = static_cast<float>(q(x + 1, y + 1) - q(x + 1, y));
            facet.q = static_cast<float>(q(x, y + 1) + q(x + 1, y) - q(x + 1, y + 1));
            append(facet, x, y, 0, 2);
        }
    }

    void append(TileFacet facet, int x, int y, int log2Side, std::uint32_t halves) {
        facet.mark = static_cast<std::uint32_t>(x) | static_cast<std::uint32_t>(y) << 6 |
                     static_cast<std::uint32_t>(log2Side) << 12 | ((halves & 1) != 0 ? kFacetUpper : 0) |
                     ((halves & 2) != 0 ? kFacetLower : 0);
        facets_.push_back(facet);
    }

    bool isWhole(int x, int y, int side) const {
        if (x + side > width_ || y + side > height_) return false;
        for (int v = y; v < y + side; ++v)
            for (int u = x; u < x + side; ++u)
                if (halves_[at(u, v)] != 3) return false;
        return true;
    }

    /// Least squares; on a full grid the slopes are independent of one another.
    TileFacet fit(int x, int y, int side) const {
        const int count = side + 1;
        const double middle = side / 2.0;
        double sum = 0, alongX = 0, alongY = 0, spread = 0;
        for (int j = 0; j < count; ++j)
            for (int i = 0; i < count; ++i) {
                const double value = q(x + i, y + j);
                sum += value, alongX += (i - middle) * value, alongY += (j - middle) * value;
                spread += (i - middle) * (i - middle);
            }
        const double perX = alongX / spread, perY = alongY / spread;
        TileFacet facet;
        facet.perX = static_cast<float>(perX), facet.perY = static_cast<float>(perY);
        facet.q = static_cast<float>(sum / (count * count) - middle * (perX + perY));
        return facet;
    }

    bool isFlat(const TileFacet& facet, int x, int y, int side) const {
        for (int j = 0; j <= side; ++j)
            for (int i = 0; i <= side; ++i) {
                const double value = q(x + i, y + j);
                const double plane = static_cast<double>(facet.q) + i * static_cast<double>(facet.perX) +
                                     j * static_cast<double>(facet.perY);
                // Disparity is never negative: what is infinitely far stays so.
                if (leastDisparity_ + plane * step_ < 0) return false;
                if (std::abs(plane - value) * step_ > tolerance_ * (leastDisparity_ + value * step_)) return false;
            }
        return true;
    }

    int width_, height_, stride_;
    std::vector<std::uint32_t> quantised_;
    std::vector<std::uint8_t> halves_; ///< by square: 1 upper, 2 lower
    double leastDisparity_, step_ = 0, tolerance_ = 0;
    std::vector<TileFacet> facets_;
};

void appendTexels(const Tile& tile, TileSet& set) {
    const std::size_t stride = tile.width + 1u, first = set.texels.size();
    set.texels.resize(first + texelCountOf(tile));
    for (std::uint32_t i = tile.firstVertex; i < tile.firstVertex + tile.vertexCount; ++i) {
        const VertexPlace p = placeOf(tile, set.vertices[i]);
        const std::uint32_t colour = set.vertices[i].colour & 0xffffffu;
        const std::size_t at = first + p.y * stride + p.x;
        set.texels[at].here = colour;
        if (p.x > 0) set.texels[at - 1].right = colour;
    }
}

} // namespace

void layFacets(TileSet& set, float tolerance, Squares squares) {
    std::vector<TileQuad> kept;
    for (Tile& tile : set.tiles) {
        std::vector<TileFacet> facets;
        if (tile.placeBits == kPlaceBits && tile.quadCount > 0) facets = Squared(set, tile).facets(tolerance);
        if (facets.size() * kLeastSquaresPerFacet > tile.quadCount) facets.clear();
        if (!facets.empty()) {
            tile.firstFacet = static_cast<std::uint32_t>(set.facets.size());
            tile.facetCount = static_cast<std::uint32_t>(facets.size());
            tile.firstTexel = static_cast<std::uint32_t>(set.texels.size());
            set.facets.insert(set.facets.end(), facets.begin(), facets.end());
            appendTexels(tile, set);
        }
        const auto begin = set.quads.begin() + tile.firstQuad, end = begin + tile.quadCount;
        tile.firstQuad = static_cast<std::uint32_t>(kept.size());
        if (squares == Squares::goWhereFacetsAre && tile.facetCount > 0)
            tile.quadCount = 0;
        else
            kept.insert(kept.end(), begin, end);
    }
    set.quads = std::move(kept);
}

void appendLevel(TileSet& set, const TileSet& coarse, int level) {
    for (Tile tile : coarse.tiles) {
        tile.level = static_cast<std::uint8_t>(level);
        tile.firstVertex += static_cast<std::uint32_t>(set.vertices.size());
        tile.firstQuad += static_cast<std::uint32_t>(set.quads.size());
        tile.firstFacet += tile.facetCount > 0 ? static_cast<std::uint32_t>(set.facets.size()) : 0;
        tile.firstTexel += tile.facetCount > 0 ? static_cast<std::uint32_t>(set.texels.size()) : 0;
        set.coarser.push_back(tile);
    }
    set.vertices.insert(set.vertices.end(), coarse.vertices.begin(), coarse.vertices.end());
    set.quads.insert(set.quads.end(), coarse.quads.begin(), coarse.quads.end());
    set.facets.insert(set.facets.end(), coarse.facets.begin(), coarse.facets.end());
    set.texels.insert(set.texels.end(), coarse.texels.begin(), coarse.texels.end());
}

} // namespace scene
