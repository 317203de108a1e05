#include "app/build_photographs.h"

#include "app/build_stages.h"
#include "app/progress.h"

#include "scene/camera_json.h"
#include "scene/depth_tiff.h"
#include "scene/errors.h"
#include "scene/import/e57.h"
#include "scene/import/scan_photos.h"
#include "scene/project/photographs_on_scan.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>

#include <glm/geometric.hpp>
#include <tbb/parallel_for.h>

namespace app {

namespace {

using nlohmann::json;

/// Changed whenever what the stage computes changes, so that results of older versions are not taken for new ones.
constexpr int kPhotographsVersion = 8;
/// A turn within so many deviations is none: poses that are right stay what they are.
constexpr double kSameDeviations = 2;
constexpr double kSamePlace = 0.005;  ///< metres: from here a photograph sees all that an image sees
constexpr double kSameSurface = 0.03; ///< relative difference of disparity

const char* const kUnread = "cannot be read";

/// What becomes of a photograph, in words.
std::string verdictOf(const scene::ColourFit& fit, bool isMoved, bool isUsed) {
    if (fit.isSure) return isMoved ? "found" : "as given";
    return isUsed ? "not sure: kept as given" : "not sure: left out";
}

/// Writes the 3D photograph, if it is used, and says what became of it.
json write(const scene::PhotographForScan& photograph, const scene::ColourFit& fit, const std::string& name,
           const scene::ScanForPhotographs& scan, const BuildOptions& options, const std::filesystem::path& folder) {
    const scene::Pose& worldFromScanner = scan.scan.worldFromScanner;
    const bool isMoved = fit.isSure && fit.turnedRadians > kSameDeviations * fit.deviationRadians;
    bool isUsed = fit.isSure || !options.movesScans();
    std::string verdict = verdictOf(fit, isMoved, isUsed);
    scene::Pose scannerFromCamera = photograph.scannerFromGiven;
    if (isMoved) scannerFromCamera.rotation = scannerFromCamera.rotation * fit.givenFromFound;
    std::int64_t samples = 0;
    if (isUsed) {
        scene::DepthImage image = withRange(scan, photograph, scannerFromCamera, options.dropouts);
        samples = std::count_if(image.flags.pixels().begin(), image.flags.pixels().end(),
                                [](std::uint8_t flags) { return scene::isSurface(flags); });
        isUsed = samples > 0;
        if (!isUsed) verdict = "sees nothing of its scan: left out";
        image.name = name;
        image.worldFromCamera = worldFromScanner * scannerFromCamera;
        if (isUsed) writeDepthTiff(image, folder / (name + ".tiff"));
    }
    return {{"name", name},
            {"scan", scan.scan.name},
            {"verdict", verdict},
            {"used", isUsed},
            {"sure", fit.isSure},
            {"why", fit.why},
            {"turned_deg", fit.turnedRadians * kDegrees},
            {"deviation_deg", fit.deviationRadians * kDegrees},
            {"score", fit.score},
            {"rival_share", fit.rivalShare},
            {"agreeing", fit.agreeing},
            {"parts", fit.parts},
            {"neighbours", fit.neighbours},
            {"samples", samples},
            {"world_from_camera", scene::rowMajor(worldFromScanner * scannerFromCamera)},
            {"given_world_from_camera", scene::rowMajor(worldFromScanner * photograph.scannerFromGiven)}};
}

json describeUnread(const scene::ScanPhoto& photo, const std::string& scan, const std::string& why) {
    const json pose = scene::rowMajor(photo.worldFromCamera);
    return {{"name", photo.name},
            {"scan", scan},
            {"verdict", kUnread},
            {"used", false},
            {"sure", false},
            {"why", why},
            {"turned_deg", 0},
            {"deviation_deg", 0},
            {"score", 0},
            {"rival_share", 0},
            {"agreeing", 0},
            {"parts", 0},
            {"neighbours", 0},
            {"samples", 0},
            {"world_from_camera", pose},
            {"given_world_from_camera", pose}};
}

/// One scan at a time, and one photograph: the points of a single one may fill the memory. So photographs are read
/// twice, to find how they are turned and to be given their range. beside: others of the scan, which may say how these
/// are turned, and of which nothing is written.
json layOnTheirScan(const scene::ScanSource& source, std::span<const scene::ScanPhoto> photos,
                    std::span<const scene::ScanPhoto> beside, const BuildOptions& options, Progress& progress,
                    const std::filesystem::path& folder) {
    scene::ScanWithIntensity read = scene::readE57ScanWithIntensity(source);
    // Photographs' poses stand beside the pose that the file gives the scan.
    const scene::Pose scannerFromWorldInFile = inverse(read.scan.worldFromScanner);
    standWhereFound(read.scan, source);
    scene::ScanForPhotographs scan = scene::forPhotographs(std::move(read));
    const auto laidOut = [&](const scene::ScanPhoto& photo) {
        return forScan(readScanPhoto(photo), {photo.camera, photo.distortion},
                       scannerFromWorldInFile * photo.worldFromCamera, scan);
    };
    scene::PhotographsOnScan onScan(scan);
    std::vector<const scene::ScanPhoto*> taken;
    json report = json::array();
    for (const scene::ScanPhoto& photo : photos) {
        try {
            onScan.add(laidOut(photo));
            taken.push_back(&photo);
        } catch (const scene::Failure& failure) { // the rest goes on
            report.push_back(describeUnread(photo, scan.scan.name, failure.what()));
        }
        progress.advance();
    }
    for (const scene::ScanPhoto& photo : beside) {
        try {
            onScan.add(laidOut(photo));
        } catch (const scene::Failure&) { // told where it is laid itself
        }
    }
    const std::vector<scene::ColourFit> fits = onScan.fits();
    for (std::size_t i = 0; i < taken.size(); ++i) {
        std::optional<scene::PhotographForScan> photograph;
        try {
            photograph = laidOut(*taken[i]);
        } catch (const scene::Failure& failure) { // it could be read before
            report.push_back(describeUnread(*taken[i], scan.scan.name, failure.what()));
            continue;
        }
        report.push_back(write(*photograph, fits[i], taken[i]->name, scan, options, folder));
    }
    return report;
}

std::string keyOfPhotographs(const scene::ScanSource& scan, std::span<const scene::ScanPhoto> photos,
                             const BuildOptions& options) {
    json list = json::array();
    for (const scene::ScanPhoto& photo : photos) {
        const scene::Camera& c = photo.camera;
        const scene::Distortion& d = photo.distortion;
        list.push_back({photo.name,
                        fingerprintOf(photo.path),
                        photo.indexInFile,
                        {c.width, c.height, c.fx, c.fy, c.cx, c.cy},
                        {d.k1, d.k2, d.p1, d.p2, d.k3}});
    }
    const scene::DropoutOptions& dropouts = options.dropouts;
    return keyOf({kPhotographsVersion,
                  scan.name,
                  fingerprintOf(scan.path),
                  scan.indexInFile,
                  scan.registeredWorldFromScanner ? scene::rowMajor(*scan.registeredWorldFromScanner) : json(),
                  describeReading(scan),
                  list,
                  !options.movesScans(),
                  {dropouts.radius, dropouts.sameSurface, dropouts.minSamples}});
}

std::string sentenceOn(const json& photo) {
    const std::string who = "Photograph '" + photo.at("name").get<std::string>() + "' of scan '" +
                            photo.at("scan").get<std::string>() + "' ";
    if (photo.at("used").get<bool>() && photo.at("sure").get<bool>()) return "";
    if (photo.at("verdict") == kUnread)
        return who + "is left out: it cannot be read (" + photo.at("why").get<std::string>() + ").";
    if (photo.at("used").get<bool>())
        return who + "keeps the pose the file gives it: how it is turned could not be found (" +
               photo.at("why").get<std::string>() + ").";
    if (photo.at("sure").get<bool>() || photo.at("verdict").get<std::string>().starts_with("sees"))
        return who + "is left out: it sees nothing of it.";
    return who + "is left out: how it is turned could not be found (" + photo.at("why").get<std::string>() +
           "); --register given takes it as the file has it.";
}

struct Laid {
    json report;
    std::vector<scene::StoredImage> used;
};

/// The photographs of one scan on it, from the store if they are there. beside: those that help to turn them.
Laid layOn(const scene::ScanSource& source, std::span<const scene::ScanPhoto> photos,
           std::span<const scene::ScanPhoto> beside, const std::string& key, const BuildOptions& options,
           StageStore& store, Progress& progress) {
    const std::filesystem::path folder = store.find("photographs", key, [&](const std::filesystem::path& part) {
        writeWhole(part / "photographs.json", layOnTheirScan(source, photos, beside, options, progress, part).dump());
    });
    Laid laid{readJson(folder / "photographs.json"), {}};
    for (const json& photo : laid.report) {
        if (!photo.at("used").get<bool>()) continue;
        const std::filesystem::path file = folder / (photo.at("name").get<std::string>() + ".tiff");
        const scene::DepthImage header = scene::readDepthTiffHeader(file);
        laid.used.push_back({header.name, header.camera, header.worldFromCamera, file, {}});
    }
    return laid;
}

/// With a lens that nobody knows nothing lies on anything.
bool mayLackLens(const scene::Capture& capture, const json& report) {
    const auto unsure =
        std::count_if(report.begin(), report.end(), [](const json& photo) { return !photo.at("sure").get<bool>(); });
    return 2 * unsure > std::ssize(report) &&
           std::all_of(capture.scanPhotos.begin(), capture.scanPhotos.end(),
                       [](const scene::ScanPhoto& photo) { return photo.distortion == scene::Distortion{}; });
}

} // namespace

PhotographStage layPhotographs(scene::Capture& capture, const std::vector<std::size_t>& heldOut,
                               const BuildOptions& options, StageStore& store) {
    PhotographStage stage;
    stage.ofScan.resize(capture.scans.size());
    if (capture.scanPhotos.empty()) return stage;
    stage.report = json::array();
    std::vector<std::vector<scene::ScanPhoto>> kept(capture.scans.size()), out(capture.scans.size());
    for (std::size_t i = 0; i < capture.scanPhotos.size(); ++i) {
        const scene::ScanPhoto& photo = capture.scanPhotos[i];
        (std::binary_search(heldOut.begin(), heldOut.end(), i) ? out : kept)[photo.scan].push_back(photo);
    }
    Progress progress("photographs", capture.scanPhotos.size());
    for (std::size_t s = 0; s < capture.scans.size(); ++s) {
        const scene::ScanSource& source = capture.scans[s];
        if (!kept[s].empty()) {
            stage.ofScan[s].key = keyOfPhotographs(source, kept[s], options);
            const Laid laid = layOn(source, kept[s], {}, stage.ofScan[s].key, options, store, progress);
            for (const json& photo : laid.report) {
                stage.report.push_back(photo);
                if (const std::string sentence = sentenceOn(photo); !sentence.empty()) tell(capture, sentence);
            }
            stage.ofScan[s].images = laid.used;
        }
        if (out[s].empty()) continue;
        // Those that are turned by what others show of the scan need the others; the others must not need them.
        const std::string key = keyOf({"held out", keyOfPhotographs(source, out[s], options), stage.ofScan[s].key});
        const Laid laid = layOn(source, out[s], kept[s], key, options, store, progress);
        for (const json& photo : laid.report)
            if (const std::string sentence = sentenceOn(photo); !sentence.empty()) tell(capture, sentence);
        stage.heldOut.insert(stage.heldOut.end(), laid.used.begin(), laid.used.end());
    }
    if (mayLackLens(capture, stage.report))
        tell(capture,
             "How most photographs are turned could not be found. E57 cannot say how a lens distorts: if theirs "
             "does, --camera FILE says it ('revisit calibrate camera' finds it from pictures of a board).");
    if (stage.report.empty()) stage.report = nullptr; // all are held out
    return stage;
}

bool SampleColours::mayTake(const scene::StoredImage& photo) const {
    if (glm::distance(photo.worldFromCamera.translation, image_.worldFromCamera.translation) >= kSamePlace) return true;
    const auto halfDiagonal = [](const scene::Camera& c) {
        return std::atan(std::hypot(std::max(c.cx, c.width - c.cx) / c.fx, std::max(c.cy, c.height - c.cy) / c.fy));
    };
    const double apart = std::acos(
        std::clamp(glm::dot(photo.worldFromCamera.rotation[2], image_.worldFromCamera.rotation[2]), -1.0, 1.0));
    return apart < halfDiagonal(photo.camera) + halfDiagonal(image_.camera) + 0.01;
}

void SampleColours::take(const scene::DepthImage& photo) {
    const bool isSamePlace =
        glm::distance(photo.worldFromCamera.translation, image_.worldFromCamera.translation) < kSamePlace;
    const scene::Pose photoFromWorld = inverse(photo.worldFromCamera);
    tbb::parallel_for(0, image_.camera.height, [&](int y) {
        for (int x = 0; x < image_.camera.width; ++x) {
            const std::uint8_t flags = image_.flags(x, y);
            if (!scene::isSurface(flags) || !(flags & scene::kNoColour) || !(image_.disparity(x, y) > 0)) continue;
            const glm::dvec3 world = image_.worldFromCamera * (rayThrough(image_.camera, x + 0.5, y + 0.5) /
                                                               static_cast<double>(image_.disparity(x, y)));
            const glm::dvec3 p = photoFromWorld * world;
            if (!(p.z > 0)) continue;
            const glm::dvec2 at = project(photo.camera, p);
            const double inside =
                std::min(std::min(at.x, photo.camera.width - at.x), std::min(at.y, photo.camera.height - at.y));
            if (!(inside >= 1)) continue;
            const int u = static_cast<int>(at.x), v = static_cast<int>(at.y);
            if (photo.flags(u, v) & scene::kNoColour) continue; // the lens never saw there
            const double seen = static_cast<double>(photo.disparity(u, v));
            if (!isSamePlace && !(std::abs(seen * p.z - 1) < kSameSurface)) continue;
            const scene::Rgb8& c = photo.colour(u, v);
            sums_(x, y) += static_cast<float>(inside * inside) * glm::vec4(c.r, c.g, c.b, 1);
        }
    });
}

void SampleColours::give() {
    for (std::size_t i = 0; i < sums_.size(); ++i) {
        const glm::vec4& sum = sums_.pixels()[i];
        if (!(sum.w > 0)) continue;
        const auto byte = [&](float value) { return static_cast<std::uint8_t>(std::lround(value / sum.w)); };
        image_.colour.pixels()[i] = {byte(sum.x), byte(sum.y), byte(sum.z)};
        std::uint8_t& flags = image_.flags.pixels()[i];
        flags = static_cast<std::uint8_t>(flags & ~scene::kNoColour);
    }
}

} // namespace app
