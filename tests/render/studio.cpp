#include "tests/render/studio.h"

#include "scene/blend.h"
#include "scene/pyramid.h"

#include <cmath>
#include <cstdlib>

namespace render {

Quality qualityOf(Warp warp) {
    Quality quality;
    quality.warp = warp;
    quality.preference.nearBaseline = 0.2f;
    return quality;
}

std::vector<Way> ways() {
    std::vector<Way> all{{"points", qualityOf(Warp::points)},
                         {"splats", qualityOf(Warp::splats)},
                         {"mesh", qualityOf(Warp::mesh)},
                         {"adaptive", qualityOf(Warp::adaptive)},
                         {"points, near squares, filled", qualityOf(Warp::points)},
                         {"points, blended", qualityOf(Warp::points)},
                         {"mesh, lone points, blended, filled", qualityOf(Warp::mesh)},
                         {"adaptive, lone points, coarse, smaller, filled", qualityOf(Warp::adaptive)},
                         {"points, interpolated", qualityOf(Warp::points)},
                         {"splats, interpolated", qualityOf(Warp::splats)}};
    all[4].quality.interpolatesSamples = all[8].quality.interpolatesSamples = all[9].quality.interpolatesSamples = true;
    all[4].quality.holes.radius = 8, all[4].quality.drawsSquaresNear = true;
    all[6].quality.drawsLone = all[7].quality.drawsLone = true;
    all[5].quality.isBlended = true;
    all[6].quality.isBlended = true, all[6].quality.holes.radius = 8;
    all[7].quality.samplePixels = 1.5, all[7].quality.resolutionScale = 0.7, all[7].quality.holes.radius = 8;
    return all;
}

CutScene roomAllAround() {
    std::vector<scene::DepthImage> images = roomFromWithin(96).images;
    return cutInLevels(std::move(images));
}

CutScene movedBy(CutScene scene, const glm::dvec3& offset) {
    for (scene::DepthImage& image : scene.images)
        image.worldFromCamera.translation += offset;
    return scene;
}

Studio::Studio(CutScene cut, const scene::Coverage* coverage, const Device& device)
    : device_(device), cut_(std::move(cut)), scene_(device, cut_.blocks()) {
    if (coverage != nullptr) coverage_.emplace(device, *coverage);
}

EyeImage Studio::draw(const scene::View& view, const Quality& quality, const Overlay* overlay) {
    if (!renderer_ || width_ != view.camera.width || height_ != view.camera.height) {
        renderer_.reset();
        width_ = view.camera.width, height_ = view.camera.height;
        renderer_.emplace(device_, scene_, width_, height_, 1, coverage_ ? &*coverage_ : nullptr);
    }
    renderer_->draw(std::span(&view, 1), quality, {}, overlay);
    return renderer_->readBack()[0];
}

std::optional<scene::EyeImage> Studio::drawByProcessor(const scene::View& eye, const Quality& quality) const {
    if (quality.warp == Warp::adaptive || quality.holes.radius > 0) return std::nullopt;
    const scene::WarpOptions options{
        .preference = quality.preference, .maxFootprint = quality.maxFootprint, .maxSplat = quality.maxSplat};
    scene::ZBuffer zBuffer(eye.camera.width, eye.camera.height, 0);
    const std::vector<scene::TileBlock> blocks = cut_.blocks();
    const auto warp = quality.warp == Warp::points ? scene::warpPoints
                      : quality.warp == Warp::mesh ? scene::warpMesh
                                                   : scene::warpSplats;
    warp(blocks, eye, options, zBuffer);
    if (!quality.isBlended && quality.interpolatesSamples)
        return interpolated(zBuffer, quality.warp == Warp::points ? placeStepsOfPoints() : placeStepsOfSplats());
    if (!quality.isBlended) return scene::resolve(zBuffer);
    return scene::resolve(zBuffer, scene::warpBlend(blocks, eye, quality.blend, zBuffer));
}

scene::EyeImage interpolated(const scene::ZBuffer& zBuffer, const PlaceSteps& places) {
    scene::EyeImage eye = scene::resolve(zBuffer);
    const auto at = [&](int x, int y) {
        const bool isInside = x >= 0 && y >= 0 && x < zBuffer.width() && y < zBuffer.height();
        const std::uint64_t key = isInside ? zBuffer(x, y) : 0;
        return placedSampleOf(uvec2(static_cast<uint>(key), static_cast<uint>(key >> 32)), places);
    };
    for (int y = 0; y < zBuffer.height(); ++y)
        for (int x = 0; x < zBuffer.width(); ++x) {
            if (zBuffer(x, y) == 0) continue;
            const uint mean = interpolatedColour(at(x, y), at(x - 1, y), at(x + 1, y), at(x, y - 1), at(x, y + 1));
            const auto byte = [&](int shift) { return static_cast<std::uint8_t>(mean >> shift & 255u); };
            eye.colour(x, y) = {byte(0), byte(8), byte(16)};
        }
    return eye;
}

testing::AssertionResult isSane(const EyeImage& image) {
    for (int y = 0; y < image.colour.height(); ++y)
        for (int x = 0; x < image.colour.width(); ++x) {
            const float depth = image.depthMetres(x, y);
            const int pixelClass = image.pixelClass(x, y);
            const bool hasDepth = pixelClass == 0 ? depth == 0.0f : depth >= (pixelClass == 3 ? 0.0f : 0.99e-5f);
            if (!hasDepth || pixelClass > 3)
                return testing::AssertionFailure()
                       << "pixel (" << x << ", " << y << ") of class " << pixelClass << " stands at " << depth << " m";
        }
    return testing::AssertionSuccess();
}

double psnrOf(const EyeImage& a, const EyeImage& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.colour.size(); ++i) {
        const scene::Rgb8 p = a.colour.pixels()[i], q = b.colour.pixels()[i];
        sum += (p.r - q.r) * (p.r - q.r) + (p.g - q.g) * (p.g - q.g) + (p.b - q.b) * (p.b - q.b);
    }
    const double mean = sum / (3 * static_cast<double>(a.colour.size()));
    return mean > 0 ? 10 * std::log10(255.0 * 255.0 / mean) : 200;
}

double shareThatDiffers(const EyeImage& a, const scene::EyeImage& b, int colour) {
    return shareOf(a, [&](int x, int y) {
        const scene::Rgb8 p = a.colour(x, y), q = b.colour(x, y);
        return a.pixelClass(x, y) != b.pixelClass(x, y) || std::abs(p.r - q.r) > colour ||
               std::abs(p.g - q.g) > colour || std::abs(p.b - q.b) > colour;
    });
}

} // namespace render
