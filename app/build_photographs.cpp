#include "app/build_photographs.h"

#include "app/build_stages.h"
#include "app/progress.h"

#include "scene/align/colour_to_range.h"
#include "scene/align/reflectance.h"
#include "scene/camera_json.h"
#include "scene/depth_tiff.h"
#include "scene/import/e57.h"
#include "scene/import/ptx.h"
#include "scene/import/scan_photos.h"
#include "scene/import/straighten.h"
#include "scene/project/planar_projection.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include <glm/geometric.hpp>
#include <tbb/parallel_for.h>

namespace app {

namespace {

using nlohmann::json;

/// Changed whenever what the stage computes changes, so that results of older versions are not taken for new ones.
constexpr int kPhotographsVersion = 1;
constexpr double kDegrees = 180 / std::numbers::pi;
/// A photograph's pixels are no finer than this share of the scan's spacing: range between samples is interpolated, so
/// that finer pixels cost four times as much for each halving and add colour alone.
constexpr double kLeastPixelSpacings = 0.5;
constexpr int kMostPixelsAcross = 4096;
/// A turn within so many deviations is none: poses that are right stay what they are.
constexpr double kSameDeviations = 3;

/// A scan as its photographs need it.
struct ScanAtHand {
    scene::Scan scan;
    std::vector<scene::Rgb8> reflectance; ///< evened, one for each point
    scene::AngularSteps steps;
    scene::Pose worldFromScannerInFile; ///< photographs' poses are beside this one
    scene::PlanarOptions planar;
};

ScanAtHand takeInHand(const scene::ScanSource& source) {
    ScanAtHand hand;
    scene::ScanWithIntensity read = scene::readE57ScanWithIntensity(source);
    hand.reflectance = scene::evenedReflectance(read);
    hand.scan = std::move(read.scan);
    hand.worldFromScannerInFile = hand.scan.worldFromScanner;
    standWhereFound(hand.scan, source);
    hand.steps = scene::stepsOf(hand.scan, glm::dvec3(0));
    const double noise = scene::rangeNoiseOf(hand.scan);
    if (noise > 0) hand.planar.noiseMetres = noise;
    return hand;
}

/// The photograph's pinhole with pixels that its scan can fill.
scene::Camera cameraFor(const scene::Camera& camera, const scene::AngularSteps& steps) {
    const double finest = kLeastPixelSpacings * std::max(steps.horizontal, steps.vertical);
    const double least = std::max(camera.width, camera.height) / static_cast<double>(kMostPixelsAcross);
    const double scale = std::max({finest * std::min(camera.fx, camera.fy), least, 1.0});
    const auto sizeOf = [&](int pixels) { return std::max(1, static_cast<int>(std::lround(pixels / scale))); };
    return resized(camera, sizeOf(camera.width), sizeOf(camera.height));
}

scene::ColourFit fitOf(ScanAtHand& hand, const scene::Image<scene::Rgb8>& straight, const scene::Camera& camera,
                       const scene::Pose& scannerFromGiven) {
    const scene::ColourToRangeOptions options;
    std::swap(hand.scan.colours, hand.reflectance);
    scene::DepthImage seen = projectToCamera(hand.scan, hand.steps, inverse(scannerFromGiven),
                                             widened(camera, options.reachRadians, 1 / camera.fx), hand.planar);
    std::swap(hand.scan.colours, hand.reflectance);
    fillDropouts(seen);
    return findTurn(seen, straight, camera, options);
}

scene::DepthImage photographOf(const ScanAtHand& hand, const std::string& name, const scene::StraightPicture& straight,
                               const scene::Camera& camera, const scene::Pose& scannerFromCamera,
                               const scene::DropoutOptions& dropouts) {
    scene::DepthImage image = projectToCamera(hand.scan, hand.steps, inverse(scannerFromCamera), camera, hand.planar);
    image.name = name;
    image.worldFromCamera = hand.scan.worldFromScanner * scannerFromCamera;
    image.colour = straight.colour;
    for (std::uint8_t& flags : image.flags.pixels())
        flags = static_cast<std::uint8_t>(flags & ~scene::kNoColour);
    fillDropouts(image, dropouts);
    for (std::size_t i = 0; i < image.flags.size(); ++i)
        if (!straight.isSeen.pixels()[i]) image.flags.pixels()[i] = scene::kNoSurface, image.disparity.pixels()[i] = 0;
    return image;
}

/// What becomes of a photograph, in words.
std::string verdictOf(const scene::ColourFit& fit, bool isMoved, bool isUsed) {
    if (fit.isSure) return isMoved ? "found" : "as given";
    return isUsed ? "not sure: kept as given" : "not sure: left out";
}

json layOne(ScanAtHand& hand, const scene::ScanPhoto& photo, const std::string& scanName, const BuildOptions& options,
            const std::filesystem::path& folder) {
    const scene::Image<scene::Rgb8> picture = readScanPhoto(photo);
    const scene::Camera camera = cameraFor(photo.camera, hand.steps);
    const scene::StraightPicture straight = straightened(picture, {photo.camera, photo.distortion}, camera);
    const scene::Pose scannerFromGiven = inverse(hand.worldFromScannerInFile) * photo.worldFromCamera;
    const scene::ColourFit fit = fitOf(hand, straight.colour, camera, scannerFromGiven);
    const bool isMoved = fit.isSure && fit.turnedRadians > kSameDeviations * fit.deviationRadians;
    const bool isUsed = fit.isSure || options.registration == "given";
    scene::Pose scannerFromCamera = scannerFromGiven;
    if (isMoved) scannerFromCamera.rotation = scannerFromCamera.rotation * fit.givenFromFound;
    std::int64_t samples = 0;
    if (isUsed) {
        const scene::DepthImage image =
            photographOf(hand, photo.name, straight, camera, scannerFromCamera, options.dropouts);
        for (const std::uint8_t flags : image.flags.pixels())
            samples += scene::isSurface(flags);
        if (samples > 0) writeDepthTiff(image, folder / (photo.name + ".tiff"));
    }
    return {
        {"name", photo.name},
        {"scan", scanName},
        {"verdict", samples == 0 && isUsed ? "sees nothing of its scan: left out" : verdictOf(fit, isMoved, isUsed)},
        {"used", samples > 0},
        {"sure", fit.isSure},
        {"why", fit.why},
        {"turned_deg", fit.turnedRadians * kDegrees},
        {"deviation_deg", fit.deviationRadians * kDegrees},
        {"score", fit.score},
        {"rival_share", fit.rivalShare},
        {"agreeing", fit.agreeing},
        {"parts", fit.parts},
        {"width", camera.width},
        {"height", camera.height},
        {"samples", samples},
        {"world_from_camera", scene::rowMajor(hand.scan.worldFromScanner * scannerFromCamera)},
        {"given_world_from_camera", scene::rowMajor(hand.scan.worldFromScanner * scannerFromGiven)}};
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
                  options.registration == "given",
                  {dropouts.radius, dropouts.sameSurface, dropouts.minSamples}});
}

