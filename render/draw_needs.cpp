#include "render/draw_needs.h"

#include "render/draw_list.h"

#include <algorithm>

namespace render {

double marginOf(const Quality& quality, bool isStreamed) {
    if (isStreamed) return kWidestStandIn;
    const double ofPoints = 0.5 * quality.maxFootprint + 1.0;
    const double margin = quality.warp == Warp::mesh     ? (quality.drawsLone ? ofPoints : 1.0)
                          : quality.warp == Warp::splats ? quality.maxSplat + 1.0
                                                         : ofPoints;
    return quality.isBlended ? std::max(margin, static_cast<double>(quality.blend.maxRadius) + 1.0) : margin;
}

bool closesGaps(const Quality& quality) {
    const bool isOfSamples = quality.warp == Warp::points || quality.warp == Warp::splats;
    return isOfSamples && quality.holes.radius > 0;
}

std::vector<Warp> warpsFor(const Quality& quality, bool isStreamed) {
    std::vector<Warp> warps{quality.warp};
    if (quality.warp == Warp::adaptive || isStreamed)
        warps.insert(warps.end(), {Warp::points, Warp::mesh, Warp::adaptive});
    else if (quality.warp == Warp::mesh && quality.drawsLone)
        warps.push_back(Warp::points);
    else if (quality.warp != Warp::mesh && quality.drawsSquaresNear)
        warps.insert(warps.end(), {Warp::mesh, Warp::adaptive});
    return warps;
}

} // namespace render
