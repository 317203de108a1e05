// Where one walks, films and scans in a synthetic scene.

#include "scene/synthetic.h"

#include "scene/directions.h"
#include "scene/synthetic_model.h"
#include "scene/synthetic_tracer.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

namespace scene {

namespace {

constexpr double kEyeHeight = 1.6;   // metres: a standing adult
constexpr double kBobMetres = 0.012; // a head rises and falls by about two centimetres at each step
constexpr double kStepMetres = 0.7;

/// A curve through the waypoints, smooth in position and in what is looked at; parameter in [0, 1].
Waypoint alongWalk(const SyntheticModel& model, double part) {
    const std::vector<Waypoint>& points = model.walk;
    const int count = static_cast<int>(points.size()), pieces = model.walkIsLoop ? count : count - 1;
    const double place = std::clamp(part, 0.0, 1.0) * pieces;
    const int piece = std::min(static_cast<int>(place), pieces - 1);
    const double t = place - piece;
    const auto at = [&](int index) -> const Waypoint& {
        if (model.walkIsLoop) return points[static_cast<std::size_t>((index + count) % count)];
        return points[static_cast<std::size_t>(std::clamp(index, 0, count - 1))];
    };
    const auto blend = [&](const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d) {
        return 0.5 * (2.0 * b + (c - a) * t + (2.0 * a - 5.0 * b + 4.0 * c - d) * (t * t) +
                      (3.0 * b - a - 3.0 * c + d) * (t * t * t));
    };
    const Waypoint &a = at(piece - 1), &b = at(piece), &c = at(piece + 1), &d = at(piece + 2);
    return {blend(a.position, b.position, c.position, d.position), blend(a.lookAt, b.lookAt, c.lookAt, d.lookAt)};
}

/// Parameters that cut the walk into steps of equal length: count of them, the last one step before the end
/// of a loop.
std::vector<double> evenParts(const SyntheticModel& model, int count) {
    constexpr int kPieces = 2000;
    std::vector<double> lengths(kPieces + 1, 0.0);
    for (int i = 1; i <= kPieces; ++i)
        lengths[static_cast<std::size_t>(i)] =
            lengths[static_cast<std::size_t>(i - 1)] +
            glm::length(alongWalk(model, static_cast<double>(i) / kPieces).position -
                        alongWalk(model, static_cast<double>(i - 1) / kPieces).position);
    std::vector<double> parts;
    const double steps = model.walkIsLoop ? count : std::max(count - 1, 1);
    for (int i = 0; i < count; ++i) {
        const double wanted = lengths.back() * i / steps;
        const auto above = std::max(std::upper_bound(lengths.begin(), lengths.end(), wanted), lengths.begin() + 1);
        const auto end = std::min(above, lengths.end() - 1);
        const double before = *(end - 1), piece = *end - before;
        parts.push_back(
            (static_cast<double>(end - lengths.begin()) - 1.0 + (piece > 0 ? (wanted - before) / piece : 0.0)) /
            kPieces);
    }
    return parts;
}

double walkLength(const SyntheticModel& model) {
    double length = 0;
    for (int i = 1; i <= 200; ++i)
        length += glm::length(alongWalk(model, i / 200.0).position - alongWalk(model, (i - 1) / 200.0).position);
    return length;
}

/// A camera at a place that looks along a direction with its x axis level. Camera axes: x right, y down, z
/// forward.
Pose lookingAlong(const glm::dvec3& position, const glm::dvec3& direction) {
    const glm::dvec3 forward = glm::normalize(direction);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 0, 1)));
    return {glm::dmat3(right, glm::cross(forward, right), forward), position};
}

} // namespace

Camera walkCamera() {
    return {640, 480, 320.0, 320.0, 320.0, 240.0};
}

Camera captureCamera() {
    return {640, 480, 525.0, 525.0, 320.0, 240.0};
}

std::vector<View> walkPath(const SyntheticScene& scene, int count, const Camera& camera) {
    const SyntheticModel& model = scene.model();
    assert(count >= 1 && model.walk.size() >= 2);
    const double length = walkLength(model);
    std::vector<View> views;
    const std::vector<double> parts = evenParts(model, count);
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const double part = parts[i];
        Waypoint at = alongWalk(model, part);
        const double walked = length * static_cast<double>(i) / static_cast<double>(parts.size());
        at.position.z = kEyeHeight + kBobMetres * std::sin(kTwoPi * walked / kStepMetres);
        const Waypoint ahead =
            alongWalk(model, model.walkIsLoop ? std::fmod(part + 0.02, 1.0) : std::min(part + 0.02, 1.0));
        glm::dvec3 heading = ahead.position - at.position;
        heading.z = 0;
        const glm::dvec3 seen = glm::normalize(at.lookAt - at.position);
        const double pace = glm::length(heading);
        if (pace > 1e-6) heading /= pace;
        // Mostly at what there is to see, a little where the feet go.
        views.push_back({camera, lookingAlong(at.position, seen + 0.35 * heading)});
    }
    return views;
}

std::vector<View> captureViews(const SyntheticScene& scene, int count, const Camera& camera) {
    const SyntheticModel& model = scene.model();
    assert(count >= 1 && model.walk.size() >= 2);
    // A step in direction is about half of a hand-held camera's field of view, so that neighbours overlap.
    const double turns = std::clamp(std::round(count / 11.0), 1.0, 12.0);
    const std::vector<double> parts = evenParts(model, count);
    std::vector<View> views;
    for (int i = 0; i < count; ++i) {
        const double part = (i + 0.5) / count;
        glm::dvec3 position = alongWalk(model, parts[static_cast<std::size_t>(i)]).position;
        position.z =
            1.45 + 0.17 * std::sin(kTwoPi * part * (turns * 0.5 + 0.31)) + 0.02 * std::sin(kTwoPi * part * 23.0);
        const double yaw = kTwoPi * (turns * part + 0.02 * std::sin(kTwoPi * part * 19.0));
        const double pitch = -0.16 + 0.42 * std::sin(kTwoPi * part * (turns * 1.37 + 0.21));
        const double roll = 0.04 * std::sin(kTwoPi * part * 13.0 + 0.5);
        const glm::dvec3 forward(std::cos(pitch) * std::cos(yaw), std::cos(pitch) * std::sin(yaw), std::sin(pitch));
        Pose worldFromCamera = lookingAlong(position, forward);
        const glm::dvec3 x = worldFromCamera.rotation[0], y = worldFromCamera.rotation[1];
        worldFromCamera.rotation[0] = x * std::cos(roll) + y * std::sin(roll);
        worldFromCamera.rotation[1] = y * std::cos(roll) - x * std::sin(roll);
        views.push_back({camera, worldFromCamera});
    }
    return views;
}

double clearanceAt(const SyntheticScene& scene, const glm::dvec3& pInWorld) {
    constexpr int kDirections = 64;
    static const std::vector<glm::dvec3> directions = spreadDirections(kDirections);
    double nearest = std::numeric_limits<double>::infinity();
    for (const glm::dvec3& direction : directions) {
        const auto hit = scene.tracer().cast(pInWorld, {direction.x, direction.z, direction.y});
        if (hit) nearest = std::min(nearest, hit->t);
    }
    return nearest;
}

std::vector<Pose> scanPositions(const SyntheticScene& scene) {
    std::vector<Pose> positions;
    for (const glm::dvec3& tripod : scene.model().tripods)
        positions.push_back({glm::dmat3(1.0), tripod});
    return positions;
}

} // namespace scene