std::string sentenceOn(const json& photo) {
    const std::string who = "Photograph '" + photo.at("name").get<std::string>() + "' of scan '" +
                            photo.at("scan").get<std::string>() + "' ";
    if (photo.at("used").get<bool>() && photo.at("sure").get<bool>()) return "";
    if (photo.at("used").get<bool>())
        return who + "keeps the pose the file gives it: how it is turned could not be found (" +
               photo.at("why").get<std::string>() + ").";
    if (photo.at("sure").get<bool>() || photo.at("verdict").get<std::string>().starts_with("sees"))
        return who + "is left out: it sees nothing of it.";
    return who + "is left out: how it is turned could not be found (" + photo.at("why").get<std::string>() +
           "); --register given takes it as the file has it.";
}

} // namespace

PhotographStage layPhotographs(scene::Capture& capture, const BuildOptions& options, StageStore& store) {
    PhotographStage stage;
    stage.ofScan.resize(capture.scans.size());
    if (capture.scanPhotos.empty()) return stage;
    stage.report = json::array();
    Progress progress("photographs", capture.scanPhotos.size());
    const std::span<const scene::ScanPhoto> all = capture.scanPhotos;
    for (std::size_t first = 0, end = 0; first < all.size(); first = end) {
        const std::size_t s = all[first].scan;
        while (end < all.size() && all[end].scan == s)
            ++end;
        const auto photos = all.subspan(first, end - first);
        const scene::ScanSource& source = capture.scans[s];
        ScanPhotographs& of = stage.ofScan[s];
        of.key = keyOfPhotographs(source, photos, options);
        const std::filesystem::path folder = store.find("photographs", of.key, [&](const std::filesystem::path& part) {
            // One scan at a time: the points of a single one may fill the memory.
            ScanAtHand hand = takeInHand(source);
            json report = json::array();
            for (const scene::ScanPhoto& photo : photos) {
                report.push_back(layOne(hand, photo, source.name, options, part));
                progress.advance();
            }
            writeWhole(part / "photographs.json", report.dump());
        });
        for (const json& photo : readJson(folder / "photographs.json")) {
            stage.report.push_back(photo);
            const std::string sentence = sentenceOn(photo);
            if (!sentence.empty()) {
                std::fprintf(stderr, "note: %s\n", sentence.c_str());
                capture.remarks.push_back(sentence);
            }
            if (!photo.at("used").get<bool>()) continue;
            const std::filesystem::path file = folder / (photo.at("name").get<std::string>() + ".tiff");
            const scene::DepthImage header = scene::readDepthTiffHeader(file);
            of.images.push_back({header.name, header.camera, header.worldFromCamera, file, {}});
        }
    }
    return stage;
}

