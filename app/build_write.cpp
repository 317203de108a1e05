// The scene folder: images, tiles and manifest, under a temporary name until all is there.

#include "app/build_stages.h"
#include "app/progress.h"
#include "app/say.h"
#include "app/scene_folder.h"
#include "app/version.h"
#include "app/walkers_files.h"

#include "scene/camera_json.h"
#include "scene/depth_tiff.h"
#include "scene/errors.h"
#include "scene/import/photo.h"
#include "scene/scene_file.h"
#include "scene/unfinished_file.h"

#include <unistd.h>

namespace app {

namespace {

using nlohmann::json;

json describeOptions(const BuildOptions& o) {
    return {{"hold_out", o.holdOut},
            {"register", o.registration},
            {"scanner", o.scanner.string()},
            {"colour_even", o.evenColour},
            {"camera", o.camera.string()},
            {"cull", o.cull},
            {"fuse", o.fuse},
            {"silhouettes", o.settleSilhouettes},
            {"tile_size", o.pyramid.tileSize},
            {"mesh_tolerance", o.pyramid.facetTolerance},
            {"skin_planarity", o.skins.planarity},
            {"open_sky", o.cubeFaces.opensSky},
            {"same_surface", o.skins.comparison.sameSurface},
            {"cull_preference", o.redundancy.preference},
            {"cull_baseline_share", o.redundancy.baselineShare},
            {"cull_patch", o.redundancy.minPatchShare},
            {"guess_radius", o.guesses.radius},
            {"dropout_radius", o.dropouts.radius},
            {"fusion_angle_rad", o.fusion.angleRadians},
            {"fusion_colour_step", o.fusion.colourStep}};
}

/// What was built and what was not, and why, in words for info.
json explain(const scene::Capture& capture, const ImportedImages& imported, const Overlaps& overlaps,
             const BuildOptions& o) {
    json reasons = json::array();
    if (!capture.polygons.empty())
        reasons.push_back("ray-traced: " + std::to_string(imported.polygons.triangles) + " triangles from " +
                          std::to_string(imported.polygons.positionsInWorld.size()) + " positions, six images of " +
                          std::to_string(o.faceSize) + "x" + std::to_string(o.faceSize) +
                          " each, in diffuse light: sun, sky, " + "what they throw back once, and a fill");
    else
        reasons.push_back("depth images: " + std::to_string(capture.photos.size()) + " photographs and " +
                          std::to_string(capture.scans.size()) + " scans in the capture");
    if (!imported.photographs.is_null())
        reasons.push_back(
            std::to_string(std::count_if(imported.photographs.begin(), imported.photographs.end(),
                                         [](const json& photo) { return photo.at("used").get<bool>(); })) +
            " of " + std::to_string(imported.photographs.size()) +
            " photographs beside scans, with the range of those scans");
    reasons.push_back(overlaps.pairs > 0
                          ? "skins, redundancy and fusion over " + std::to_string(overlaps.pairs) + " overlapping pairs"
                          : std::string("skins by planarity alone: no two images overlap"));
    if (!o.cull) reasons.push_back("no culling: every sample is kept, as asked");
    reasons.push_back(o.findUnseen ? "coverage: what no image observed is shown as unseen"
                                   : "no coverage (--coverage builds it): nothing is shown as unseen");
    if (!imported.polygons.unknownShares.empty()) {
        char share[32];
        std::snprintf(share, sizeof share, "%.2f %%", 100 * imported.polygons.unknownShares.back());
        reasons.push_back("positions were searched for, in " + std::to_string(imported.polygons.trials) +
                          " trials: of what is seen where one can stand, " + share +
                          " is unknown to the images of the walk cell there, if only those were drawn");
    }
    if (!o.fuse) reasons.push_back("no fusion: samples stay as captured, as asked");
    return reasons;
}

/// Null if it is without end, or around nothing.
json describe(const scene::WorldExtent& box) {
    if (!box.isFinite()) return nullptr;
    return {box.least.x, box.least.y, box.least.z, box.most.x, box.most.y, box.most.z};
}

/// What was ray-traced, and in what light; null for other captures.
json describePolygons(const PolygonFigures& polygons, const BuildOptions& options) {
    if (polygons.positionsInWorld.empty()) return nullptr;
    json positions = json::array();
    for (const glm::dvec3& p : polygons.positionsInWorld)
        positions.push_back({p.x, p.y, p.z});
    return {{"unknown_shares", polygons.unknownShares},
            {"search_trials", polygons.trials},
            {"triangles", polygons.triangles},
            {"instances", polygons.instances},
            {"materials", polygons.materials},
            {"textures", polygons.textures},
            {"face_size", options.faceSize},
            {"positions", positions},
            {"light", describeLight(options.light)}};
}

/// Paths need not be UTF-8, JSON must.
std::string textOf(const json& manifest) {
    return manifest.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

void copyFile(const std::filesystem::path& from, const std::filesystem::path& to) {
    std::error_code error;
    std::filesystem::copy_file(from, to, error);
    if (error) throw scene::Failure("cannot be copied (" + error.message() + ")", from, scene::kWriteRemedy);
}

void writeImages(const std::filesystem::path& folder, const ImportedImages& imported, const TileStage& tiles,
                 const BuildOptions& options) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) throw scene::Failure("cannot be made (" + error.message() + ")", folder, scene::kWriteRemedy);
    Progress progress("images", imported.images.size());
    const scene::ImageStore images(imported.images, options.memoryBytes / 2); // lends none: says how many have room
    scene::visitEach(images, 1, [&](std::size_t i) {
        scene::DepthImage image = scene::readDepthTiff(imported.images[i].file);
        image.name = imported.images[i].name;
        image.flags = scene::readFlagsTiff(tiles.flags[i], image.camera);
        writeDepthTiff(image, folder / (image.name + ".tiff"));
        progress.advance();
    });
}

/// The photographs that were kept out, as depth images: what the scene is measured against (scene/scene_file.h).
void writeHeldOut(const std::filesystem::path& folder, const scene::Capture& capture,
                  const std::vector<std::size_t>& heldOut, const std::vector<scene::StoredImage>& ofScans,
                  std::uint64_t memoryBytes) {
    if (heldOut.empty() && ofScans.empty()) return;
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) throw scene::Failure("cannot be made (" + error.message() + ")", folder, scene::kWriteRemedy);
    scene::visitEach(heldOut.size(), photosTogether(capture.photos, memoryBytes), [&](std::size_t i) {
        const scene::DepthImage image = scene::readPhoto(capture.photos[heldOut[i]]);
        writeDepthTiff(image, folder / (image.name + ".tiff"));
    });
    for (const scene::StoredImage& image : ofScans)
        copyFile(image.file, folder / (image.name + ".tiff"));
}

} // namespace

