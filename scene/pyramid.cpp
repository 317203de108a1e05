#include "scene/pyramid.h"

#include "scene/facets.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace scene {

namespace {

/// What comes first where four samples become one: 0 is best, kRanks - 1 worst.
constexpr int kRanks = 5;
int rankOf(std::uint8_t flags) {
    if ((flags & kRedundant) != 0) return 4;
    if (isGuess(flags)) return 3;
    if ((flags & kDirectional) != 0) return isClosed(flags) ? 3 : 2;
    return isClosed(flags) ? 1 : 0;
}

struct Child {
    float disparity = 0;
    std::uint8_t flags = 0;
    Rgb8 colour;
};

bool areAlike(float a, float b, float sameSurface) {
    return std::abs(a - b) <= sameSurface * std::max(a, b);
}

/// Of the children of the best rank the one that most of all agree with; of several the nearest.
const Child& mainOf(std::span<const Child> children, float sameSurface) {
    int best = kRanks;
    for (const Child& child : children)
        best = std::min(best, rankOf(child.flags));
    const Child* chosen = nullptr;
    int most = 0;
    for (const Child& child : children) {
        if (rankOf(child.flags) != best) continue;
        const auto votes = static_cast<int>(std::count_if(children.begin(), children.end(), [&](const Child& other) {
            return areAlike(child.disparity, other.disparity, sameSurface);
        }));
        if (votes > most || (votes == most && child.disparity > chosen->disparity)) chosen = &child, most = votes;
    }
    return *chosen;
}

/// Range was measured here, or right beside (isClosed).
bool isOfMeasured(std::uint8_t flags) {
    return isSurface(flags) && !isClosed(flags);
}

bool isSkinAbout(const DepthImage& fine, int x, int y) {
    for (int v = 2 * y; v <= 2 * y + 2; ++v)
        for (int u = 2 * x; u <= 2 * x + 2; ++u)
            if (u < fine.camera.width && v < fine.camera.height && (fine.flags(u, v) & (kSkinUpper | kSkinLower)) != 0)
                return true;
    return false;
}

} // namespace

Camera halve(const Camera& camera) {
    return {(camera.width + 1) / 2, (camera.height + 1) / 2, camera.fx / 2,
            camera.fy / 2,          camera.cx / 2,           camera.cy / 2};
}

Camera cameraAtLevel(const Camera& camera, int level) {
    Camera halved = camera;
    for (int i = 0; i < level; ++i)
        halved = halve(halved);
    return halved;
}

DepthImage halve(const DepthImage& fine, const PyramidOptions& options) {
    DepthImage coarse{fine.name, halve(fine.camera), fine.worldFromCamera, {}, {}, {}};
    const int width = coarse.camera.width, height = coarse.camera.height;
    coarse.colour = Image<Rgb8>(width, height);
    coarse.disparity = Image<float>(width, height, 0.0f);
    coarse.flags = Image<std::uint8_t>(width, height, kNoSurface);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            std::array<Child, 4> room;
            std::size_t count = 0;
            for (int v = 2 * y; v < std::min(2 * y + 2, fine.camera.height); ++v)
                for (int u = 2 * x; u < std::min(2 * x + 2, fine.camera.width); ++u)
                    if (isDrawable(fine.flags(u, v)))
                        room[count++] = {fine.disparity(u, v), fine.flags(u, v), fine.colour(u, v)};
            if (count == 0) continue;
            const std::span<const Child> children(room.data(), count);
            const Child& main = mainOf(children, options.sameSurface);
            double disparity = 0, r = 0, g = 0, b = 0;
            int alike = 0, measured = 0, others = 0; // the latter two of those that are kept
            for (const Child& child : children) {
                if (!areAlike(child.disparity, main.disparity, options.sameSurface)) continue;
                const int isKept = (child.flags & kRedundant) == 0 ? 1 : 0;
                // What is measured is not mixed with what is not.
                if (isOfMeasured(child.flags) != isOfMeasured(main.flags)) {
                    others += isKept;
                    continue;
                }
                measured += isKept;
                disparity += static_cast<double>(child.disparity);
                r += child.colour.r, g += child.colour.g, b += child.colour.b;
                ++alike;
            }
            const auto channel = [&](double sum) { return static_cast<std::uint8_t>(std::lround(sum / alike)); };
            coarse.disparity(x, y) = static_cast<float>(disparity / alike);
            coarse.colour(x, y) = {channel(r), channel(g), channel(b)};
            const bool isMostlyClosed = isOfMeasured(main.flags) && others > measured;
            coarse.flags(x, y) = static_cast<std::uint8_t>((main.flags & ~(kSkinUpper | kSkinLower)) |
                                                           (isMostlyClosed ? kInterpolated : 0));
        }

    const auto isBroken = [&](int ax, int ay, int bx, int by, int cx, int cy) {
        const float a = coarse.disparity(ax, ay), b = coarse.disparity(bx, by), c = coarse.disparity(cx, cy);
        return !areAlike(std::min(std::min(a, b), c), std::max(std::max(a, b), c), options.sameSurface);
    };
    for (int y = 0; y + 1 < height; ++y)
        for (int x = 0; x + 1 < width; ++x) {
            if (!isSkinAbout(fine, x, y)) continue;
            if (isBroken(x, y, x + 1, y, x, y + 1)) coarse.flags(x, y) |= kSkinUpper;
            if (isBroken(x + 1, y, x + 1, y + 1, x, y + 1)) coarse.flags(x, y) |= kSkinLower;
        }
    return coarse;
}

TileSet cutIntoLevels(const DepthImage& image, const PyramidOptions& options) {
    TileSet set = cutIntoTiles(image, options.tileSize);
    layFacets(set, options.facetTolerance, Squares::stay);
    DepthImage level;
    const DepthImage* finer = &image;
    for (int l = 1; l < kMaxLevels; ++l) {
        if (std::max(finer->camera.width, finer->camera.height) <= options.tileSize) break;
        level = halve(*finer, options);
        finer = &level;
        TileSet coarse = cutIntoTiles(level, options.tileSize);
        layFacets(coarse, options.facetTolerance, Squares::goWhereFacetsAre);
        appendLevel(set, coarse, l);
    }
    return set;
}

} // namespace scene