void colourSamples(scene::DepthImage& image, const std::vector<scene::DepthImage>& photographs) {
    constexpr double kSamePlace = 0.005;  ///< metres: from here all is seen that the image sees
    constexpr double kSameSurface = 0.03; ///< relative difference of disparity
    tbb::parallel_for(0, image.camera.height, [&](int y) {
        for (int x = 0; x < image.camera.width; ++x) {
            std::uint8_t& flags = image.flags(x, y);
            if (!scene::isSurface(flags) || !(flags & scene::kNoColour) || !(image.disparity(x, y) > 0)) continue;
            const glm::dvec3 world = image.worldFromCamera * (rayThrough(image.camera, x + 0.5, y + 0.5) /
                                                              static_cast<double>(image.disparity(x, y)));
            glm::dvec3 sum(0);
            double weights = 0;
            for (const scene::DepthImage& photo : photographs) {
                const glm::dvec3 p = inverse(photo.worldFromCamera) * world;
                if (!(p.z > 0)) continue;
                const glm::dvec2 at = project(photo.camera, p);
                const double inside =
                    std::min(std::min(at.x, photo.camera.width - at.x), std::min(at.y, photo.camera.height - at.y));
                if (!(inside >= 1)) continue;
                const int u = static_cast<int>(at.x), v = static_cast<int>(at.y);
                const bool isSamePlace =
                    glm::distance(photo.worldFromCamera.translation, image.worldFromCamera.translation) < kSamePlace;
                const double seen = photo.disparity(u, v);
                if (!isSamePlace && !(std::abs(seen * p.z - 1) < kSameSurface)) continue;
                const double weight = inside * inside;
                const scene::Rgb8& c = photo.colour(u, v);
                sum += weight * glm::dvec3(c.r, c.g, c.b);
                weights += weight;
            }
            if (!(weights > 0)) continue;
            const auto byte = [&](double value) { return static_cast<std::uint8_t>(std::lround(value / weights)); };
            image.colour(x, y) = {byte(sum.x), byte(sum.y), byte(sum.z)};
            flags = static_cast<std::uint8_t>(flags & ~scene::kNoColour);
        }
    });
}

} // namespace app
