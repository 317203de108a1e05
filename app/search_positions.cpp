#include "app/search_positions.h"

#include "app/progress.h"

#include "scene/capture/depth_view.h"
#include "scene/capture/spread_positions.h"
#include "scene/plan/position_search.h"
#include "scene/plan/sight_search.h"

#include <algorithm>

namespace app {

namespace {

constexpr int kSmallFace = 48;          ///< pixels of the images that tell how much is unknown
constexpr std::size_t kTestPlaces = 64; ///< at which it is told
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

SearchedPositions searchPositions(const scene::PolygonTracer& tracer, int count) {
    const std::vector<glm::dvec3> places = scene::standingPlaces(tracer);
    scene::SightSearchOptions options;
    options.count = std::min(count, static_cast<int>(places.size()));
    options.leastGain = kLeastGain;
    Progress progress("positions", static_cast<std::size_t>(options.count));
    const scene::SightSearchResult found =
        scene::searchBySight(places, scene::sightLinesOf(tracer), options, [&] { progress.advance(); });
    progress.advance(static_cast<std::size_t>(options.count) - found.positions.size());

    SearchedPositions searched{found.positions, {}, found.trials};
    const auto capture = [&](const glm::dvec3& position) {
        return scene::traceDepthCube(tracer, position, kSmallFace);
    };
    const std::vector<glm::dvec3> tests = someOf(places, kTestPlaces);
    for (std::size_t first = 1; first <= found.positions.size(); ++first)
        searched.unknownShares.push_back(
            scene::unknownShareOf(std::span(found.positions).first(first), tests, capture));
    return searched;
}

} // namespace app
