#include "app/search_positions.h"

#include "app/progress.h"

#include "scene/capture/depth_view.h"
#include "scene/capture/spread_positions.h"

#include <algorithm>
#include <cstdio>

namespace app {

namespace {

constexpr int kSmallFace = 48;          ///< pixels of the images that the search looks at
constexpr std::size_t kTestPlaces = 64; ///< at which it is told how much is unknown
/// A position is worth it if it makes known this share of all that is seen from all places.
constexpr double kLeastGain = 2e-4;

/// Every so many, so that they stand all over the scene.
std::vector<glm::dvec3> someOf(const std::vector<glm::dvec3>& places, std::size_t count) {
    std::vector<glm::dvec3> some;
    const std::size_t step = std::max<std::size_t>(1, places.size() / count);
    for (std::size_t i = step / 2; i < places.size(); i += step)
        some.push_back(places[i]);
    return some;
}

} // namespace

std::vector<scene::PositionSearchStep> searchPositions(const scene::PolygonTracer& tracer, int count) {
    const std::vector<glm::dvec3> places = scene::standingPlaces(tracer);
    const auto capture = [&](const glm::dvec3& position) {
        return scene::traceDepthCube(tracer, position, kSmallFace);
    };
    scene::PositionSearchOptions options;
    options.count = std::min(count, static_cast<int>(places.size()));
    options.leastGain = kLeastGain;
    Progress progress("positions", static_cast<std::size_t>(options.count));
    std::vector<scene::PositionSearchStep> steps = scene::searchPositions(
        places, someOf(places, kTestPlaces), capture, options, [&](const auto&) { progress.advance(); });
    progress.advance(static_cast<std::size_t>(options.count) - steps.size());
    return steps;
}

} // namespace app
