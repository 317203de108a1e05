#include "scene/refine/redundancy.h"

#include "scene/density.h"
#include "scene/refine/crossing.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <span>

#include <glm/geometric.hpp>

#include <tbb/parallel_for.h>

namespace scene {

namespace {

struct RankedTile {
    std::uint32_t image = 0;
    int x0 = 0, y0 = 0;
    float quality = 0;    ///< samples per metre of surface, mean over the tile
    int qualityClass = 0; ///< tiles of one class are of like quality; higher ones are better
};

std::vector<RankedTile> rateTiles(const DepthImage& image, std::uint32_t index, int tileSize) {
    const Image<float> density = computeDensity(image);
    std::vector<RankedTile> tiles;
    for (int y0 = 0; y0 < image.camera.height; y0 += tileSize)
        for (int x0 = 0; x0 < image.camera.width; x0 += tileSize) {
            double sum = 0;
            int samples = 0, guesses = 0, doubtful = 0;
            for (int y = y0; y < std::min(y0 + tileSize, image.camera.height); ++y)
                for (int x = x0; x < std::min(x0 + tileSize, image.camera.width); ++x) {
                    const std::uint8_t flags = image.flags(x, y);
                    guesses += isGuess(flags);
                    if (!isSurface(flags)) continue;
                    ++samples;
                    doubtful += (flags & (kSkinUpper | kSkinLower | kInterpolated | kNoColour)) != 0;
                    sum += std::sqrt(static_cast<double>(density(x, y)));
                }
            if (samples + guesses == 0) continue;
            const int count = std::max(samples, 1);
            const double trust = 1.0 - 0.5 * doubtful / count;
            tiles.push_back({index, x0, y0, static_cast<float>(sum / count * trust), 0});
        }
    return tiles;
}

/// Images in the order in which they are preferred where tiles are of like quality: those that share most with others
/// first, so that few images keep most of the scene in large pieces.
std::vector<std::uint32_t> rankImages(const std::vector<std::vector<Partner>>& partners) {
    std::vector<float> shared(partners.size(), 0.f);
    for (std::size_t i = 0; i < partners.size(); ++i)
        for (const Partner& partner : partners[i])
            shared[i] += partner.share;
    std::vector<std::uint32_t> order(partners.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return shared[a] > shared[b]; });
    std::vector<std::uint32_t> rankOf(partners.size());
    for (std::uint32_t rank = 0; rank < order.size(); ++rank)
        rankOf[order[rank]] = rank;
    return rankOf;
}

/// Samples of a partner that are kept already, and the way there.
struct KeptPartner {
    std::uint32_t number; ///< in the store
    const KeepMap* kept;
    const Camera* camera;
    const DepthImage* image; ///< null while it is not borrowed
    Reprojection into;
    float baseline; ///< metres between the two cameras
};

/// A tile that is being examined: which of the partners may cover samples of it, which samples are covered, and what
/// of them is kept that was not before; row by row.
struct Examined {
    PixelBox pixels;
    std::vector<std::uint32_t> partners;
    std::vector<std::uint8_t> isCovered;
    std::vector<Keep> anew;
};

constexpr float kAnywhere = std::numeric_limits<float>::max();

/// A sample in its own camera: place in the image, and disparity.
struct RivalSample {
    float x, y, disparity;
    float farthest; ///< metres: who stands farther away than that does not cover it
    bool isGuess;
};

/// Whether the partner keeps this piece of surface and stands near enough.
bool isCovered(const KeptPartner& partner, const RivalSample& sample, const ComparisonOptions& options) {
    if (partner.baseline > sample.farthest) return false;
    const Sighting at = sightingOf(partner.into, sample.x, sample.y, sample.disparity);
    if (!isSeenIn(*partner.camera, at)) return false;
    const int x = static_cast<int>(at.u), y = static_cast<int>(at.v);
    if (!partner.kept->has(x, y)) return false;
    // A guess covers a guess; it never takes the place of what was measured.
    if (isGuess(partner.image->flags(x, y)))
        return sample.isGuess &&
               std::abs(partner.image->disparity(x, y) - at.disparity) <= 2 * options.sameSurface * at.disparity;
    const Comparison comparison = compareWith(*partner.image, at, options);
    if (comparison.relation != Relation::agrees) return false;
    // Of something thin each side is a surface of its own.
    return !comparison.isSmooth ||
           !crossingOf(*partner.image, partner.into, sample.x, sample.y, sample.disparity, at, options.sameSurface)
                .isFromBehind();
}

/// Gives each sample of an image that nobody before it covers to the tier; ranked[first, last) are its tiles.
class Keeper {
  public:
    Keeper(ImageStore& images, const std::vector<std::vector<Partner>>& partners, const RedundancyOptions& options)
        : images_(images), partners_(partners), options_(options), hasKept_(images.size(), 0) {
        for (std::size_t i = 0; i < images.size(); ++i)
            kept_.emplace_back(images.at(i).camera.width, images.at(i).camera.height);
    }