void writeScene(const std::filesystem::path& output, const scene::Capture& capture,
                const std::vector<std::size_t>& heldOut, const std::vector<scene::StoredImage>& heldOutOfScans,
                const ImportedImages& imported, const Overlaps& overlaps, const SkinStage& skins, const KeepStage& kept,
                const TileStage& tiles, const CoverageStage& coverage, const BuildReports& reports,
                const BuildOptions& options) {
    const std::filesystem::path part = unfinishedSceneOf(output);
    std::error_code ignored;
    checkReplaceable(output, options.inputs); // hours have passed
    std::filesystem::remove_all(part, ignored);
    try {
        writeImages(part / "images", imported, tiles, options);
        writeHeldOut(part / scene::kHeldOutFolder, capture, heldOut, heldOutOfScans, options.memoryBytes);
        std::int64_t tileCount = 0, coarser = 0, quads = 0, points = 0, unmeasured = 0, facets = 0;
        std::vector<scene::WorldExtent> samplesInWorld(imported.images.size());
        const auto tilesOf = [&](std::size_t i) {
            scene::TileSet set = scene::unpackTiles(readWhole(tiles.blocks[i]), tiles.blocks[i].string());
            const scene::StoredImage& image = imported.images[i];
            samplesInWorld[i] = scene::boxAroundSamples(scene::lend(set, image.camera, image.worldFromCamera),
                                                        static_cast<double>(options.pyramid.facetTolerance));
            tileCount += std::ssize(set.tiles), quads += std::ssize(set.quads);
            coarser += std::ssize(set.coarser), facets += std::ssize(set.facets);
            for (const scene::Tile& tile : set.tiles) {
                points += tile.pointCount;
                unmeasured += scene::isMeasured(tile.tier) ? 0 : tile.pointCount;
            }
            return set;
        };
        scene::writeTilesFile(part / "tiles.bin", imported.images.size(), tilesOf);
        if (!coverage.file.empty()) copyFile(coverage.file, part / scene::kCoverageFile);

        json images = json::array(), heldOutCameras = json::array(), inputs = json::array();
        json contradictions = capture.isOfPhotographsAlone() ? json::array() : json();
        for (const scene::Contradiction& c : skins.contradictions)
            contradictions.push_back({{"image", imported.images[c.image].name}, {"share", c.share}});
        for (std::size_t i = 0; i < imported.images.size(); ++i) {
            const scene::StoredImage& image = imported.images[i];
            images.push_back(describeCamera(image.name, image.camera, image.worldFromCamera));
            images.back()["samples_in_world"] = describe(samplesInWorld[i]);
        }
        for (const std::size_t i : heldOut)
            heldOutCameras.push_back(
                describeCamera(capture.photos[i].name, capture.photos[i].camera, capture.photos[i].worldFromCamera));
        for (const scene::StoredImage& image : heldOutOfScans)
            heldOutCameras.push_back(describeCamera(image.name, image.camera, image.worldFromCamera));
        for (const auto& input : options.inputs)
            inputs.push_back(input.string());

        json manifest{{"revisit", "scene"},
                      {"version", 1},
                      {"program", kVersion},
                      {"provenance", {{"inputs", inputs}, {"remarks", capture.remarks}}},
                      {"options", describeOptions(options)},
                      {"built", explain(capture, imported, overlaps, options)},
                      {"images", images},
                      {"held_out", heldOutCameras},
                      {"whole_images", !options.cull},
                      {"walk_from_world", scene::rowMajor({})},
                      {"polygons", describePolygons(imported.polygons, options)},
                      {"registration", reports.registration},
                      {"scan_agreement", reports.scanAgreement},
                      {"poses", reports.poses},
                      {"colour_evening", reports.evening},
                      {"contradictions", contradictions},
                      {"silhouettes", reports.silhouettes},
                      {"photograph_evening", reports.photographEvening},
                      {"photographs", imported.photographs},
                      {"coverage", !coverage.file.empty()},
                      {"figures",
                       {{"images", imported.images.size()},
                        {"overlapping_pairs", overlaps.pairs},
                        {"shown_median_m", overlaps.medianMetres},
                        {"shown_nearly_all_m", overlaps.nearlyAllMetres},
                        {"samples", kept.figures.samples},
                        {"samples_base", kept.figures.base},
                        {"samples_directional", kept.figures.directional},
                        {"samples_closed", unmeasured - kept.figures.guesses},
                        {"samples_floating", skins.figures.floating},
                        {"guesses_confirmed", skins.figures.confirmed},
                        {"guesses_refuted", skins.figures.refuted},
                        {"guesses_open", skins.figures.guesses},
                        {"guesses_kept", kept.figures.guesses},
                        {"triangles", skins.figures.triangles},
                        {"triangles_skin_planarity", skins.figures.planarSkins},
                        {"triangles_skin_seen_through", skins.figures.seenThrough},
                        {"scan_points", imported.scanPoints.points},
                        {"scan_points_held", imported.scanPoints.held},
                        {"scan_points_dropped", imported.scanPoints.dropped},
                        {"coverage_nodes", coverage.figures.nodes},
                        {"coverage_cells_per_sample", coverage.figures.cellsPerSample},
                        {"coverage_finest_m", coverage.figures.finestMetres},
                        {"coverage_unseen_m3", coverage.figures.unseenCubicMetres},
                        {"coverage_surface_m3", coverage.figures.surfaceCubicMetres},
                        {"coverage_empty_m3", coverage.figures.emptyCubicMetres},
                        {"tiles", tileCount},
                        {"tiles_coarser", coarser},
                        {"facets_stored", facets},
                        {"points_stored", points},
                        {"quads_stored", quads}}}};
        writeWhole(part / "scene.json", textOf(manifest));

        // Read back, which checks every block, and lay walk space into what was built.
        const scene::Scene written = scene::openScene(part);
        manifest["walk_from_world"] =
            rowMajor(findWalkSpace(written.images, written.blocks, imported.uprightInWorld, imported.start));
        if (const std::optional<std::string> remark = remarkOnNotes(output, manifest)) sayNote(*remark);
        writeWhole(part / "scene.json", textOf(manifest));
        checkReplaceable(output, options.inputs);
        carryWalkersFiles(output, part);
        sync();
        putInPlace(part, output);
    } catch (...) {
        std::filesystem::remove_all(part, ignored);
        throw;
    }
}

} // namespace app
