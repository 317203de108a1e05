// capture: a polygon scene -> reference positions -> depth image files.

#include "app/build_stages.h"
#include "app/progress.h"
#include "app/search_positions.h"

#include "scene/capture/free_space.h"
#include "scene/capture/spread_positions.h"
#include "scene/depth_tiff.h"
#include "scene/errors.h"
#include "scene/import/polygons.h"

#include <cstdio>
#include <optional>

namespace app {

namespace {

using nlohmann::json;

/// Changed whenever what a position looks like changes, so that results of older versions are not taken for new ones.
constexpr int kCaptureVersion = 2;
constexpr int kSearchVersion = 3; ///< the same for where positions stand

json numbersOf(const glm::vec3& v) {
    return {v.x, v.y, v.z};
}

/// p000, p001, ...
std::string nameOf(std::size_t position) {
    char name[32];
    std::snprintf(name, sizeof name, "p%03zu", position);
    return name;
}

json fingerprintsOf(const scene::PolygonScene& polygons) {
    json files = json::array();
    for (const std::filesystem::path& file : polygons.files)
        files.push_back(fingerprintOf(file));
    return files;
}

std::string keyOfPosition(const json& files, const std::string& name, const glm::dvec3& p, const BuildOptions& o) {
    const scene::PolygonViewOptions& view = o.polygonView;
    return keyOf({kCaptureVersion,
                  files,
                  name,
                  {p.x, p.y, p.z},
                  o.faceSize,
                  {view.raysAcross, view.colourStep, view.sameDepth},
                  describeLight(o.light)});
}

/// Spread and searched ones are kept: to look round from every candidate takes a while.
void choosePositions(const scene::PolygonTracer& tracer, const json& files, const BuildOptions& options,
                     StageStore& store, PolygonFigures& figures) {
    const PositionsWish& wish = options.positions;
    if (!wish.file.empty()) {
        figures.positionsInWorld = readPositionsFile(wish.file);
        checkPositions(tracer, figures.positionsInWorld, wish.file);
        return;
    }
    const int count = wish.isSearched && options.mostPositions > 0 ? options.mostPositions : wish.count;
    const std::string key = keyOf({kCaptureVersion, kSearchVersion, files, count, wish.isSearched});
    const std::filesystem::path folder = store.find("positions", key, [&](const std::filesystem::path& part) {
        const SearchedPositions searched =
            wish.isSearched ? searchPositions(tracer, count) : SearchedPositions{spreadPositions(tracer, count), {}, 0};
        json list = json::array();
        for (const glm::dvec3& p : searched.positions)
            list.push_back({p.x, p.y, p.z});
        writeWhole(
            part / "positions.json",
            json{{"positions", list}, {"unknown_shares", searched.unknownShares}, {"trials", searched.trials}}.dump());
    });
    figures.positionsInWorld = readPositionsFile(folder / "positions.json");
    const json kept = readJson(folder / "positions.json");
    figures.unknownShares = kept.at("unknown_shares").get<std::vector<double>>();
    figures.trials = kept.at("trials");
}

/// The first position, towards where one sees farthest.
scene::WalkStart findStart(const scene::PolygonTracer& tracer, const glm::dvec3& position) {
    constexpr double kTallestMetres = 3.0; // a floor that is farther below is no walker's
    constexpr int kSides = 4, kGrid = scene::kLeastFaceSize;
    const glm::dvec3 kAhead(0.4, 0.4, 1);
    scene::WalkStart start;
    const std::optional<scene::PolygonHit> floor = tracer.cast(position, {0, -1, 0});
    if (floor && floor->t <= kTallestMetres) start.eyeMetres = floor->t;
    double farthest = 0;
    for (int side = 0; side < kSides; ++side) {
        const scene::View view = scene::faceView(side, position, scene::kLeastFaceSize);
        double sum = 0;
        for (int i = 0; i < kGrid * kGrid; ++i) {
            // What counts lies ahead: to the sides of an aisle there are walls.
            const glm::dvec3 ray = scene::rayThrough(view.camera, i % kGrid + 0.5, i / kGrid + 0.5) * kAhead;
            const std::optional<scene::PolygonHit> hit = tracer.cast(position, view.worldFromEye.rotation * ray);
            if (hit) sum += hit->t;
        }
        if (sum <= farthest) continue;
        farthest = sum;
        start.image = static_cast<std::size_t>(side);
    }
    return start;
}

} // namespace

json describeLight(const scene::CaptureLight& light) {
    return {{"towards_sun", {light.towardsSun.x, light.towardsSun.y, light.towardsSun.z}},
            {"sun", numbersOf(light.sun)},
            {"zenith", numbersOf(light.zenith)},
            {"horizon", numbersOf(light.horizon)},
            {"ground", numbersOf(light.ground)},
            {"fill", numbersOf(light.fill)},
            {"strengths", {light.sunStrength, light.skyStrength, light.fillStrength}},
            {"fill_reach_m", light.fillReachMetres},
            {"rays", light.rays},
            {"spacing_m", light.spacingMetres},
            {"white", light.white}};
}

ImportedImages capturePolygons(scene::Capture& capture, const BuildOptions& options, StageStore& store) {
    const scene::PolygonScene polygons = scene::readPolygons(capture.polygons.front());
    for (const std::string& remark : polygons.remarks)
        tell(capture, remark);
    const scene::PolygonTracer tracer(polygons);
    const json files = fingerprintsOf(polygons);

    ImportedImages imported;
    imported.uprightInWorld = {0, 1, 0};
    imported.polygons = {countTriangles(polygons),
                         std::ssize(polygons.instances),
                         std::ssize(polygons.materials),
                         std::ssize(polygons.textures),
                         {},
                         {},
                         0};
    choosePositions(tracer, files, options, store, imported.polygons);
    const std::vector<glm::dvec3>& positions = imported.polygons.positionsInWorld;
    imported.start = findStart(tracer, positions.front());

    std::optional<scene::SurfaceLight> light; // not needed where all is there already
    std::vector<std::string> keys;
    Progress progress("ray tracing", positions.size() * scene::kFaceCount);
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const std::string name = nameOf(i);
        keys.push_back(keyOfPosition(files, name, positions[i], options));
        std::size_t told = 0;
        const std::filesystem::path folder =
            store.find("position", keys.back(), [&](const std::filesystem::path& part) {
                if (!light) light.emplace(tracer, options.light);
                scene::captureCube(tracer, *light, name, positions[i], options.faceSize, options.polygonView,
                                   [&](const scene::DepthImage& face) {
                                       writeDepthTiff(face, part / (face.name + ".tiff"));
                                       progress.advance();
                                       ++told;
                                   });
            });
        if (told == 0) progress.advance(scene::kFaceCount);
        for (int face = 0; face < scene::kFaceCount; ++face) {
            const scene::View view = scene::faceView(face, positions[i], options.faceSize);
            const std::string faceName = name + "-" + scene::kFaceNames[static_cast<std::size_t>(face)];
            imported.images.push_back({faceName, view.camera, view.worldFromEye, folder / (faceName + ".tiff"), {}});
        }
    }
    imported.key = keyOf(keys);
    return imported;
}

} // namespace app
