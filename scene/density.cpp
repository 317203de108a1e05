#include "scene/density.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace scene {

namespace {

/// Slopes are taken over a few samples each way, so that noise of single samples does not tilt the surface.
constexpr int kReach = 3;
constexpr float kSameDepth = 0.05f;

/// Change of disparity per sample along one axis, from the farthest samples of the same surface within reach.
template <class At>
float slopeAlong(const At& at, float centre, int below, int above) {
    int first = 0, last = 0;
    float low = centre, high = centre;
    for (int i = 1; i <= std::min(kReach, below); ++i) {
        const float d = at(-i);
        if (d <= 0 || std::abs(d - low) > kSameDepth * centre) break;
        low = d, first = -i;
    }
    for (int i = 1; i <= std::min(kReach, above); ++i) {
        const float d = at(i);
        if (d <= 0 || std::abs(d - high) > kSameDepth * centre) break;
        high = d, last = i;
    }
    return last > first ? (high - low) / static_cast<float>(last - first) : 0.0f;
}

} // namespace

Image<float> computeDensity(const DepthImage& image) {
    const Camera& camera = image.camera;
    Image<float> density(camera.width, camera.height, 0.0f);
    const auto fx = static_cast<float>(camera.fx), fy = static_cast<float>(camera.fy);
    const auto surfaceAt = [&](int x, int y) { return isSurface(image.flags(x, y)) ? image.disparity(x, y) : 0.0f; };
    for (int y = 0; y < camera.height; ++y) {
        for (int x = 0; x < camera.width; ++x) {
            const float d = surfaceAt(x, y);
            if (d <= 0) continue;
            const float dx = slopeAlong([&](int i) { return surfaceAt(x + i, y); }, d, x, camera.width - 1 - x);
            const float dy = slopeAlong([&](int i) { return surfaceAt(x, y + i); }, d, y, camera.height - 1 - y);
            const glm::vec3 ray(rayThrough(camera, x + 0.5, y + 0.5));
            const float a = dx * fx, b = dy * fy, c = d - a * ray.x - b * ray.y;
            const float cosine = d / (std::sqrt(a * a + b * b + c * c) * glm::length(ray));
            density(x, y) = fx * fy * glm::length(ray) * d * d * std::min(cosine, 1.0f);
        }
    }
    return density;
}

} // namespace scene
