#include "tests/bench/position_pictures.h"

#include "scene/capture/polygon_view.h"
#include "scene/plan/walk_cells.h"
#include "scene/warp.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <glm/geometric.hpp>
#include <tbb/parallel_for.h>

namespace {

constexpr int kFaceSize = 256;
const scene::Camera kCamera{240, 180, 120, 120, 120, 90};

struct Errors {
    double squaresSeen = 0, squares = 0;
    std::int64_t seen = 0;
};

Errors compare(const scene::EyeImage& drawn, const scene::Image<scene::Rgb8>& truth) {
    Errors errors;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        const scene::Rgb8 a = drawn.colour.pixels()[i], b = truth.pixels()[i];
        const double dr = a.r - b.r, dg = a.g - b.g, db = a.b - b.b, square = (dr * dr + dg * dg + db * db) / 3;
        errors.squares += square;
        if (drawn.pixelClass.pixels()[i] == 0) continue;
        errors.squaresSeen += square;
        ++errors.seen;
    }
    return errors;
}

double psnr(double squares, std::int64_t pixels) {
    constexpr double kWhite = 255;
    return 10 * std::log10(kWhite * kWhite * static_cast<double>(pixels) / squares);
}

} // namespace

PositionPictures::PositionPictures(const scene::PolygonTracer& tracer, std::span<const glm::dvec3> places)
    : tracer_(tracer), light_(tracer, {}) {
    std::mt19937 generator(2002);
    std::uniform_real_distribution<double> turn(0, 2 * std::numbers::pi), tilt(-0.3, 0.3);
    for (const glm::dvec3& place : places) {
        const double yaw = turn(generator), pitch = tilt(generator);
        const glm::dvec3 ahead(std::cos(pitch) * std::sin(yaw), std::sin(pitch), -std::cos(pitch) * std::cos(yaw));
        const glm::dvec3 right = glm::normalize(glm::cross(ahead, glm::dvec3(0, 1, 0)));
        views_.push_back({kCamera, {glm::dmat3(right, glm::cross(ahead, right), ahead), place}});
        truths_.push_back(scene::renderPolygons(tracer, light_, views_.back()).colour);
    }
}

const std::vector<CapturedFace>& PositionPictures::cubeAt(const glm::dvec3& position) {
    const auto [there, isNew] = cubes_.try_emplace({position.x, position.y, position.z});
    if (isNew) there->second = captureForWarp(tracer_, light_, position, kFaceSize);
    return there->second;
}

PictureQuality PositionPictures::qualityOf(std::span<const glm::dvec3> positions) {
    std::vector<const std::vector<CapturedFace>*> cubes;
    for (const glm::dvec3& position : positions)
        cubes.push_back(&cubeAt(position));
    const scene::WalkCells cells(positions);
    return qualityBy([&](const scene::View& view) {
        std::uint32_t cell = 0;
        std::vector<scene::TileBlock> blocks;
        for (const std::uint32_t position : cells.cornersAt(view.worldFromEye.translation, cell))
            addBlocks(*cubes[position], blocks);
        return blocks;
    });
}

PictureQuality PositionPictures::qualityBy(const BlocksFor& blocksFor) const {
    std::vector<PictureQuality> each(views_.size());
    tbb::parallel_for(std::size_t{0}, views_.size(), [&](std::size_t i) {
        const scene::View& view = views_[i];
        const std::vector<scene::TileBlock> blocks = blocksFor(view);
        scene::ZBuffer zBuffer(kCamera.width, kCamera.height);
        scene::warpMesh(blocks, view, {}, zBuffer);
        const Errors errors = compare(scene::resolve(zBuffer), truths_[i]);
        const auto pixels = static_cast<std::int64_t>(truths_[i].size());
        each[i] = {psnr(errors.squaresSeen, errors.seen), psnr(errors.squares, pixels),
                   1 - static_cast<double>(errors.seen) / static_cast<double>(pixels)};
    });
    PictureQuality mean;
    double viewsWithAny = 0;
    for (const PictureQuality& one : each) {
        mean.psnrAll += one.psnrAll / static_cast<double>(views_.size());
        mean.holeShare += one.holeShare / static_cast<double>(views_.size());
        if (one.holeShare == 1) continue;
        mean.psnrSeen += one.psnrSeen;
        ++viewsWithAny;
    }
    mean.psnrSeen /= std::max(viewsWithAny, 1.0);
    return mean;
}
