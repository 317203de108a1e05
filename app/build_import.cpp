// import and project: what the capture lists -> depth image files.

#include "app/build_stages.h"
#include "app/progress.h"

#include "scene/align/scanner_file.h"
#include "scene/align/scanner_records.h"
#include "scene/depth_tiff.h"
#include "scene/errors.h"
#include "scene/image_store.h"
#include "scene/import/e57.h"
#include "scene/import/photo.h"
#include "scene/import/ptx.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <span>

#include <tbb/task_arena.h>
#include <tbb/task_group.h>

namespace app {

namespace {

using nlohmann::json;

/// Changed whenever what a stage computes changes, so that results of older versions are not taken for new ones.
constexpr int kImportVersion = 8;

/// Share of a scan's rays that is worth a word: a scanner that stands indoors has its own blind cone without range.
constexpr double kManyWithoutRange = 0.3;

json describe(const scene::Pose& pose) {
    json numbers = json::array();
    const glm::dmat4 m = toMatrix(pose);
    for (int i = 0; i < 16; ++i)
        numbers.push_back(m[i % 4][i / 4]);
    return numbers;
}

std::string keyOfPhoto(const scene::PhotoSource& photo, const BuildOptions& options) {
    const scene::DropoutOptions& dropouts = options.dropouts;
    const scene::GuessOptions& guesses = options.guesses;
    return keyOf({kImportVersion,
                  describeSource(photo),
                  {dropouts.radius, dropouts.sameSurface, dropouts.minSamples},
                  {guesses.radius, guesses.step, guesses.colourStep, guesses.sameSurface, guesses.minSamples}});
}

std::string keyOfScan(const scene::ScanSource& scan, const ScanPhotographs& photographs,
                      const scene::CubeFaceOptions& faces) {
    return keyOf({kImportVersion,
                  scan.name,
                  fingerprintOf(scan.path),
                  scan.indexInFile,
                  scan.byteInFile,
                  scan.registeredWorldFromScanner ? describe(*scan.registeredWorldFromScanner) : json(),
                  describeReading(scan),
                  photographs.key,
                  {faces.maxFaceSize, faces.sameSurface, faces.maxLayers, faces.opensSky}});
}

/// A face that is made and the one that is written meanwhile, each with its further layers, and the scan itself, which
/// has five points for each pixel of a face, stay within the memory that may be taken. As large as kAlways whatever
/// that is.
scene::CubeFaceOptions within(scene::CubeFaceOptions faces, std::uint64_t memoryBytes) {
    constexpr double kBytesPerPixel = 240;
    constexpr int kAlways = 4096;
    const double side = std::sqrt(static_cast<double>(memoryBytes) / kBytesPerPixel);
    faces.maxFaceSize =
        std::clamp(static_cast<int>(std::min(side, 1e6)), kAlways, std::max(kAlways, faces.maxFaceSize));
    return faces;
}

constexpr std::uint64_t kBytesPerPoint = 48; ///< of a scan that is read, its faces with it

bool lacksColour(const scene::DepthImage& face) {
    return std::ranges::any_of(face.flags.pixels(), [](std::uint8_t flags) {
        return scene::isSurface(flags) && (flags & scene::kNoColour) != 0;
    });
}

/// The faces of a scan and, in points.json, what became of its points.
void writeFaces(const scene::ScanSource& source, const ScanPhotographs& photographs,
                const scene::CubeFaceOptions& options, const std::filesystem::path& folder) {
    const scene::Scan scan = readScan(source);
    json names = json::array();
    std::vector<scene::DepthImage> finished; // one face's images, which are written while the next are made
    std::exception_ptr failure;              // of writing; kept, since two at a time would end the program
    const auto writeFinished = [&] {
        for (scene::DepthImage& face : finished) {
            if (lacksColour(face) && !photographs.images.empty()) {
                SampleColours colours(face);
                for (const scene::StoredImage& photograph : photographs.images)
                    if (colours.mayTake(photograph)) colours.take(scene::readDepthTiff(photograph.file));
                colours.give();
            }
            writeDepthTiff(face, folder / (face.name + ".tiff"));
        }
        finished.clear();
    };
    const auto write = [&] {
        try {
            writeFinished();
        } catch (...) {
            failure = std::current_exception();
        }
    };
    tbb::task_group writing;
    const auto waitForIt = [&] {
        writing.wait();
        if (failure) std::rethrow_exception(failure);
    };
    const scene::CubeFaceReport report =
        scene::projectToCubeFaces(scan, options, [&](std::vector<scene::DepthImage> layers) {
            for (const scene::DepthImage& face : layers)
                names.push_back(face.name);
            waitForIt();
            finished = std::move(layers);
            writing.run(write);
        });
    waitForIt();
    const glm::dvec3 up = scan.worldFromScanner.rotation[2];
    writeWhole(folder / "points.json", json{{"faces", names},
                                            {"points", report.points},
                                            {"held", report.held},
                                            {"dropped", report.dropped},
                                            {"coarser_than_scan", report.coarserThanScan},
                                            {"sky_share", report.skyShare},
                                            {"from_elsewhere", report.isFromElsewhere},
                                            {"up", {up.x, up.y, up.z}}}
                                           .dump());
}

scene::StoredImage storedImage(const std::filesystem::path& file) {
    const scene::DepthImage header = scene::readDepthTiffHeader(file);
    return {header.name, header.camera, header.worldFromCamera, file, {}};
}

} // namespace

std::size_t scansTogether(std::span<const scene::ScanSource> scans, std::uint64_t memoryBytes) {
    constexpr std::uint64_t kAlways = std::uint64_t{512} << 20; // faces of thinly spread points are larger than that
    std::uint64_t most = 1;
    for (const scene::ScanSource& scan : scans)
        most = std::max({most, static_cast<std::uint64_t>(std::max<std::int64_t>(scan.pointCount, 0)),
                         static_cast<std::uint64_t>(scan.rows) * static_cast<std::uint64_t>(scan.columns)});
    const std::uint64_t room = memoryBytes / (kAlways + kBytesPerPoint * std::min(most, memoryBytes / kBytesPerPoint));
    return std::clamp(static_cast<std::size_t>(room), std::size_t{1},
                      static_cast<std::size_t>(tbb::this_task_arena::max_concurrency()));
}

std::size_t photosTogether(std::span<const scene::PhotoSource> photos, std::uint64_t memoryBytes) {
    constexpr std::uint64_t kBytesPerPixel = 32; // the pictures as they are read and the image that they become
    std::uint64_t most = 1;
    for (const scene::PhotoSource& photo : photos)
        most = std::max(most, static_cast<std::uint64_t>(photo.camera.width) *
                                  static_cast<std::uint64_t>(photo.camera.height));
    return std::clamp(static_cast<std::size_t>(memoryBytes / 2 / (kBytesPerPixel * most)), std::size_t{1},
                      static_cast<std::size_t>(tbb::this_task_arena::max_concurrency()));
}

json describeSource(const scene::PhotoSource& photo) {
    const scene::Camera& c = photo.camera;
    const scene::Distortion& d = photo.distortion;
    return {photo.name,
            fingerprintOf(photo.colourPath),
            fingerprintOf(photo.depthPath),
            {c.width, c.height, c.fx, c.fy, c.cx, c.cy},
            {d.k1, d.k2, d.p1, d.p2, d.k3},
            describe(photo.worldFromCamera),
            photo.depthUnitMetres ? json(*photo.depthUnitMetres) : json()};
}

json describeReading(const scene::ScanSource& scan) {
    if (!scan.reading) return nullptr;
    return {describeConstants(scan.reading->believed), describeConstants(scan.reading->constants)};
}

void standWhereFound(scene::Scan& scan, const scene::ScanSource& source) {
    if (source.reading)
        readAnew(scan, scene::recordsOf(scan, source.reading->believed, source.name), source.reading->constants);
    if (source.registeredWorldFromScanner) scan.worldFromScanner = *source.registeredWorldFromScanner;
}

void checkScanSizes(std::span<const scene::ScanSource> scans, std::uint64_t memoryBytes) {
    constexpr std::uint64_t kTooMany = std::uint64_t{1} << 31; // of a scan they are counted in 31 bits
    constexpr std::uint64_t kGigabyte = std::uint64_t{1} << 30;
    for (const scene::ScanSource& scan : scans) {
        const auto points = static_cast<std::uint64_t>(std::max<std::int64_t>(scan.pointCount, 0));
        if (points < kTooMany && points * kBytesPerPoint <= memoryBytes) continue;
        throw scene::Failure(
            "scan '" + scan.name + "' has " + std::to_string(points) + " points, and of one scan no more than " +
                std::to_string(std::min(memoryBytes / kBytesPerPoint, kTooMany - 1)) +
                " can be read with this computer's memory of " + std::to_string(memoryBytes / kGigabyte) + " GiB",
            scan.path, "export each setup by itself, or thinned");
    }
}

scene::Scan readScan(const scene::ScanSource& source) {
    scene::Scan scan =
        source.format == scene::ScanFormat::e57 ? scene::readE57Scan(source) : scene::readPtxScan(source);
    standWhereFound(scan, source);
    return scan;
}

scene::Failure nothingToBuild(const BuildOptions& options) {
    return {"holds no image or scan with range", options.inputs.front(),
            options.holdOut.empty() ? "check that its photographs have depth and its scans have points"
                                    : "check the capture, or hold out less"};
}

ImportedImages importImages(scene::Capture& capture, const std::vector<std::size_t>& heldOut,
                            const PhotographStage& photographs, const BuildOptions& options, StageStore& store) {
    ImportedImages imported;
    imported.photographs = photographs.report;
    std::vector<std::size_t> taken;
    for (std::size_t i = 0; i < capture.photos.size(); ++i)
        if (!std::binary_search(heldOut.begin(), heldOut.end(), i)) taken.push_back(i);

    std::vector<std::string> keys(taken.size());
    std::vector<scene::StoredImage> photos(taken.size());
    Progress progress("import", taken.size() + capture.scans.size());
    scene::visitEach(taken.size(), photosTogether(capture.photos, options.memoryBytes), [&](std::size_t i) {
        const scene::PhotoSource& photo = capture.photos[taken[i]];
        keys[i] = keyOfPhoto(photo, options);
        const std::filesystem::path folder = store.find("photo", keys[i], [&](const std::filesystem::path& part) {
            scene::DepthImage image = readPhoto(photo);
            fillDropouts(image, options.dropouts);
            guessRange(image, options.guesses);
            keepWithinPicture(image, photo);
            writeDepthTiff(image, part / "image.tiff");
        });
        photos[i] = {photo.name, photo.camera, photo.worldFromCamera, folder / "image.tiff", {}};
        progress.advance();
    });
    imported.images = std::move(photos);

    const scene::CubeFaceOptions cubeFaces = within(options.cubeFaces, options.memoryBytes);
    std::vector<std::filesystem::path> ofScan(capture.scans.size());
    for (std::size_t i = 0; i < capture.scans.size(); ++i)
        keys.push_back(keyOfScan(capture.scans[i], photographs.ofScan[i], cubeFaces));
    scene::visitEach(capture.scans.size(), scansTogether(capture.scans, options.memoryBytes), [&](std::size_t i) {
        ofScan[i] = store.find("scan", keys[taken.size() + i], [&](const std::filesystem::path& part) {
            writeFaces(capture.scans[i], photographs.ofScan[i], cubeFaces, part);
        });
        progress.advance();
    });
    for (std::size_t i = 0; i < capture.scans.size(); ++i) {
        const scene::ScanSource& scan = capture.scans[i];
        const ScanPhotographs& own = photographs.ofScan[i];
        const std::filesystem::path& folder = ofScan[i];
        imported.images.insert(imported.images.end(), own.images.begin(), own.images.end());
        const json points = readJson(folder / "points.json");
        const std::size_t firstFace = imported.images.size();
        for (const json& name : points.at("faces"))
            imported.images.push_back(storedImage(folder / (name.get<std::string>() + ".tiff")));
        imported.scanPoints.points += points.at("points").get<std::int64_t>();
        imported.scanPoints.held += points.at("held").get<std::int64_t>();
        imported.scanPoints.dropped += points.at("dropped").get<std::int64_t>();
        if (points.at("coarser_than_scan").get<bool>())
            tell(capture, "Scan '" + scan.name +
                              "' is denser than its images may be within --memory: where it is densest, several of its "
                              "points share a sample.");
        if (points.at("from_elsewhere").get<bool>())
            tell(capture, "The points of scan '" + scan.name +
                              "' cannot all have been seen from where its file has the scanner: they are drawn as from "
                              "a place amid them" +
                              (options.findUnseen ? ", and what was seen empty is reckoned from there, too" : "") +
                              ". Where several scans were merged, export each set-up by itself, with its own pose.");
        if (points.at("held") == 0) {
            imported.emptyScans.push_back(scan.name);
            continue;
        }
        imported.scans.push_back({scan.name, firstFace, imported.images.size() - firstFace});
        const double rays = static_cast<double>(scan.rows) * static_cast<double>(scan.columns);
        const double sky = points.at("sky_share").get<double>();
        const double without = rays > 0 ? 1 - points.at("points").get<double>() / rays - sky : 0;
        const auto percent = [](double share) { return std::to_string(static_cast<int>(100 * share)) + " %"; };
        if (cubeFaces.opensSky)
            tell(capture, sky > 0
                              ? percent(sky) + " of the rays of scan '" + scan.name +
                                    "' came back with nothing from above the horizon, and are taken for open sky, as "
                                    "--open-sky says."
                              : "Scan '" + scan.name + "' shows no open sky above its horizon, or has no even grid.");
        if (options.findUnseen && without > kManyWithoutRange)
            tell(capture,
                 "Of the rays of scan '" + scan.name + "' " + percent(without) +
                     " came back with nothing, and prove nothing: what lies along them is shown as unseen, "
                     "to eyes close beside the scanner, too; " +
                     (cubeFaces.opensSky ? "" : "--open-sky opens what is above the horizon, if that was the sky; ") +
                     "--hide-unseen shows the scene without.");
        for (int axis = 0; axis < 3; ++axis)
            imported.uprightInWorld[axis] += points.at("up").at(static_cast<std::size_t>(axis)).get<double>();
    }
    if (imported.images.empty()) throw nothingToBuild(options);
    imported.key = keyOf(keys);
    return imported;
}

} // namespace app
