#include "tests/render/studio.h"

#include "render/post/rescale.h"
#include "render/shaders/shared/rescale.h"
#include "scene/blend.h"
#include "scene/pyramid.h"

#include <algorithm>
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
                         {"splats, interpolated", qualityOf(Warp::splats)},
                         {"points, near squares, interpolated, smaller, filled", qualityOf(Warp::points)}};
    for (std::size_t i : {8u, 9u, 10u})
        all[i].quality.interpolatesSamples = true;
    all[10].quality.resolutionScale = 0.7, all[10].quality.holes.radius = 8, all[10].quality.drawsSquaresNear = true;
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
    const bool isInterpolated = !quality.isBlended && quality.interpolatesSamples;
    if (quality.resolutionScale != 1 && !(isInterpolated && quality.resolutionScale < 1)) return std::nullopt;
    const scene::WarpOptions options{
        .preference = quality.preference, .maxFootprint = quality.maxFootprint, .maxSplat = quality.maxSplat};
    const auto sideOf = [&](int pixels) { return scaledSide(pixels, quality.resolutionScale); };
    const scene::View warped{scene::resized(eye.camera, sideOf(eye.camera.width), sideOf(eye.camera.height)),
                             eye.worldFromEye};
    scene::ZBuffer zBuffer(warped.camera.width, warped.camera.height, 0);
    const std::vector<scene::TileBlock> blocks = cut_.blocks();
    const auto warp = quality.warp == Warp::points ? scene::warpPoints
                      : quality.warp == Warp::mesh ? scene::warpMesh
                                                   : scene::warpSplats;
    warp(blocks, warped, options, zBuffer);
    const PlaceSteps places = quality.warp == Warp::points ? placeStepsOfPoints() : placeStepsOfSplats();
    if (quality.resolutionScale != 1) return enlargedByPlaces(zBuffer, places, eye.camera.width, eye.camera.height);
    if (isInterpolated) return interpolated(zBuffer, places);
    if (!quality.isBlended) return scene::resolve(zBuffer);
    return scene::resolve(zBuffer, scene::warpBlend(blocks, eye, quality.blend, zBuffer));
}

scene::EyeImage interpolated(const scene::ZBuffer& zBuffer, const PlaceSteps& places) {
    scene::EyeImage eye = scene::resolve(zBuffer);
    const auto at = [&](int x, int y) {
        const bool isInside = x >= 0 && y >= 0 && x < zBuffer.width() && y < zBuffer.height();
        const std::uint64_t key = isInside ? zBuffer(x, y) : 0;
        return uvec2(static_cast<uint>(key), static_cast<uint>(key >> 32));
    };
    for (int y = 0; y < zBuffer.height(); ++y)
        for (int x = 0; x < zBuffer.width(); ++x) {
            if (zBuffer(x, y) == 0) continue;
            const uvec2 own = at(x, y);
            const ivec2 way = wayAcross(placeOf(own, places));
            const uint mean =
                interpolatedColour(own, at(x + way.x, y), at(x, y + way.y), at(x + way.x, y + way.y), way, places);
            const auto byte = [&](int shift) { return static_cast<std::uint8_t>(mean >> shift & 255u); };
            eye.colour(x, y) = {byte(0), byte(8), byte(16)};
        }
    return eye;
}

scene::EyeImage enlargedByPlaces(const scene::ZBuffer& zBuffer, const PlaceSteps& places, int width, int height) {
    scene::EyeImage eye{{width, height}, {width, height}, {width, height}};
    const auto keyAt = [&](uint x, uint y) {
        const std::uint64_t key = zBuffer(static_cast<int>(x), static_cast<int>(y));
        return uvec2(static_cast<uint>(key), static_cast<uint>(key >> 32));
    };
    const auto pixelAt = [&](uint x, uint y) {
        const uvec2 key = keyAt(x, y);
        return colourAndClassOf(key) | placeKept(key);
    };
    const auto inside = [](uint at, int step, int size) {
        return static_cast<uint>(std::clamp(static_cast<int>(at) + step, 0, size - 1));
    };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const Between column = betweenOf(static_cast<uint>(x), static_cast<uint>(zBuffer.width()),
                                             static_cast<uint>(width)),
                          row = betweenOf(static_cast<uint>(y), static_cast<uint>(zBuffer.height()),
                                          static_cast<uint>(height));
            const uint nearX = column.isNearLast != 0 ? column.last : column.first,
                       nearY = row.isNearLast != 0 ? row.last : row.first, nearest = pixelAt(nearX, nearY);
            const ivec2 centre(nearestCentre(static_cast<uint>(x), nearX, static_cast<uint>(zBuffer.width()),
                                             static_cast<uint>(width)),
                               nearestCentre(static_cast<uint>(y), nearY, static_cast<uint>(zBuffer.height()),
                                             static_cast<uint>(height))),
                own = sampleFrom(centre, placeInPixel(nearest, places)), way = wayAcross(own);
            const auto pixelAside = [&](const ivec2& side) {
                return pixelAt(inside(nearX, side.x, zBuffer.width()), inside(nearY, side.y, zBuffer.height()));
            };
            const ivec2 sideways(way.x, 0), down(0, way.y);
            const uint beside = pixelAside(sideways), over = pixelAside(down), across = pixelAside(way);
            const auto sampleAside = [&](const ivec2& side, uint pixel) {
                return sampleFrom(centre + kPerPixel * side, placeInPixel(pixel, places));
            };
            const auto isTaken = [&](uint pixel) { return kindOf(pixel) == kindOf(nearest); };
            const uint mean = mixed({own, sampleAside(sideways, beside), sampleAside(down, over),
                                     sampleAside(way, across), isTaken(beside), isTaken(over), isTaken(across)},
                                    nearest, beside, over, across);
            const auto byte = [&](int shift) { return static_cast<std::uint8_t>(mean >> shift & 255u); };
            eye.colour(x, y) = {byte(0), byte(8), byte(16)};
            eye.pixelClass(x, y) = byte(24);
            eye.depthMetres(x, y) = depthOf(keyAt(nearX, nearY));
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
