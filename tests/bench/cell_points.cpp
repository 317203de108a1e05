// The further work that the article on Delaunay cells names: to each cell its own set of points, made of the images of
// its corners without what they have twice, instead of whole images. What is drawn of both in the walkers' cells, what
// all cells together take to store, and how it looks.
//
//   revisit_cell_points OUT.json SCENE.obj COUNT

#include "tests/bench/position_pictures.h"

#include "scene/capture/spread_positions.h"
#include "scene/errors.h"
#include "scene/import/polygons.h"
#include "scene/plan/sight_search.h"
#include "scene/plan/walk_cells.h"
#include "scene/refine/redundancy.h"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include <nlohmann/json.hpp>

namespace {

using nlohmann::json;

/// What a cell draws.
struct Bound {
    std::vector<CapturedFace> faces;
    std::int64_t whole = 0, kept = 0; ///< samples with surface
};

Bound boundOf(PositionPictures& pictures, const std::vector<glm::dvec3>& corners, float baselineShare) {
    std::vector<scene::DepthImage> images;
    for (const glm::dvec3& corner : corners)
        for (const CapturedFace& face : pictures.cubeAt(corner))
            images.push_back(face.image);
    std::vector<scene::ImageOutline> outlines;
    for (const scene::DepthImage& image : images)
        outlines.push_back(outlineOf(image));
    scene::ImageStore store(images);
    scene::RedundancyOptions options;
    options.baselineShare = baselineShare;
    scene::RedundancyFigures figures;
    const std::vector<scene::KeepMap> kept = findKept(store, scene::findPartners(outlines), options, figures);
    Bound bound;
    bound.whole = figures.samples, bound.kept = figures.base + figures.directional;
    for (std::size_t i = 0; i < images.size(); ++i) {
        scene::DepthImage& image = images[i];
        for (int y = 0; y < image.flags.height(); ++y)
            for (int x = 0; x < image.flags.width(); ++x)
                if (!kept[i].has(x, y)) image.flags(x, y) |= scene::kRedundant;
        scene::TileSet tiles = scene::cutIntoTiles(image);
        bound.faces.push_back({std::move(image), std::move(tiles)});
    }
    return bound;
}

std::int64_t samplesOf(const std::vector<CapturedFace>& faces) {
    std::int64_t samples = 0;
    for (const CapturedFace& face : faces)
        samples += std::ssize(face.tiles.vertices);
    return samples;
}

json describe(const PictureQuality& quality) {
    return {{"psnr_seen_db", quality.psnrSeen}, {"psnr_all_db", quality.psnrAll}, {"hole_share", quality.holeShare}};
}

json boundToCells(PositionPictures& pictures, const std::vector<glm::dvec3>& positions) {
    const scene::WalkCells cells(positions);
    json result{{"positions", positions.size()}, {"cells", cells.cells().size()}};
    std::int64_t storedWhole = 0;
    for (const glm::dvec3& position : positions)
        storedWhole += samplesOf(pictures.cubeAt(position));
    const auto cornersOf = [&](const scene::WalkCell& cell) {
        std::vector<glm::dvec3> corners;
        for (int i = 0; i <= cells.dimension(); ++i)
            corners.push_back(cells.corners()[cell.corners[i]]);
        return corners;
    };
    const auto judge = [&](const char* name, const std::vector<std::vector<const std::vector<CapturedFace>*>>& facesOf,
                           std::int64_t stored) {
        std::atomic<std::int64_t> drawn = 0;
        std::atomic<int> views = 0;
        const PictureQuality quality = pictures.qualityBy([&](const scene::View& view) {
            std::vector<scene::TileBlock> blocks;
            for (const std::vector<CapturedFace>* faces : facesOf[cells.locate(view.worldFromEye.translation)]) {
                addBlocks(*faces, blocks);
                drawn += samplesOf(*faces);
            }
            ++views;
            return blocks;
        });
        result[name] = describe(quality);
        result[name]["samples_stored"] = stored;
        result[name]["samples_drawn_mean"] = drawn / std::max(1, views.load());
    };

    std::vector<std::vector<const std::vector<CapturedFace>*>> wholeOf;
    for (const scene::WalkCell& cell : cells.cells()) {
        wholeOf.emplace_back();
        for (const glm::dvec3& corner : cornersOf(cell))
            wholeOf.back().push_back(&pictures.cubeAt(corner));
    }
    judge("whole_images", wholeOf, storedWhole);
    for (const auto& [name, baselineShare] :
         {std::pair("points_once", 0.0f), std::pair("points_by_direction", scene::RedundancyOptions{}.baselineShare)}) {
        std::vector<Bound> bound;
        std::vector<std::vector<const std::vector<CapturedFace>*>> facesOf;
        std::int64_t stored = 0;
        for (const scene::WalkCell& cell : cells.cells()) {
            bound.push_back(boundOf(pictures, cornersOf(cell), baselineShare));
            stored += bound.back().kept;
        }
        for (const Bound& one : bound)
            facesOf.push_back({&one.faces});
        judge(name, facesOf, stored);
    }
    return result;
}

/// Every so many of the places.
std::vector<glm::dvec3> someOf(const std::vector<glm::dvec3>& places, std::size_t count) {
    std::vector<glm::dvec3> some;
    for (std::size_t i = 0; i < count; ++i)
        some.push_back(places[(2 * i + 1) * places.size() / (2 * count)]);
    return some;
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 4 || std::atoi(argv[3]) < 1) {
        std::fprintf(stderr, "usage: revisit_cell_points OUT.json SCENE.obj COUNT\n");
        return 2;
    }
    try {
        constexpr std::size_t kViews = 100;
        const scene::PolygonScene polygons = scene::readPolygons(argv[2]);
        const scene::PolygonTracer tracer(polygons);
        const std::vector<glm::dvec3> places = scene::standingPlaces(tracer);
        scene::SightSearchOptions options;
        options.count = std::atoi(argv[3]);
        PositionPictures pictures(tracer, someOf(places, kViews));
        const json result = boundToCells(pictures, searchBySight(places, sightLinesOf(tracer), options).positions);
        std::ofstream(argv[1]) << result.dump(1) << "\n";
        std::printf("%s\n", result.dump(1).c_str());
    } catch (const scene::Failure& failure) {
        std::fprintf(stderr, "revisit_cell_points: %s\n", failure.what());
        return 1;
    }
}
