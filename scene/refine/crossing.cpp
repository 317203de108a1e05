#include "scene/refine/crossing.h"

#include <algorithm>
#include <cmath>

namespace scene {

namespace {

/// By how much the disparity of a smooth surface changes from one pixel to the next, across and down, about where it is
/// sighted: over three pixels where the surface goes on so far, since between neighbours noise makes slopes of its own.
glm::vec2 slopesAt(const DepthImage& partner, const Sighting& at, float sameSurface) {
    // The first of the four about it; at the image's rim those beside them. An image may be one pixel wide.
    const int lastX = partner.camera.width - 1, lastY = partner.camera.height - 1;
    const int x = std::clamp(static_cast<int>(at.u - 0.5f), 0, std::max(lastX - 1, 0));
    const int y = std::clamp(static_cast<int>(at.v - 0.5f), 0, std::max(lastY - 1, 0));
    const int nextX = std::min(x + 1, lastX), nextY = std::min(y + 1, lastY);
    const int left = std::max(x - 1, 0), right = std::min(x + 2, lastX), top = std::max(y - 1, 0),
              bottom = std::min(y + 2, lastY);
    const auto& d = partner.disparity;
    const auto across = [&](int from, int to) {
        return (d(to, y) - d(from, y) + d(to, nextY) - d(from, nextY)) / static_cast<float>(2 * std::max(to - from, 1));
    };
    const auto down = [&](int from, int to) {
        return (d(x, to) - d(x, from) + d(nextX, to) - d(nextX, from)) / static_cast<float>(2 * std::max(to - from, 1));
    };
    const glm::vec2 near(across(x, nextX), down(y, nextY)), wide(across(left, right), down(top, bottom));
    const auto& f = partner.flags;
    const bool goesOn = isSurface(f(left, y)) && isSurface(f(left, nextY)) && isSurface(f(right, y)) &&
                        isSurface(f(right, nextY)) && isSurface(f(x, top)) && isSurface(f(nextX, top)) &&
                        isSurface(f(x, bottom)) && isSurface(f(nextX, bottom)) &&
                        std::max(std::abs(wide.x - near.x), std::abs(wide.y - near.y)) < sameSurface * at.disparity;
    return goesOn ? wide : near;
}

} // namespace

Crossing crossingOf(const DepthImage& partner, const Reprojection& into, float x, float y, float disparity,
                    const Sighting& at, float sameSurface) {
    const float start = into.origin.z + x * into.columnX.z + y * into.columnY.z;
    Crossing crossing{.w = start + disparity * into.columnD.z, .slopes = slopesAt(partner, at, sameSurface)};
    crossing.upright = start / crossing.w;
    crossing.change = crossing.upright - crossing.slopes.x * (into.columnD.x - at.u * into.columnD.z) -
                      crossing.slopes.y * (into.columnD.y - at.v * into.columnD.z);
    return crossing;
}

} // namespace scene
