#include "app/overlays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

namespace app {

namespace {

constexpr double kPi = 3.141592653589793;
constexpr float kBehind = 0.3f;           ///< what marks show of themselves through surfaces
constexpr double kFarPositionMetres = 30; ///< positions of which nothing is drawn are marked up to here

void addLine(render::Overlay& overlay, const glm::dvec3& a, const glm::dvec3& b, scene::Rgb8 colour, float width,
             float opacity = 1, float whenHidden = 0) {
    overlay.segments.push_back({a, b, colour, width, opacity, whenHidden});
}

/// A unit vector at right angles to direction, as near to `liked` as can be.
glm::dvec3 across(const glm::dvec3& direction, const glm::dvec3& liked) {
    const glm::dvec3 rest = liked - direction * glm::dot(liked, direction);
    if (glm::length(rest) > 0.1) return glm::normalize(rest);
    const glm::dvec3 other = std::abs(direction.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    return glm::normalize(other - direction * glm::dot(other, direction));
}

void addRing(render::Overlay& overlay, const glm::dvec3& centre, const glm::dvec3& normal, double radius,
             scene::Rgb8 colour, float width, float opacity, float whenHidden) {
    constexpr int kCorners = 32;
    const glm::dvec3 u = across(normal, glm::dvec3(1, 0, 0)), v = glm::cross(normal, u);
    const auto corner = [&](int i) {
        const double angle = 2 * kPi * (i % kCorners) / kCorners;
        return centre + radius * (std::cos(angle) * u + std::sin(angle) * v);
    };
    for (int i = 0; i < kCorners; ++i)
        addLine(overlay, corner(i), corner(i + 1), colour, width, opacity, whenHidden);
}

} // namespace

void addFloorGrid(render::Overlay& overlay, const scene::Pose& worldFromWalk, const glm::dvec3& aroundInWalk,
                  double height, double radius) {
    constexpr double kLift = 0.01; // metres: a scanned floor is that rough
    // A line that runs along axis `along`, cut at each metre so that it can fade.
    const auto addRow = [&](int along, double offset) {
        const int over = 2 - along;
        const double off = offset - aroundInWalk[over];
        const double half2 = radius * radius - off * off;
        if (half2 <= 0) return;
        const double from = aroundInWalk[along] - std::sqrt(half2), to = aroundInWalk[along] + std::sqrt(half2);
        const auto at = [&](double t) {
            glm::dvec3 p(0, height + kLift, 0);
            p[along] = t, p[over] = offset;
            return worldFromWalk * p;
        };
        for (double t = from; t < to;) {
            const double next = std::min(std::floor(t + 1 + 1e-9), to);
            const double middle = (t + next) / 2 - aroundInWalk[along];
            const double fade = 1 - std::sqrt(middle * middle + off * off) / radius;
            if (fade > 0) addLine(overlay, at(t), at(next), kGridColour, 1.5f, static_cast<float>(0.8 * fade), 0.2f);
            t = next;
        }
    };
    if (!(radius > 0 && radius < 1000) || !std::isfinite(aroundInWalk.x + aroundInWalk.z)) return;
    for (const int along : {0, 2}) {
        const double middle = aroundInWalk[2 - along];
        for (double offset = std::ceil(middle - radius); offset <= middle + radius; ++offset)
            addRow(along, offset);
    }
}

void addTeleport(render::Overlay& overlay, std::span<const glm::dvec3> beamInWorld, const glm::dvec3& upInWorld,
                 bool isAllowed, double ringRadius) {
    if (beamInWorld.empty()) return;
    const scene::Rgb8 colour = isAllowed ? kAllowedColour : kRefusedColour;
    for (std::size_t i = 1; i < beamInWorld.size(); ++i)
        addLine(overlay, beamInWorld[i - 1], beamInWorld[i], colour, 3, 0.8f);
    const glm::dvec3 up = glm::normalize(upInWorld), at = beamInWorld.back() + 0.005 * up;
    addRing(overlay, at, up, ringRadius, colour, 4, 1, kBehind);
    if (isAllowed) {
        addRing(overlay, at, up, 0.6 * ringRadius, colour, 2, 0.7f, kBehind);
        return;
    }
    const glm::dvec3 u = 0.7 * ringRadius * across(up, glm::dvec3(1, 0, 0)), v = glm::cross(up, u);
    addLine(overlay, at - u - v, at + u + v, colour, 4, 1, kBehind);
    addLine(overlay, at - u + v, at + u - v, colour, 4, 1, kBehind);
}

void addCross(render::Overlay& overlay, const scene::Pose& worldFromWalk, const glm::dvec3& atInWorld,
              scene::Rgb8 colour, double size) {
    for (int axis = 0; axis < 3; ++axis) {
        const glm::dvec3 half = size / 2 * worldFromWalk.rotation[axis];
        addLine(overlay, atInWorld - half, atInWorld + half, colour, 2.5f, 1, kBehind);
    }
}

void addAim(render::Overlay& overlay, const scene::Pose& worldFromWalk, const glm::dvec3& atInWorld,
            const glm::dvec3& normalInWorld, scene::Rgb8 colour, double radius) {
    if (!(glm::length(normalInWorld) > 0.5)) return addCross(overlay, worldFromWalk, atInWorld, colour, 2 * radius);
    addRing(overlay, atInWorld, normalInWorld, radius, colour, 2.5f, 1, 0.5f);
    addLine(overlay, atInWorld, atInWorld + 2 * radius * normalInWorld, colour, 2.5f, 1, 0.5f);
}

void addDistance(render::Overlay& overlay, const scene::Pose& worldFromWalk, const glm::dvec3& fromInWorld,
                 const glm::dvec3& toInWorld, scene::Rgb8 colour) {
    const double length = glm::distance(fromInWorld, toInWorld);
    addLine(overlay, fromInWorld, toInWorld, colour, 3, 1, kBehind);
    if (!(length > 1e-6) || !std::isfinite(length)) return;
    const glm::dvec3 along = (toInWorld - fromInWorld) / length;
    const glm::dvec3 side = across(along, worldFromWalk.rotation[1]);
    const auto addBar = [&](double t, double half, float width) {
        const glm::dvec3 at = fromInWorld + t * along;
        addLine(overlay, at - half * side, at + half * side, colour, width, 1, kBehind);
    };
    addBar(0, 0.04, 3), addBar(length, 0.04, 3);
    constexpr int kMostBars = 200;
    const double step = length <= 2 ? 0.1 : 1.0;
    for (int i = 1; i * step < length - 1e-6 && i <= kMostBars; ++i)
        addBar(i * step, 0.015, 2);
}

void addCameras(render::Overlay& overlay, std::span<const scene::SceneImage> images, const glm::dvec3& aroundInWorld,
                double size, std::size_t most) {
    std::vector<std::size_t> order(images.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    most = std::min(most, order.size());
    const auto away = [&](std::size_t i) {
        return glm::distance(images[i].worldFromCamera.translation, aroundInWorld);
    };
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(most), order.end(),
                      [&](std::size_t a, std::size_t b) { return away(a) != away(b) ? away(a) < away(b) : a < b; });
    for (const std::size_t i : std::span(order).first(most)) {
        const scene::Camera& camera = images[i].camera;
        const scene::Pose& pose = images[i].worldFromCamera;
        const auto at = [&](double x, double y) { return pose * (size * scene::rayThrough(camera, x, y)); };
        const double w = camera.width, h = camera.height;
        const std::array<glm::dvec3, 4> corners{at(0, 0), at(w, 0), at(w, h), at(0, h)};
        for (std::size_t corner = 0; corner < 4; ++corner) {
            addLine(overlay, pose.translation, corners[corner], kCameraColour, 1.5f, 0.8f);
            addLine(overlay, corners[corner], corners[(corner + 1) % 4], kCameraColour, 1.5f, 0.8f);
        }
        const glm::dvec3 roof = at(w / 2, -0.15 * h);
        addLine(overlay, corners[0], roof, kCameraColour, 1.5f, 0.8f);
        addLine(overlay, corners[1], roof, kCameraColour, 1.5f, 0.8f);
    }
}

void addCells(render::Overlay& overlay, const scene::Pose& worldFromWalk, const Selection& selection,
              const glm::dvec3& aroundInWorld, std::size_t most) {
    if (!selection.hasCells()) return;
    const scene::WalkCells& cells = selection.cells();
    const int corners = cells.dimension() + 1;
    const glm::dvec3 lower = cells.dimension() < 3 ? -kFlatCellsLowerMetres * worldFromWalk.rotation[1] : glm::dvec3(0);
    using Edge = std::pair<std::uint32_t, std::uint32_t>;
    const auto edgesOf = [&](const scene::WalkCell& cell, std::vector<Edge>& edges) {
        for (int a = 0; a < corners; ++a)
            for (int b = a + 1; b < corners; ++b)
                edges.push_back(std::minmax(cell.corners[a], cell.corners[b]));
    };
    std::vector<Edge> edges, own;
    for (const scene::WalkCell& cell : cells.cells())
        edgesOf(cell, edges);
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    edgesOf(cells.cells()[selection.cell()], own);
    const auto place = [&](std::uint32_t corner) { return cells.corners()[corner]; };
    const auto away = [&](const Edge& edge) {
        return glm::distance(0.5 * (place(edge.first) + place(edge.second)), aroundInWorld);
    };
    std::stable_sort(edges.begin(), edges.end(), [&](const Edge& a, const Edge& b) { return away(a) < away(b); });
    edges.resize(std::min(edges.size(), most));
    for (const Edge& edge : edges) {
        const bool isOwn = std::find(own.begin(), own.end(), edge) != own.end();
        addLine(overlay, place(edge.first) + lower, place(edge.second) + lower, isOwn ? kAllowedColour : kGridColour,
                isOwn ? 3.5f : 2.0f, isOwn ? 1.0f : 0.7f, kBehind);
    }
    const std::span<const float> shares = selection.sharesOfPositions();
    for (std::size_t i = 0; i < selection.positions().size(); ++i) {
        const glm::dvec3& at = selection.positions()[i];
        const float share = shares.empty() ? 1.0f : shares[i];
        if (share <= 0 && glm::distance(at, aroundInWorld) > kFarPositionMetres) continue;
        addCross(overlay, worldFromWalk, at, share > 0 ? kMarkColour : kGridColour, 0.12);
        if (glm::length(lower) > 0)
            addLine(overlay, at, at + lower, share > 0 ? kMarkColour : kGridColour, 1.5f, 0.7f, kBehind);
        char text[64];
        std::snprintf(text, sizeof text, "%zu: %.0f %%", i, 100 * static_cast<double>(share));
        overlay.labels.push_back({.at = at + 0.12 * worldFromWalk.rotation[1],
                                  .text = text,
                                  .colour = share > 0 ? kMarkColour : kGridColour});
    }
}

void addController(render::Overlay& overlay, const scene::Pose& worldFromAim, double rayLength, scene::Rgb8 colour) {
    const auto at = [&](double x, double y, double z) { return worldFromAim * glm::dvec3(x, y, z); };
    addLine(overlay, at(0, 0, 0), at(0, -0.03, 0.11), colour, 9, 0.9f);
    addRing(overlay, at(0, 0, -0.01), worldFromAim.rotation[2], 0.025, colour, 3, 0.9f, 0);
    if (rayLength > 0) addLine(overlay, at(0, 0, 0), at(0, 0, -rayLength), colour, 2, 0.7f);
}

} // namespace app
