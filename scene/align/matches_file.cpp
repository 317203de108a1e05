#include "scene/align/matches_file.h"

#include "scene/errors.h"
#include "scene/json_file.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <glm/geometric.hpp>

namespace scene {

namespace {

using nlohmann::json;

constexpr double kOnPlaneMetres = 0.1; ///< a place that was picked by hand is so near to its plane
constexpr int kAboutCells = 3;
constexpr double kLeastMatchedAgreeing = 0.03; ///< of what either saw, with planes that a person matched
constexpr const char* kForm =
    R"(write {"matches": [{"a": "NAME", "b": "NAME", "planes": [{"a": [x, y, z], "b": [x, y, z]}, ...]}]})";

glm::dvec3 placeOf(const json& numbers) {
    return {numbers.at(0).get<double>(), numbers.at(1).get<double>(), numbers.at(2).get<double>()};
}

/// The plane that lies nearest to a place, of those seen about there.
std::optional<std::size_t> planeAt(const ScanView& view, const glm::dvec3& place) {
    const auto cell = view.panorama.placeOf(place);
    if (!cell) return std::nullopt;
    std::optional<std::size_t> best;
    double nearest = kOnPlaneMetres;
    for (int dy = -kAboutCells; dy <= kAboutCells; ++dy)
        for (int dx = -kAboutCells; dx <= kAboutCells; ++dx) {
            const int y = std::clamp((*cell)[1] + dy, 0, view.panorama.height() - 1);
            const int x = ((*cell)[0] + dx + view.panorama.width()) % view.panorama.width();
            const int index = view.panorama.cells(x, y).plane;
            if (index < 0) continue;
            const ScanPlane& plane = view.planes[static_cast<std::size_t>(index)];
            const double off = std::abs(glm::dot(plane.normal, place) - plane.offset);
            if (off < nearest) nearest = off, best = static_cast<std::size_t>(index);
        }
    return best;
}

std::string textOf(const glm::dvec3& p) {
    char text[80];
    std::snprintf(text, sizeof text, "%g %g %g", p.x, p.y, p.z);
    return text;
}

std::string listed(const std::vector<std::string>& names) {
    constexpr std::size_t kMost = 20;
    std::string text;
    for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i)
        text += (i > 0 ? ", " : "") + names[i];
    return names.size() > kMost ? text + ", ..." : text;
}

} // namespace

std::vector<GivenMatches> readMatchesFile(const std::filesystem::path& path,
                                          const std::vector<std::string>& scanNames) {
    const json file = readJsonFile(path);
    const auto scanOf = [&](const std::string& name) {
        const auto found = std::find(scanNames.begin(), scanNames.end(), name);
        if (found == scanNames.end())
            throw Failure("names a scan '" + name + "' that the capture has not", path,
                          "choose from " + listed(scanNames));
        return static_cast<std::size_t>(found - scanNames.begin());
    };
    std::vector<GivenMatches> all;
    try {
        for (const json& each : file.at("matches")) {
            GivenMatches matches;
            matches.a = scanOf(each.at("a").get<std::string>());
            matches.b = scanOf(each.at("b").get<std::string>());
            if (matches.a == matches.b) throw Failure("matches a scan with itself", path, "name two scans");
            for (const json& plane : each.at("planes"))
                matches.places.emplace_back(placeOf(plane.at("a")), placeOf(plane.at("b")));
            all.push_back(std::move(matches));
        }
    } catch (const json::exception&) {
        throw Failure("is no file of matches", path, kForm);
    }
    return all;
}

PairResult pairFromMatches(const std::vector<ScanView>& scans, const GivenMatches& matches, const PairOptions& options,
                           const std::filesystem::path& path) {
    const ScanView &a = scans[matches.a], &b = scans[matches.b];
    const auto planeOr = [&](const ScanView& view, const glm::dvec3& place) {
        const auto plane = planeAt(view, place);
        if (!plane)
            throw Failure("says that " + textOf(place) + " is on a plane of scan '" + view.name +
                              "', and none is there",
                          path, "pick a place amid a wall or a floor, in metres as the scanner has it");
        return *plane;
    };
    std::vector<PlaneMatch> planes;
    for (const auto& [inA, inB] : matches.places)
        planes.push_back({planeOr(a, inA), planeOr(b, inB)});
    Pose aFromB;
    if (planes.size() < 3 || !poseFromMatches(a.planes, b.planes, planes, aFromB))
        throw Failure("has too few planes for '" + a.name + "' and '" + b.name + "', or all face two ways", path,
                      "match three planes that face three ways, such as two walls and the floor");
    PairResult result;
    if (const auto fit = settlePair(a, b, aFromB, options)) {
        result.best = *fit;
    } else {
        result.best.aFromB = aFromB;
        result.best.matches = planes;
        result.best.evidence = checkPose(a.panorama, b.panorama, aFromB);
    }
    result.plausible = {result.best.aFromB};
    result.isDecidedByGivenPose = true;
    // A person's word stands for what cannot be decided, not for what cannot be.
    if (result.best.evidence.agreeing < kLeastMatchedAgreeing)
        result.verdict = PairVerdict::apart;
    else if (result.best.evidence.againstShare() > options.mostAgainstShareGiven)
        result.verdict = PairVerdict::contradicted;
    else
        result.verdict = result.best.isHeld ? PairVerdict::registered : PairVerdict::loose;
    return result;
}

} // namespace scene
