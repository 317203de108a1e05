#include "render/source_views.h"

#include "render/draw_needs.h"
#include "scene/coverage_ray.h"

#include <glm/geometric.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace render {

namespace {

/// The planes through the eye and the edges of its picture, and the one behind which nothing is seen: unit normals that
/// point inward, in the world.
struct ViewWedge {
    glm::dvec3 eyeInWorld{0};
    std::array<glm::dvec3, 5> inward;
};

ViewWedge wedgeOf(const scene::View& eye, double marginPixels) {
    const scene::Camera& c = eye.camera;
    const double left = (-marginPixels - c.cx) / c.fx, right = (c.width + marginPixels - c.cx) / c.fx,
                 top = (-marginPixels - c.cy) / c.fy, bottom = (c.height + marginPixels - c.cy) / c.fy;
    ViewWedge wedge{eye.worldFromEye.translation,
                    {glm::dvec3(1, 0, -left), {-1, 0, right}, {0, 1, -top}, {0, -1, bottom}, {0, 0, 1}}};
    for (glm::dvec3& normal : wedge.inward)
        normal = eye.worldFromEye.rotation * glm::normalize(normal);
    return wedge;
}

bool isOutside(const ViewWedge& wedge, const ImageSphere& sphere) {
    const double radius = sphere.radius * (1 + 1e-9);
    return std::any_of(wedge.inward.begin(), wedge.inward.end(), [&](const glm::dvec3& normal) {
        return glm::dot(normal, sphere.centre - wedge.eyeInWorld) < -radius;
    });
}

SourceView viewOf(const ResidentImage& image, const scene::View& eye, const Quality& quality, float share) {
    SourceView view;
    view.eyeImageFromSource = scene::eyeImageFromSourceImage(eye, image.camera, image.worldFromCamera);
    view.eyeFromCamera = eye.worldFromEye.translation - image.worldFromCamera.translation;
    view.pixelsPerSample = std::sqrt(eye.camera.fx * eye.camera.fy / (image.camera.fx * image.camera.fy));
    view.captured = image.captured, view.level = image.level;
    view.share = share;
    view.hasCoarser = image.hasCoarser;
    view.isNear =
        glm::length(view.eyeFromCamera) <= 2 * static_cast<double>(quality.preference.nearBaseline) * image.middleReach;
    return view;
}

/// A coarser level stands where its captured image does, and its camera is halved again and again: powers of two, so
/// that this is what its own camera would give, to the bit.
SourceView levelOf(const SourceView& captured, const ResidentImage& level) {
    SourceView view = captured;
    const double wider = std::exp2(level.level);
    view.eyeImageFromSource[0] *= wider, view.eyeImageFromSource[1] *= wider;
    view.pixelsPerSample *= wider;
    view.level = level.level;
    view.hasCoarser = level.hasCoarser;
    return view;
}

} // namespace

/// Samples are drawn wider than they are and fill holes beside them; and so far behind what was observed may a surface
/// stand that counts as before it. What stands in for finer samples may be wider: it is not to be seen where they are
/// not.
double besideRay(const scene::View& eye, const Quality& quality) {
    constexpr double kRoundedPixels = 2;
    return (marginOf(quality, false) + quality.holes.radius + kRoundedPixels) / std::min(eye.camera.fx, eye.camera.fy) +
           scene::kSurfaceSlack;
}

void findSourceViews(const SceneIndex& scene, const scene::View& eye, const Quality& quality, double marginPixels,
                     std::span<const float> shares, const scene::OpenWays& ways, SourceViews& views) {
    const ViewWedge wedge = wedgeOf(eye, marginPixels);
    const double beside = besideRay(eye, quality);
    const auto isHidden = [&](const ImageSphere& sphere) {
        return sphere.box.isFinite() && !ways.mayMeet(sphere.box.least, sphere.box.most, beside);
    };
    views.of.resize(scene.images.size());
    views.seen.clear();
    views.behindUnseen = 0;
    for (std::uint32_t i = 0; i < scene.capturedImages; ++i) {
        if ((!shares.empty() && shares[i] <= 0) || isOutside(wedge, scene.spheres[i])) continue;
        if (isHidden(scene.spheres[i])) {
            ++views.behindUnseen;
            continue;
        }
        views.seen.push_back(i);
        for (std::uint32_t k = 0; k < scene.images[i].coarserCount; ++k)
            views.seen.push_back(scene.images[i].firstCoarser + k);
    }
    tbb::parallel_for(std::size_t{0}, views.seen.size(), [&](std::size_t k) {
        const std::uint32_t i = views.seen[k];
        const ResidentImage& image = scene.images[i];
        if (image.level > 0) return;
        views.of[i] = viewOf(image, eye, quality, shares.empty() ? 1.0f : shares[i]);
        for (std::uint32_t coarser = image.firstCoarser; coarser < image.firstCoarser + image.coarserCount; ++coarser)
            views.of[coarser] = levelOf(views.of[i], scene.images[coarser]);
    });
}

std::vector<SourceView> sourceViewsOf(std::span<const ResidentImage> images, const scene::View& eye,
                                      const Quality& quality) {
    std::vector<SourceView> views;
    for (const ResidentImage& image : images)
        views.push_back(image.level > 0 ? levelOf(views[image.captured], image) : viewOf(image, eye, quality, 1));
    return views;
}

} // namespace render
