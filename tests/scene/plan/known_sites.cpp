#include "tests/scene/plan/known_sites.h"

#include "scene/cube.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scene {

namespace {

constexpr int kFaceSize = 48;
constexpr double kEyeMetres = 1.6, kClearMetres = 0.3;

/// Where one can stand within a rectangle of the floor.
std::vector<glm::dvec3> placesIn(const SyntheticScene& truth, double left, double right, double front, double back,
                                 double step) {
    std::vector<glm::dvec3> places;
    for (double y = front; y <= back; y += step)
        for (double x = left; x <= right; x += step)
            if (const glm::dvec3 p(x, y, kEyeMetres); clearanceAt(truth, p) > kClearMetres) places.push_back(p);
    return places;
}

KnownSite siteOf(SyntheticScene truth, double left, double right, double front, double back, double step) {
    KnownSite site{std::move(truth), {}, {}};
    site.places = placesIn(site.truth, left, right, front, back, step);
    site.tests = placesIn(site.truth, left + 0.37 * step, right, front + 0.61 * step, back, 2.6 * step);
    return site;
}

} // namespace

std::vector<DepthImage> smallCube(const SyntheticScene& truth, const glm::dvec3& position) {
    std::vector<DepthImage> faces;
    View view;
    view.camera = {kFaceSize, kFaceSize, 0.5 * kFaceSize - 1, 0.5 * kFaceSize - 1, 0.5 * kFaceSize, 0.5 * kFaceSize};
    view.worldFromEye.translation = position;
    for (const glm::dmat3& faceFromCube : facesFromCube(0)) {
        view.worldFromEye.rotation = glm::transpose(faceFromCube);
        faces.push_back(renderTruth(truth, view));
    }
    return faces;
}

CaptureSmall KnownSite::capture() const {
    return [this](const glm::dvec3& position) { return smallCube(truth, position); };
}

SightLines KnownSite::lines() const {
    const auto cast = [this](const glm::dvec3& from, const glm::dvec3& direction) -> std::optional<SightEnd> {
        const std::optional<Hit> hit = castRay(truth, from, direction);
        if (!hit) return std::nullopt;
        return SightEnd{hit->position, hit->normal};
    };
    const auto isBlocked = [this](const glm::dvec3& from, const glm::dvec3& to) {
        const std::optional<Hit> hit = castRay(truth, from, to - from);
        return hit && hit->distanceMetres < 0.999 * glm::length(to - from);
    };
    return {cast, isBlocked};
}

KnownSite furnishedRoom() {
    return siteOf(makeRoom(), 0.3, 4.9, 0.3, 3.9, 0.25);
}

} // namespace scene