    /// baselineShare: of a sample's range; who stands farther away does not cover it.
    std::int64_t keep(std::span<const RankedTile> tiles, Keep tier, float baselineShare) {
        const std::uint32_t self = tiles.front().image;
        const ImageStore::Lease image = images_.borrow(self);
        std::vector<KeptPartner> before = keptBefore(self);
        std::vector<Examined> examined(tiles.size());
        std::vector<std::atomic<bool>> isAsked(before.size());
        tbb::parallel_for(std::size_t{0}, tiles.size(), [&](std::size_t t) {
            examined[t] = examine(tiles[t], *image, before, baselineShare);
            for (const std::uint32_t p : examined[t].partners)
                isAsked[p] = true;
        });
        std::vector<std::uint32_t> asked;
        for (std::uint32_t p = 0; p < before.size(); ++p)
            if (isAsked[p]) asked.push_back(p);
        // What is here may be gone when others have been read.
        std::stable_partition(asked.begin(), asked.end(),
                              [&](std::uint32_t p) { return images_.isResident(before[p].number); });
        forGroups(asked, before, bytesOf(image->camera), [&] {
            tbb::parallel_for(std::size_t{0}, tiles.size(), [&](std::size_t t) {
                cover(examined[t], *image, kept_[self], before, tier, baselineShare);
            });
        });
        std::atomic<std::int64_t> count = 0;
        tbb::parallel_for(std::size_t{0}, tiles.size(),
                          [&](std::size_t t) { count += keepTile(examined[t], *image, kept_[self], tier); });
        // One after the other: tiles may share a word of the map.
        for (const Examined& tile : examined) {
            std::size_t at = 0;
            forSamples(tile.pixels, [&](int x, int y) {
                if (const Keep keep = tile.anew[at++]; keep != Keep::no) kept_[self].set(x, y, keep);
            });
        }
        hasKept_[self] = 1;
        return count;
    }

    const KeepMap& keptOf(std::size_t image) const { return kept_[image]; }
    std::vector<KeepMap> take() { return std::move(kept_); }

  private:
    PixelBox pixelsOf(const RankedTile& tile, const DepthImage& image) const {
        return {tile.x0, tile.y0, std::min(tile.x0 + options_.tileSize, image.camera.width),
                std::min(tile.y0 + options_.tileSize, image.camera.height)};
    }

    template <class Visit>
    static void forSamples(const PixelBox& pixels, Visit visit) {
        for (int y = pixels.y0; y < pixels.y1; ++y)
            for (int x = pixels.x0; x < pixels.x1; ++x)
                visit(x, y);
    }

    /// Metres; who stands farther away does not cover the sample.
    static float farthestCoverOf(const DepthImage& image, int x, int y, float baselineShare) {
        if (baselineShare == kAnywhere) return kAnywhere;
        const glm::vec3 ray(rayThrough(image.camera, x + 0.5, y + 0.5));
        return baselineShare * (glm::length(ray) / image.disparity(x, y));
    }

    /// The image's partners that keep anything; not borrowed.
    std::vector<KeptPartner> keptBefore(std::uint32_t self) const {
        const StoredImage& image = images_.at(self);
        std::vector<KeptPartner> before;
        for (const Partner& partner : partners_[self]) {
            if (!hasKept_[partner.image]) continue;
            const StoredImage& other = images_.at(partner.image);
            before.push_back(
                {partner.image, &kept_[partner.image], &other.camera, nullptr,
                 reprojectionInto(other.camera, other.worldFromCamera, image.camera, image.worldFromCamera),
                 static_cast<float>(
                     glm::distance(image.worldFromCamera.translation, other.worldFromCamera.translation))});
        }
        return before;
    }

