#include "scene/capture/polygon_view.h"

#include "scene/srgb.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>

#include <glm/geometric.hpp>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr int kBandRows = 16; ///< each band finds the rows beside it once more, so that none waits for another

/// What one ray sees.
struct Sample {
    glm::dvec3 ray{0.0}; ///< in the camera, z = 1
    double disparity = 0;
    glm::dvec3 plane{0.0};  ///< of the surface: the disparity of ray r is dot(plane, r)
    glm::vec3 colour{0.0f}; ///< exposed, linear
    bool isSurface = false;
};

class Looker {
  public:
    Looker(const PolygonTracer& tracer, const SurfaceLight& light, const View& view)
        : tracer_(tracer), light_(light), view_(view) {}

    /// Through image place (x, y); the sample stands for pixelShare of a pixel's width.
    Sample look(double x, double y, double pixelShare) const {
        const glm::dmat3& worldFromEye = view_.worldFromEye.rotation;
        const glm::dvec3& origin = view_.worldFromEye.translation;
        Sample sample;
        sample.ray = rayThrough(view_.camera, x, y);
        const glm::dvec3 direction = worldFromEye * sample.ray;
        const std::optional<PolygonHit> hit = tracer_.cast(origin, direction);
        if (!hit) {
            sample.colour = light_.exposed(light_.skyTowards(direction));
            return sample;
        }
        const PolygonPoint point = light_.pointAt(origin, direction, *hit);
        const glm::dvec3 normal = glm::transpose(worldFromEye) * point.flatNormal;
        sample.isSurface = true;
        sample.disparity = 1.0 / hit->t; // the ray is 1 long along z
        const double along = glm::dot(normal, sample.ray) * hit->t;
        sample.plane = normal / along;
        if (!(std::abs(along) > 1e-12 * hit->t)) sample.plane = glm::dvec3(0, 0, sample.disparity);

        const TextureFootprint footprint = footprintOf(*hit, point, sample, pixelShare);
        sample.colour = light_.exposed(light_.colourAt(*hit, point, footprint) * light_.at(*hit, point));
        return sample;
    }

  private:
    /// Place on the surface is ray / disparity, with the disparity affine: its derivatives by x and y.
    TextureFootprint footprintOf(const PolygonHit& hit, const PolygonPoint& point, const Sample& sample,
                                 double pixelShare) const {
        const TriangleInWorld triangle = tracer_.triangleOf(hit);
        const glm::dvec3 weights = weightsAt(triangle, point.position);
        const auto stepTo = [&](int axis, double focal) {
            const double step = pixelShare / focal;
            glm::dvec3 movedInCamera = -sample.ray * (hit.t * hit.t * sample.plane[axis] * step);
            movedInCamera[axis] += hit.t * step;
            const glm::dvec3 moved = view_.worldFromEye.rotation * movedInCamera;
            const glm::dvec3 there = weightsAt(triangle, point.position + moved);
            return light_.texturePlaceAt(hit, there) - light_.texturePlaceAt(hit, weights);
        };
        return {stepTo(0, view_.camera.fx), stepTo(1, view_.camera.fy)};
    }

    const PolygonTracer& tracer_;
    const SurfaceLight& light_;
    const View& view_;
};

/// One surface, as far as depth tells: either lies in the plane of the other.
bool areOneSurface(const Sample& a, const Sample& b, double sameDepth) {
    if (!a.isSurface || !b.isSurface) return false;
    return std::abs(glm::dot(a.plane, b.ray) - b.disparity) <= sameDepth * b.disparity ||
           std::abs(glm::dot(b.plane, a.ray) - a.disparity) <= sameDepth * a.disparity;
}

bool areOneColour(const Rgb8& a, const Rgb8& b, int step) {
    return std::abs(a.r - b.r) <= step && std::abs(a.g - b.g) <= step && std::abs(a.b - b.b) <= step;
}

/// The mean over the pixel of what stands on the surface that its centre sees.
glm::vec3 meanOnSurface(const Looker& looker, const Sample& centre, int x, int y, const PolygonViewOptions& options) {
    const double share = 1.0 / options.raysAcross;
    glm::vec3 sum(0);
    int count = 0;
    for (int j = 0; j < options.raysAcross; ++j)
        for (int i = 0; i < options.raysAcross; ++i) {
            const Sample sample = looker.look(x + (i + 0.5) * share, y + (j + 0.5) * share, share);
            if (!areOneSurface(centre, sample, options.sameDepth)) continue;
            sum += sample.colour;
            ++count;
        }
    return count > 0 ? sum / static_cast<float>(count) : centre.colour;
}

} // namespace

DepthImage renderPolygons(const PolygonTracer& tracer, const SurfaceLight& light, const View& view,
                          const PolygonViewOptions& options) {
    assert(isUsable(view.camera) && options.raysAcross >= 1);
    const int width = view.camera.width, height = view.camera.height;
    DepthImage image;
    image.camera = view.camera;
    image.worldFromCamera = view.worldFromEye;
    image.colour = Image<Rgb8>(width, height);
    image.disparity = Image<float>(width, height, 0.0f);
    image.flags = Image<std::uint8_t>(width, height, 0);
    const Looker looker(tracer, light, view);

    tbb::parallel_for(0, (height + kBandRows - 1) / kBandRows, [&](int band) {
        const int first = band * kBandRows, end = std::min(first + kBandRows, height);
        const int above = std::max(first - 1, 0), below = std::min(end + 1, height);
        Image<Sample> centres(width, below - above);
        Image<Rgb8> colours(width, below - above);
        for (int y = above; y < below; ++y)
            for (int x = 0; x < width; ++x) {
                const Sample& centre = centres(x, y - above) = looker.look(x + 0.5, y + 0.5, 1.0);
                colours(x, y - above) = encoded(centre.colour);
            }
        for (int y = first; y < end; ++y)
            for (int x = 0; x < width; ++x) {
                const Sample& centre = centres(x, y - above);
                image.colour(x, y) = colours(x, y - above);
                image.disparity(x, y) = static_cast<float>(centre.disparity);
                if (!centre.isSurface) image.flags(x, y) = kNoSurface;
                const auto needsMore = [&](int i, int j) {
                    return i >= 0 && i < width && j >= above && j < below &&
                           !areOneColour(colours(x, y - above), colours(i, j - above), options.colourStep) &&
                           areOneSurface(centre, centres(i, j - above), options.sameDepth);
                };
                if (options.raysAcross > 1 &&
                    (needsMore(x - 1, y) || needsMore(x + 1, y) || needsMore(x, y - 1) || needsMore(x, y + 1)))
                    image.colour(x, y) = encoded(meanOnSurface(looker, centre, x, y, options));
            }
    });
    return image;
}

} // namespace scene
