#pragma once
// Redundancy: each piece of surface is kept by the image that samples it best (Nyland et al. 1999, section 4.6).
//
// Tiles are ranked by quality: samples per square metre of surface (range and obliqueness in one number), less what is
// skin or missing. The paper goes from the worst tile to the best and drops samples that a better image has too; we go
// from the best to the worst and drop samples that a tile already kept has too. Where agreement between images is
// transitive both keep the same. Where it is not, in ours every dropped sample has a kept one that agrees with it, so
// no hole opens.

#include "scene/image_store.h"
#include "scene/overlap.h"
#include "scene/reprojection.h"
#include "scene/tile.h"

#include <functional>

namespace scene {

struct RedundancyOptions {
    /// How much better sampled (in samples per metre) a tile must be to be preferred to one of an image ranked before
    /// its own. 1: sampling alone decides and the patches are small; large: whole images are kept, the fewest samples
    /// and seams.
    float preference = 1.5f;
    /// A surface is kept again, as a directional sample, where no kept sample shows it from nearby: from a camera no
    /// farther away than this share of the range (so the directions differ by at most as many radians). 0: never.
    float baselineShare = 0.07f;
    /// A tile of whose surfaces at least this share is wanted as directional samples keeps all of them, else none:
    /// patches with holes cost more to draw than they spare, and cannot become facets. The base has their surface, too.
    float minPatchShare = 0.25f;
    int tileSize = kDefaultTileSize;
    ComparisonOptions comparison;
};

struct RedundancyFigures {
    std::int64_t samples = 0, base = 0, directional = 0; ///< all surfaces, and what is kept of them
    std::int64_t guesses = 0;                            ///< kept, not counted above
};

/// What is kept of a sample's surface.
enum class Keep : std::uint8_t { no = 0, base = 1, directional = 2 };

/// What is kept of an image's samples, in a quarter of a byte each: of all images it is held at once. In squares, so
/// that what a tile of another image sees lies close together in memory.
class KeepMap {
  public:
    KeepMap(int width, int height, Keep all = Keep::no);
    Keep operator()(int x, int y) const {
        const Square& square = squares_(x / kSquare, y / kSquare);
        const std::uint64_t bit = bitOf(x, y);
        if ((square.any & bit) == 0) return Keep::no;
        return (square.directional & bit) != 0 ? Keep::directional : Keep::base;
    }
    bool has(int x, int y) const { return (squares_(x / kSquare, y / kSquare).any & bitOf(x, y)) != 0; }
    bool mayHaveAnyIn(const PixelBox& pixels) const; ///< by whole squares
    void set(int x, int y, Keep keep);
    Image<Keep> whole() const;
    friend bool operator==(const KeepMap&, const KeepMap&) = default;

  private:
    struct Square {
        std::uint64_t any = 0, directional = 0;
        friend bool operator==(const Square&, const Square&) = default;
    };
    static constexpr int kSquare = 8;
    static std::uint64_t bitOf(int x, int y) { return std::uint64_t{1} << (y % kSquare * kSquare + x % kSquare); }

    int width_, height_;
    Image<Square> squares_;
};

/// Which samples of each image are kept. The images' flags must have skins and floating samples marked already.
/// advance is called once for each image, as time goes by. While images are compared no more are held than the store's
/// budget allows, two at least.
std::vector<KeepMap> findKept(ImageStore& images, const std::vector<std::vector<Partner>>& partners,
                              const RedundancyOptions& options, RedundancyFigures& figures,
                              const std::function<void()>& advance = {});

} // namespace scene