    /// Borrows as many of those that are asked as memory allows beside the image itself, one at least, and calls visit;
    /// until all have been there.
    template <class Visit>
    void forGroups(std::span<const std::uint32_t> asked, std::vector<KeptPartner>& before, std::size_t ownBytes,
                   const Visit& visit) {
        while (!asked.empty()) {
            std::size_t count = 0;
            for (std::size_t bytes = ownBytes; count < asked.size(); ++count) {
                bytes += bytesOf(*before[asked[count]].camera);
                if (count > 0 && bytes > images_.budgetBytes()) break;
            }
            const std::span<const std::uint32_t> group = asked.first(count);
            std::vector<std::optional<ImageStore::Lease>> leases(count);
            // What is here is taken first, or reading another might let it go.
            for (std::size_t i = 0; i < count; ++i)
                if (images_.isResident(before[group[i]].number))
                    leases[i].emplace(images_.borrow(before[group[i]].number));
            tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
                if (!leases[i]) leases[i].emplace(images_.borrow(before[group[i]].number));
            });
            for (std::size_t i = 0; i < count; ++i)
                before[group[i]].image = &**leases[i];
            visit();
            for (const std::uint32_t p : group)
                before[p].image = nullptr;
            asked = asked.subspan(count);
        }
    }

    /// Which partners can cover a sample of the tile at all.
    Examined examine(const RankedTile& tile, const DepthImage& image, const std::vector<KeptPartner>& before,
                     float baselineShare) const {
        Examined examined{pixelsOf(tile, image), {}, {}, {}};
        float lowest = std::numeric_limits<float>::max(), highest = 0, farthest = 0;
        forSamples(examined.pixels, [&](int x, int y) {
            if (!isDrawable(image.flags(x, y))) return;
            lowest = std::min(lowest, image.disparity(x, y));
            highest = std::max(highest, image.disparity(x, y));
            farthest = std::max(farthest, farthestCoverOf(image, x, y, baselineShare));
        });
        for (std::uint32_t p = 0; p < before.size(); ++p)
            if (before[p].baseline <= farthest &&
                before[p].kept->mayHaveAnyIn(
                    boundsOfSightings(before[p].into, examined.pixels, lowest, highest, *before[p].camera)))
                examined.partners.push_back(p);
        const PixelBox& pixels = examined.pixels;
        examined.isCovered.assign(
            static_cast<std::size_t>(pixels.x1 - pixels.x0) * static_cast<std::size_t>(pixels.y1 - pixels.y0), 0);
        return examined;
    }

    static bool isExamined(std::uint8_t flags, Keep tier) {
        return isGuess(flags) ? tier != Keep::base : isSurface(flags);
    }

    /// Notes which samples those of the partners that are borrowed cover.
    void cover(Examined& tile, const DepthImage& image, const KeepMap& mine, const std::vector<KeptPartner>& before,
               Keep tier, float baselineShare) const {
        std::vector<const KeptPartner*> here;
        for (const std::uint32_t p : tile.partners)
            if (before[p].image) here.push_back(&before[p]);
        if (here.empty()) return;
        std::size_t at = 0, likely = 0; // the partner that covered the last sample most likely covers the next
        forSamples(tile.pixels, [&](int x, int y) {
            std::uint8_t& isCoveredHere = tile.isCovered[at++];
            if (isCoveredHere != 0 || !isExamined(image.flags(x, y), tier) || mine(x, y) != Keep::no) return;
            const RivalSample sample{static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, image.disparity(x, y),
                                     farthestCoverOf(image, x, y, baselineShare), isGuess(image.flags(x, y))};
            const auto covers = [&](std::size_t p) { return isCovered(*here[p], sample, options_.comparison); };
            bool covered = covers(likely);
            for (std::size_t p = 0; p < here.size() && !covered; ++p)
                if (covers(p)) covered = true, likely = p;
            if (covered) isCoveredHere = 1;
        });
    }

    std::int64_t keepTile(Examined& tile, const DepthImage& image, const KeepMap& kept, Keep tier) const {
        tile.anew.assign(tile.isCovered.size(), Keep::no);
        std::int64_t count = 0, wanted = 0, there = 0;
        std::size_t at = 0;
        forSamples(tile.pixels, [&](int x, int y) {
            const std::size_t i = at++;
            if (!isExamined(image.flags(x, y), tier)) return;
            ++there;
            if (tile.isCovered[i] != 0 || kept(x, y) != Keep::no) return;
            tile.anew[i] = tier;
            ++wanted;
            count += !isGuess(image.flags(x, y));
        });
        // The base holds every surface, be the patch ever so small.
        if (tier != Keep::directional) return count;
        const bool isPatch =
            wanted > 0 && static_cast<float>(wanted) >= options_.minPatchShare * static_cast<float>(there);
        count = 0, at = 0;
        forSamples(tile.pixels, [&](int x, int y) {
            Keep& mine = tile.anew[at++];
            const std::uint8_t flags = image.flags(x, y);
            if (kept(x, y) == Keep::base || !isDrawable(flags)) return;
            // A guess is no surface: only where nobody measured is it kept.
            if (!isPatch || !isGuess(flags)) mine = isPatch ? Keep::directional : Keep::no;
            count += isPatch && !isGuess(flags);
        });
        return count;
    }

    ImageStore& images_;
    const std::vector<std::vector<Partner>>& partners_;
    const RedundancyOptions& options_;
    std::vector<KeepMap> kept_;
    std::vector<std::uint8_t> hasKept_;
};

