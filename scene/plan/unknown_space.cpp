#include "scene/plan/unknown_space.h"

#include "scene/cube.h"
#include "scene/tile_warp.h"
#include "scene/warp.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scene {

namespace {

/// Where sky is put: far enough to stand behind everything, and no farther than a disparity that tiles can tell from 0.
constexpr float kSkyDisparity = 1e-5f;

/// Samples are squares of as many pixels as close the gaps between them, up to this: the article's were always of 2,
/// and surfaces near the walker came apart.
constexpr int kFootprint = 6;

View faceAbout(const glm::dvec3& place, const glm::dmat3& rotation, int size) {
    View view;
    view.camera = {size, size, 0.5 * size, 0.5 * size, 0.5 * size, 0.5 * size};
    view.worldFromEye.rotation = rotation;
    view.worldFromEye.translation = place;
    return view;
}

} // namespace

std::uint32_t UnknownSpace::add(std::span<const DepthImage> faces) {
    std::vector<Face> source;
    for (const DepthImage& given : faces) {
        DepthImage image = given;
        for (std::size_t i = 0; i < image.flags.size(); ++i) {
            std::uint8_t& flags = image.flags.pixels()[i];
            float& disparity = image.disparity.pixels()[i];
            if ((flags & kNoSurface) != 0 && disparity == 0)
                flags = 0, disparity = kSkyDisparity;
            else
                flags = static_cast<std::uint8_t>(flags & (kNoSurface | kFloating));
        }
        TileSet mesh = cutIntoTiles(image);
        source.push_back({std::move(image), std::move(mesh)});
    }
    sources_.push_back(std::move(source));
    return static_cast<std::uint32_t>(sources_.size() - 1);
}

UnknownCount UnknownSpace::countAt(const glm::dvec3& place, std::span<const std::uint32_t> positions) const {
    UnknownCount count;
    WarpOptions options;
    options.maxFootprint = kFootprint;
    options.preference.nearBaseline = 0; // keys are then disparities
    const int size = options_.faceSize;
    const float behind = static_cast<float>(1 - options_.samplesNearer);
    const auto tooNear = static_cast<float>(1 / options_.nearMetres);
    ZBuffer mesh(size, size), samples(size, size);
    Image<float> known(size, size);
    for (const glm::dmat3& faceFromCube : facesFromCube(0)) {
        const View view = faceAbout(place, glm::transpose(faceFromCube), size);
        std::fill(known.pixels().begin(), known.pixels().end(), 0.0f);
        for (const std::uint32_t position : positions) {
            std::vector<TileBlock> blocks;
            for (const Face& face : sources_[position])
                blocks.push_back(lend(face.mesh, face.image.camera, face.image.worldFromCamera));
            std::fill(mesh.pixels().begin(), mesh.pixels().end(), 0);
            std::fill(samples.pixels().begin(), samples.pixels().end(), 0);
            warpMesh(blocks, view, options, mesh);
            warpPoints(blocks, view, options, samples);
            for (std::size_t i = 0; i < known.size(); ++i) {
                const std::uint64_t sample = samples.pixels()[i];
                if (sample != 0 && eyeDisparityOf(sample) >= behind * eyeDisparityOf(mesh.pixels()[i]))
                    known.pixels()[i] = std::max(known.pixels()[i], eyeDisparityOf(sample));
            }
        }
        for (const float disparity : known.pixels()) {
            count.unknown += disparity > 0 ? 0 : 1;
            count.near += disparity > tooNear ? 1 : 0;
            ++count.pixels;
        }
    }
    return count;
}

bool UnknownSpace::isEmpty(const glm::dvec3& place, std::span<const std::uint32_t> positions,
                           double clearMetres) const {
    for (const std::uint32_t position : positions)
        for (const Face& face : sources_[position]) {
            const glm::dvec3 p = inverse(face.image.worldFromCamera) * place;
            if (!(p.z > 0)) continue;
            const Camera& camera = face.image.camera;
            const double u = camera.fx * p.x / p.z + camera.cx, v = camera.fy * p.y / p.z + camera.cy;
            if (!(u >= 0 && u < camera.width && v >= 0 && v < camera.height)) continue;
            const int x = static_cast<int>(u), y = static_cast<int>(v);
            if (!isSurface(face.image.flags(x, y))) continue;
            const double seen = 1 / static_cast<double>(face.image.disparity(x, y));
            if (seen >= p.z * (1 + clearMetres / glm::length(p))) return true;
        }
    return false;
}

} // namespace scene
