#include "app/note_accuracy.h"

#include "scene/cube.h"

#include <algorithm>
#include <cmath>

#include <glm/trigonometric.hpp>
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
        if (!poses.is_null()) {
            surfaceShare_ = kDeviationOfMedian * poses.at("after").at("range_share").get<double>();
            for (const json& image : poses.at("images"))
                if (const std::string place = image.at("place"); place == "loose" || place == "strayed")
                    loose_.insert(image.at("name"));
        }
        if (!agreement.is_null())
            for (const json& pair : agreement.at("pairs"))
                apartMetres_[inOrder(pair.at("a"), pair.at("b"))] =
                    kDeviationOfMedian * pair.at("apart_m").get<double>();
        if (!registration.is_null())
            for (const json& scan : registration.at("scans"))
                if (scan.at("registered").get<bool>())
                    registered_[scan.at("name")] = {scan.at("group"), scan.at("deviation_m"),
                                                    glm::radians(scan.at("deviation_deg").get<double>())};
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
    const auto apart = between({from, *a}, {to, *b});
    if (!apart) return std::nullopt;
    return std::sqrt(varianceOf(*a) + varianceOf(*b) + *apart * *apart);
}

std::optional<double> NoteAccuracy::between(const End& a, const End& b) const {
    if (isExact_ || a.about.image == b.about.image) return 0;
    const std::string &imageA = scene_.images[a.about.image].name, &imageB = scene_.images[b.about.image].name;
    if (surfaceShare_) return betweenPhotographs(a, b);
    const std::string scanA = scene::withoutFace(imageA), scanB = scene::withoutFace(imageB);
    const auto placeOf = [&](const End& end) { return scene_.images[end.about.image].worldFromCamera.translation; };
    if (scanA == scanB && placeOf(a) == placeOf(b)) return 0;
    return betweenScans(scanA, scanB, a, b);
}

/// Surfaces of two scans lie on each other though one has slid along them, which the deviations of registration know;
/// and those know nothing of what is wrong with a scan.
std::optional<double> NoteAccuracy::betweenScans(const std::string& a, const std::string& b, const End& atA,
                                                 const End& atB) const {
    std::optional<double> result;
    if (const auto pair = apartMetres_.find(inOrder(a, b)); pair != apartMetres_.end()) result = pair->second;
    const auto knownA = registered_.find(a), knownB = registered_.find(b);
    if (knownA == registered_.end() || knownB == registered_.end() || knownA->second.group != knownB->second.group)
        return result;
    const auto varianceAt = [](const Registered& scan, const End& end) {
        const double turned = scan.radians * end.about.rangeMetres;
        return scan.metres * scan.metres + turned * turned;
    };
    const double deviation = std::sqrt(varianceAt(knownA->second, atA) + varianceAt(knownB->second, atB));
    return std::max(result.value_or(0), deviation);
}

/// Known where one photograph that lies on others has both places in view (or something before them: what it saw there
/// is not kept if others saw it better). Along a chain errors add up, and nobody knows how.
std::optional<double> NoteAccuracy::betweenPhotographs(const End& a, const End& b) const {
    for (const End* end : {&a, &b})
        if (loose_.contains(scene_.images[end->about.image].name)) return std::nullopt;
    const bool isShown = std::ranges::any_of(scene_.images, [&](const scene::SceneImage& image) {
        const auto isInPicture = [&](const glm::dvec3& place) {
            const glm::dvec3 p = inverse(image.worldFromCamera) * place;
            const scene::Camera& c = image.camera;
            const double u = c.fx * p.x / p.z + c.cx, v = c.fy * p.y / p.z + c.cy;
            return p.z > 0 && u >= 0 && v >= 0 && u < c.width && v < c.height;
        };
        return !loose_.contains(image.name) && isInPicture(a.place) && isInPicture(b.place);
    });
    if (!isShown) return std::nullopt;
    return *surfaceShare_ * std::max(a.about.rangeMetres, b.about.rangeMetres);
}

} // namespace app
