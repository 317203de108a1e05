#include "app/note_accuracy.h"

#include "scene/cube.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

namespace app {

namespace {

using nlohmann::json;

/// Where samples are this far apart, the middle of what they show is known to so much.
double ofSpacing(double metres) {
    return metres / std::sqrt(12.0);
}

/// Of differences that scatter as by chance, whose medians are known.
constexpr double kDeviationOfMedian = 1.4826;

std::pair<std::string, std::string> inOrder(const std::string& a, const std::string& b) {
    return a < b ? std::pair(a, b) : std::pair(b, a);
}

double varianceOf(const scene::SamplesAbout& about) {
    const double spacing = ofSpacing(about.spacingMetres), scatter = about.scatterMetres.value_or(0);
    return spacing * spacing + scatter * scatter;
}

} // namespace

NoteAccuracy::NoteAccuracy(const scene::Scene& scene) : scene_(scene) {
    const json manifest = json::parse(scene.manifest, nullptr, false);
    if (!manifest.is_object()) return;
    isExact_ = manifest.contains("polygons") && !manifest["polygons"].is_null();
    try {
        const json poses = manifest.value("poses", json()), agreement = manifest.value("scan_agreement", json()),
                   registration = manifest.value("registration", json());
        if (!poses.is_null()) surfaceShare_ = kDeviationOfMedian * poses.at("after").at("range_share").get<double>();
        if (!agreement.is_null())
            for (const json& pair : agreement.at("pairs"))
                apartMetres_[inOrder(pair.at("a"), pair.at("b"))] =
                    kDeviationOfMedian * pair.at("apart_m").get<double>();
        if (!registration.is_null())
            for (const json& scan : registration.at("scans"))
                if (scan.at("registered").get<bool>())
                    deviations_[scan.at("name")] = {scan.at("group"), scan.at("deviation_m")};
    } catch (const json::exception&) { // of another version: it tells less
    }
}

std::optional<double> NoteAccuracy::ofPlace(const glm::dvec3& place) const {
    const auto about = samplesAbout(scene_.blocks, place);
    if (!about) return std::nullopt;
    return std::sqrt(varianceOf(*about));
}

std::optional<double> NoteAccuracy::ofDistance(const glm::dvec3& from, const glm::dvec3& to) const {
    const auto a = samplesAbout(scene_.blocks, from), b = samplesAbout(scene_.blocks, to);
    if (!a || !b) return std::nullopt;
    const auto apart = between(*a, *b);
    if (!apart) return std::nullopt;
    return std::sqrt(varianceOf(*a) + varianceOf(*b) + *apart * *apart);
}

std::optional<double> NoteAccuracy::between(const scene::SamplesAbout& a, const scene::SamplesAbout& b) const {
    const auto placeOf = [&](std::size_t image) { return scene_.blocks[image].worldFromCamera.translation; };
    if (isExact_ || placeOf(a.image) == placeOf(b.image)) return 0; // of one set-up
    if (surfaceShare_) return *surfaceShare_ * std::max(a.rangeMetres, b.rangeMetres);
    const std::string scanA = scene::withoutFace(scene_.images[a.image].name),
                      scanB = scene::withoutFace(scene_.images[b.image].name);
    if (const auto pair = apartMetres_.find(inOrder(scanA, scanB)); pair != apartMetres_.end()) return pair->second;
    // Nothing that both show: by way of the scans between them.
    const auto knownA = deviations_.find(scanA), knownB = deviations_.find(scanB);
    if (knownA == deviations_.end() || knownB == deviations_.end() || knownA->second.first != knownB->second.first)
        return std::nullopt;
    return std::hypot(knownA->second.second, knownB->second.second);
}

} // namespace app
