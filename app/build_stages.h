#pragma once
// The stages of a build as the command runs them: each takes the results of those before it, in files, and leaves its
// own.

#include "app/build_photographs.h"
#include "app/build_scene.h"
#include "app/stage_store.h"

#include "scene/errors.h"
#include "scene/image_store.h"
#include "scene/import/capture.h"
#include "scene/import/importer.h"
#include "scene/overlap.h"
#include "scene/refine/contradiction.h"
#include "scene/refine/cover.h"
#include "scene/scan.h"
#include "scene/scene.h"

#include <cstdint>
#include <numbers>
#include <span>

namespace app {

inline constexpr double kDegrees = 180 / std::numbers::pi; ///< in a radian: reports give angles in degrees

/// Light as scene.json and keys have it.
nlohmann::json describeLight(const scene::CaptureLight& light);

/// What to throw when a capture holds, or keeps back, nothing that can be seen.
scene::Failure nothingToBuild(const BuildOptions& options);

/// What polygons were captured from; positions are empty for other captures.
struct PolygonFigures {
    std::int64_t triangles = 0, instances = 0, materials = 0, textures = 0;
    std::vector<glm::dvec3> positionsInWorld;
    std::vector<double> unknownShares; ///< after each, where they were searched for
    std::int64_t trials = 0;           ///< sets of positions that the search weighed
};

/// What calibration and registration found of a scan that was read from its file.
void standWhereFound(scene::Scan& scan, const scene::ScanSource& source);
/// A scan is read whole. Throws scene::Failure if one has more points than that memory holds.
void checkScanSizes(std::span<const scene::ScanSource> scans, std::uint64_t memoryBytes);
/// A scan from its file, with what was found of it.
scene::Scan readScan(const scene::ScanSource& source);
/// How many scans may be read at a time within that memory, with what is made of them: reading one is the work of one
/// thread.
std::size_t scansTogether(std::span<const scene::ScanSource> scans, std::uint64_t memoryBytes);
/// How many photographs may be read at a time within half of that memory: one at least, no more than there are threads.
std::size_t photosTogether(std::span<const scene::PhotoSource> photos, std::uint64_t memoryBytes);
/// What the keys of stages must know of a photograph's files, camera and pose.
nlohmann::json describeSource(const scene::PhotoSource& photo);
/// Says a sentence to the user now, and keeps it for scene.json and info.
void tell(scene::Capture& capture, const std::string& sentence);
/// What of its reading the keys of stages must know.
nlohmann::json describeReading(const scene::ScanSource& scan);

/// align: where scans stand, as BuildOptions::registration asks; puts what it finds into the capture's scans, and what
/// there is to say into its remarks. Scans of which nobody knows where they stand are taken out of both, with the
/// photographs beside them. Returns the report that scene.json and info have; null where nothing was done.
nlohmann::json registerCapture(scene::Capture& capture, scene::HeldOut& heldOut, const BuildOptions& options,
                               StageStore& store);

/// align, too: where photographs with range stand in captures without scans, unless BuildOptions::registration is
/// given. Those held out are laid on the others, which know nothing of them. Puts what it finds into the capture's
/// photos, and what there is to say into its remarks. Returns the report that scene.json and info have; null where
/// nothing was done.
nlohmann::json adjustPoses(scene::Capture& capture, const std::vector<std::size_t>& heldOut,
                           const BuildOptions& options, StageStore& store);

/// A pose that a stage wrote into its file. Throws scene::Failure if it is none.
scene::Pose poseOf(const nlohmann::json& rows, const std::filesystem::path& file);

/// The faces of a scan, among images.
struct ScanFaces {
    std::string name;
    std::size_t first = 0, count = 0;
};

struct ImportedImages {
    std::vector<scene::StoredImage> images;
    std::vector<ScanFaces> scans; ///< those that hold anything
    std::string key;
    scene::CubeFaceReport scanPoints;    ///< summed over the scans
    std::vector<std::string> emptyScans; ///< names of those without a point
    glm::dvec3 uprightInWorld{0};        ///< scans and polygons say what is up; zero if there are none
    scene::WalkStart start;
    PolygonFigures polygons;
    nlohmann::json photographs = nullptr; ///< how those of scans were laid on them: what scene.json and info have
};
/// import and project: every photo and every face of every scan as a depth image file, beside the scans' photographs,
/// from which samples without colour take theirs. What there is to say goes to the capture's remarks. Throws
/// scene::Failure if there is none.
ImportedImages importImages(scene::Capture& capture, const std::vector<std::size_t>& heldOut,
                            const PhotographStage& photographs, const BuildOptions& options, StageStore& store);

/// capture: the faces of the cube about each reference position as depth image files. What the scene's file had to say
/// goes to capture.remarks. Throws scene::Failure.
ImportedImages capturePolygons(scene::Capture& capture, const BuildOptions& options, StageStore& store);

struct Overlaps {
    std::vector<std::vector<scene::Partner>> partners;
    std::int64_t pairs = 0;
    /// Of all that images show, along their axes: as far as half of it is, and as nearly all; 0 where they show
    /// nothing.
    double medianMetres = 0, nearlyAllMetres = 0;
};
Overlaps findOverlaps(const ImportedImages& imported, const BuildOptions& options);

/// refine, first part: a file of flags for each image.
struct SkinStage {
    std::vector<scene::StoredImage> images; ///< as imported, with the new flags
    scene::SkinFigures figures;             ///< summed over the images
    std::vector<scene::SkinFigures> ofImages;
    std::vector<scene::Contradiction> contradictions;
    std::string key;
};
SkinStage markSkins(const ImportedImages& imported, const Overlaps& overlaps, const BuildOptions& options,
                    StageStore& store);

/// refine, second part: a file for each image that says what is kept of it.
struct KeepStage {
    std::vector<std::filesystem::path> files;
    scene::RedundancyFigures figures;
    std::string key;
};
KeepStage keepBest(const ImportedImages& imported, const Overlaps& overlaps, const SkinStage& skins,
                   const BuildOptions& options, StageStore& store);

/// refine, before its first part, where asked for: images' exposure and white balance made even. Puts the changed
/// images in place of the imported ones. Returns the report that scene.json and info have; null where nothing was
/// asked.
/// spentStops: by which some were brightened before; what is done now keeps within the rest.
nlohmann::json evenImages(ImportedImages& imported, const Overlaps& overlaps, const BuildOptions& options,
                          StageStore& store, double spentStops = 0);

/// The same of the photographs beside scans, before the scans' samples take their colours from them: what is mixed of
/// uneven pictures no factor makes even.
nlohmann::json evenPhotographs(PhotographStage& photographs, const BuildOptions& options, StageStore& store);

/// refine, before its first part, of captures of photographs with range: samples beside silhouettes on the side where
/// the photographs agree. Puts the changed images in place of the imported ones. Returns the report that scene.json and
/// info have; null where nothing was asked.
nlohmann::json settleSilhouettes(ImportedImages& imported, const Overlaps& overlaps, const BuildOptions& options,
                                 StageStore& store);

/// refine, third part: fused and cut into tiles, a block of tiles and a file of final flags for each image.
struct TileStage {
    std::vector<std::filesystem::path> blocks, flags;
};
TileStage fuseAndCut(const ImportedImages& imported, const Overlaps& overlaps, const SkinStage& skins,
                     const KeepStage& kept, const BuildOptions& options, StageStore& store);

/// What was observed of space, and what nobody ever saw: a file.
struct CoverageStage {
    std::filesystem::path file; ///< empty: not built
    scene::CoverFigures figures;
};
CoverageStage coverSpace(const SkinStage& skins, const BuildOptions& options, StageStore& store);

/// What stages have to say to scene.json and info; null where one did nothing.
struct BuildReports {
    nlohmann::json registration, scanAgreement, poses, evening, photographEvening, silhouettes;
};

/// The scene folder, under a temporary name until it is whole.
void writeScene(const std::filesystem::path& output, const scene::Capture& capture,
                const std::vector<std::size_t>& heldOut, const std::vector<scene::StoredImage>& heldOutOfScans,
                const ImportedImages& imported, const Overlaps& overlaps, const SkinStage& skins, const KeepStage& kept,
                const TileStage& tiles, const CoverageStage& coverage, const BuildReports& reports,
                const BuildOptions& options);

} // namespace app