/// Calls visit with each run of tiles for which sameRun holds: tiles of one image do not judge each other, so a run of
/// them is examined at the same time.
template <class SameRun, class Visit>
void forRuns(const std::vector<RankedTile>& tiles, SameRun sameRun, Visit visit) {
    for (std::size_t first = 0, last = 0; first < tiles.size(); first = last) {
        for (last = first + 1; last < tiles.size() && sameRun(tiles[first], tiles[last]);)
            ++last;
        visit(std::span(tiles).subspan(first, last - first));
    }
}

} // namespace

KeepMap::KeepMap(int width, int height, Keep all)
    : width_(width), height_(height), squares_((width + kSquare - 1) / kSquare, (height + kSquare - 1) / kSquare) {
    if (all == Keep::no) return;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            set(x, y, all);
}

void KeepMap::set(int x, int y, Keep keep) {
    Square& square = squares_(x / kSquare, y / kSquare);
    const std::uint64_t bit = bitOf(x, y);
    square.any = keep != Keep::no ? square.any | bit : square.any & ~bit;
    square.directional = keep == Keep::directional ? square.directional | bit : square.directional & ~bit;
}

bool KeepMap::mayHaveAnyIn(const PixelBox& pixels) const {
    if (pixels.isEmpty()) return false;
    for (int y = pixels.y0 / kSquare; y <= (pixels.y1 - 1) / kSquare; ++y)
        for (int x = pixels.x0 / kSquare; x <= (pixels.x1 - 1) / kSquare; ++x)
            if (squares_(x, y).any != 0) return true;
    return false;
}

Image<Keep> KeepMap::whole() const {
    Image<Keep> keeps(width_, height_);
    for (int y = 0; y < height_; ++y)
        for (int x = 0; x < width_; ++x)
            keeps(x, y) = (*this)(x, y);
    return keeps;
}

std::vector<KeepMap> findKept(ImageStore& images, const std::vector<std::vector<Partner>>& partners,
                              const RedundancyOptions& options, RedundancyFigures& figures,
                              const std::function<void()>& advance) {
    std::vector<std::vector<RankedTile>> tilesOf(images.size());
    visitEach(images, 2, [&](std::size_t i) { // the image and its density
        tilesOf[i] = rateTiles(*images.borrow(i), static_cast<std::uint32_t>(i), options.tileSize);
    });
    std::vector<RankedTile> ranked;
    for (const auto& tiles : tilesOf)
        ranked.insert(ranked.end(), tiles.begin(), tiles.end());

    const std::vector<std::uint32_t> imageRank = rankImages(partners);
    const double step = std::log(std::max(static_cast<double>(options.preference), 1.001));
    for (RankedTile& tile : ranked) // the sky has no density: it comes last
        tile.qualityClass = tile.quality > 0 ? static_cast<int>(std::floor(std::log(tile.quality) / step))
                                             : std::numeric_limits<int>::min();
    std::stable_sort(ranked.begin(), ranked.end(), [&](const RankedTile& a, const RankedTile& b) {
        return a.qualityClass != b.qualityClass ? a.qualityClass > b.qualityClass
                                                : imageRank[a.image] < imageRank[b.image];
    });

    figures = {};
    Keeper keeper(images, partners, options);
    const bool isDirectional = options.baselineShare > 0;
    std::size_t done = 0, advanced = 0; // tiles, and in how many steps they were told
    const auto tell = [&](std::size_t tiles) {
        done += tiles;
        const std::size_t all = std::max<std::size_t>((isDirectional ? 2 : 1) * ranked.size(), 1);
        for (; advanced < images.size() * done / all; ++advanced)
            if (advance) advance();
    };
    forRuns(
        ranked,
        [&](const RankedTile& a, const RankedTile& b) {
            return a.image == b.image && a.qualityClass == b.qualityClass;
        },
        [&](std::span<const RankedTile> run) {
            figures.base += keeper.keep(run, Keep::base, kAnywhere);
            tell(run.size());
        });
    if (isDirectional) {
        // In the order of the capture: along a path this spaces the kept images evenly.
        for (const auto& tiles : tilesOf) {
            if (!tiles.empty()) figures.directional += keeper.keep(tiles, Keep::directional, options.baselineShare);
            tell(tiles.size());
        }
    }
    for (; advanced < images.size(); ++advanced)
        if (advance) advance();
    for (std::size_t i = 0; i < images.size(); ++i) {
        const ImageStore::Lease image = images.borrow(i);
        const auto flags = image->flags.pixels();
        figures.samples += std::count_if(flags.begin(), flags.end(), isSurface);
        for (int y = 0; y < image->camera.height; ++y)
            for (int x = 0; x < image->camera.width; ++x)
                figures.guesses += isGuess(image->flags(x, y)) && keeper.keptOf(i).has(x, y);
    }
    return keeper.take();
}

} // namespace scene
