#include "app/sample_scans.h"

#include "scene/align/scanner_file.h"
#include "scene/camera_json.h"
#include "scene/capture/simulated_camera.h"
#include "scene/capture/simulated_scan.h"
#include "scene/capture/spread_positions.h"
#include "scene/errors.h"
#include "scene/import/polygons.h"
#include "scene/synthetic_random.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iostream>
#include <numbers>
#include <optional>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

namespace app {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kMostTiltDegrees = 1.0; ///< of a tripod that was set up by eye

glm::dvec3 anyDirection(scene::SeededSequence& chance) {
    return glm::normalize(glm::dvec3(chance.normal(), chance.normal(), chance.normal()));
}

scene::Pose turned(const glm::dvec3& axis, double radians) {
    const double half = radians / 2;
    const glm::dvec3 v = axis * std::sin(half);
    return scene::poseFromQuaternion(glm::dvec3(0), v.x, v.y, v.z, std::cos(half));
}

/// Standing at a place whose up is given, turned any way and not quite plumb.
scene::Pose setUp(const glm::dvec3& position, const scene::Pose& worldFromUpright, scene::SeededSequence& chance) {
    const scene::Pose tilt = turned(glm::normalize(glm::dvec3(chance.normal(), chance.normal(), 0)),
                                    glm::radians(kMostTiltDegrees) * chance.unit());
    const scene::Pose yaw = turned({0, 0, 1}, 2 * std::numbers::pi * chance.unit());
    scene::Pose pose = worldFromUpright * tilt * yaw;
    pose.translation = position;
    return pose;
}

scene::ScannerConstants<double> nominal() {
    return {};
}

scene::ScannerConstants<double> asFoundByThePaper() {
    scene::ScannerConstants<double> constants;
    constants.panStepsPerHalfTurn = 14039;
    constants.mirrorRadians = glm::radians(44.8);
    constants.horizonPosition = 7.3;
    constants.mirrorMetres = 0.128;
    return constants;
}

/// Looks from the scanner's origin to an azimuth and elevation: x right, y down, z forward.
scene::Pose lookingTo(double azimuth, double elevation) {
    const glm::dvec3 forward(std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
                             std::sin(elevation));
    const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 0, 1)));
    return {glm::dmat3(right, glm::cross(forward, right), forward), glm::dvec3(0)};
}

std::vector<std::uint8_t> jpegOf(const scene::Image<scene::Rgb8>& picture) {
    constexpr int kQuality = 95;
    cv::Mat3b bgr(picture.height(), picture.width());
    for (int y = 0; y < bgr.rows; ++y)
        for (int x = 0; x < bgr.cols; ++x)
            bgr(y, x) = {picture(x, y).b, picture(x, y).g, picture(x, y).r};
    std::vector<std::uint8_t> bytes;
    cv::imencode(".jpg", bgr, bytes, {cv::IMWRITE_JPEG_QUALITY, kQuality});
    return bytes;
}

class SampleScans {
  public:
    /// photographed: the same world with its colours.
    SampleScans(const scene::ScannedWorld& world, const scene::ScannedWorld& photographed,
                std::vector<scene::Pose> worldFromScanners, std::uint32_t seed, const SampleScansOptions& options)
        : world_(world), photographed_(photographed), worldFromScanners_(std::move(worldFromScanners)), seed_(seed),
          options_(options) {
        scanner_.constants = asFoundByThePaper();
        if (options.hasWrongConstants) believed_ = nominal();
        scanner_.noiseMetres = options.noiseMetres;
        scanner_.farthestMetres = options.farthestMetres;
        if (options.areBothFaces) scanner_.panDegrees = 360;
        setDensity(scanner_, options.samplesPerDegree);
    }

    /// Returns the pose of the true world in the one that was written.
    scene::Pose write(const std::filesystem::path& out) const {
        const auto scanAt = [&](std::size_t i) {
            scene::ScannerOptions scanner = scanner_;
            scanner.seed = static_cast<std::uint32_t>(scene::mixBits(seed_, i));
            scene::ScanWithIntensity read =
                readRawScan(simulateRawScan(world_, worldFromScanners_[i], scanner), believed_);
            read.scan.name = nameOf(i);
            read.scan.worldFromScanner = writtenPose(i);
            return read;
        };
        if (options_.format == "ptx")
            scene::writePtx(out / "scans.ptx", worldFromScanners_.size(), scanAt);
        else
            scene::writeE57(
                out / "scans.e57", worldFromScanners_.size(), scanAt,
                {worldFromScanners_.size() * photographsOfScan(), [&](std::size_t i) { return photograph(i); }});
        if (options_.photographs > 0) writeCameraFile(out / "camera.json", lens());
        writeTruth(out / "truth.json");
        return writtenPose(0) * inverse(worldFromScanners_[0]);
    }

  private:
    static std::string nameOf(std::size_t i) { return "scan" + std::to_string(i + 1); }

    scene::Pose writtenPose(std::size_t i) const {
        if (options_.arePosesUnknown) return {};
        scene::SeededSequence chance(scene::mixBits(seed_ + 77u, i));
        scene::Pose pose = worldFromScanners_[i];
        pose.rotation = turned(anyDirection(chance), glm::radians(options_.poseErrorDegrees)).rotation * pose.rotation;
        pose.translation += options_.poseErrorMetres * anyDirection(chance);
        return pose;
    }

    scene::CameraFile lens() const {
        return scene::usualCamera(options_.photographWidth, options_.photographHeight, options_.photographDegrees);
    }

    /// What chance made of a shot: the shots of a scan come one after another.
    struct Shot {
        std::string name;
        std::size_t scan = 0;
        scene::Pose scannerFromCamera, writtenScannerFromCamera;
        scene::SimulatedCameraOptions camera;
    };

    std::size_t photographsOfScan() const {
        return static_cast<std::size_t>(options_.photographs) * static_cast<std::size_t>(options_.photographRings);
    }

    /// Degrees; the horizon's ring comes first.
    double elevationOf(std::size_t number) const {
        constexpr double kElevations[] = {0, 36, -36}; // they overlap by a third, as photographers do it
        return kElevations[number / static_cast<std::size_t>(options_.photographs)];
    }

    Shot shotAt(std::size_t i) const {
        scene::SeededSequence chance(scene::mixBits(seed_ + 1999u, i));
        Shot shot;
        const std::size_t perScan = photographsOfScan();
        const std::size_t number = i % perScan;
        shot.scan = i / perScan;
        shot.name = nameOf(shot.scan) + "-photo" + std::to_string(number + 1);
        const double turn = 2 * std::numbers::pi / options_.photographs;
        shot.scannerFromCamera = lookingTo(turn * (static_cast<double>(number) + 0.1 * chance.between(-1, 1)),
                                           glm::radians(elevationOf(number) + chance.between(-8, 2)));
        shot.writtenScannerFromCamera = shot.scannerFromCamera;
        shot.writtenScannerFromCamera.rotation =
            shot.scannerFromCamera.rotation *
            turned(anyDirection(chance), glm::radians(options_.photographErrorDegrees)).rotation;
        shot.camera.lens = lens();
        shot.camera.exposureStops = options_.exposureStops * chance.between(-1, 1);
        // A white balance that drifts as far as exposure would be a broken camera's.
        const double tint = 0.3 * options_.exposureStops;
        shot.camera.whiteBalance = {std::exp2(tint * chance.between(-1, 1)), 1,
                                    std::exp2(tint * chance.between(-1, 1))};
        shot.camera.seed = static_cast<std::uint32_t>(chance.bits());
        return shot;
    }

    scene::WrittenPhotograph photograph(std::size_t i) const {
        const Shot shot = shotAt(i);
        const scene::Pose& worldFromScanner = worldFromScanners_[shot.scan];
        return {shot.name, shot.scan, shot.camera.lens.camera, writtenPose(shot.scan) * shot.writtenScannerFromCamera,
                jpegOf(takePhotograph(photographed_, worldFromScanner * shot.scannerFromCamera, shot.camera))};
    }

    Json describePhotographs() const {
        Json photographs = Json::array();
        for (std::size_t i = 0; i < worldFromScanners_.size() * photographsOfScan(); ++i) {
            const Shot shot = shotAt(i);
            const glm::dvec3& balance = shot.camera.whiteBalance;
            photographs.push_back({{"name", shot.name},
                                   {"scan", nameOf(shot.scan)},
                                   {"scanner_from_camera", scene::rowMajor(shot.scannerFromCamera)},
                                   {"written_scanner_from_camera", scene::rowMajor(shot.writtenScannerFromCamera)},
                                   {"turned_wrong_deg", options_.photographErrorDegrees},
                                   {"exposure_stops", shot.camera.exposureStops},
                                   {"white_balance", {balance.x, balance.y, balance.z}}});
        }
        return photographs;
    }

    void writeTruth(const std::filesystem::path& path) const {
        Json scans = Json::array();
        for (std::size_t i = 0; i < worldFromScanners_.size(); ++i)
            scans.push_back({{"name", nameOf(i)},
                             {"world_from_scanner", scene::rowMajor(worldFromScanners_[i])},
                             {"written_world_from_scanner", scene::rowMajor(writtenPose(i))}});
        std::ofstream file(path);
        file << Json{{"constants",
                      {{"true", scene::describeConstants(scanner_.constants)},
                       {"believed", scene::describeConstants(believed_)}}},
                     {"noise_m", options_.noiseMetres},
                     {"scans", scans},
                     {"photographs", describePhotographs()}}
                    .dump(1)
             << '\n';
        file.close();
        if (!file)
            throw scene::Failure("cannot write the file", path, "check that the folder is writable and not full");
    }

    const scene::ScannedWorld &world_, &photographed_;
    std::vector<scene::Pose> worldFromScanners_;
    std::uint32_t seed_;
    const SampleScansOptions& options_;
    scene::ScannerOptions scanner_;
    scene::ScannerConstants<double> believed_ = asFoundByThePaper();
};

std::vector<scene::Pose> setUpAll(const std::vector<glm::dvec3>& positions, const scene::Pose& worldFromUpright,
                                  std::uint32_t seed) {
    std::vector<scene::Pose> poses;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        scene::SeededSequence chance(scene::mixBits(seed + 11u, i));
        poses.push_back(setUp(positions[i], worldFromUpright, chance));
    }
    return poses;
}

} // namespace

scene::Pose makeSampleScans(const std::filesystem::path& out, const std::string& sceneName, std::uint32_t seed,
                            const SampleScansOptions& options) {
    if (options.photographs > 0 && options.format != "e57")
        throw scene::Failure("cannot hold photographs", "--scan-format " + options.format,
                             "leave out --photographs, or write e57");
    const auto count = static_cast<std::size_t>(options.scans);
    scene::Pose writtenFromTrue;
    if (options.polygons.empty()) {
        const std::optional<scene::SyntheticScene> synthetic = scene::makeSyntheticScene(sceneName, seed);
        std::vector<glm::dvec3> positions;
        for (const scene::Pose& pose : scanPositions(*synthetic))
            positions.push_back(pose.translation);
        if (count > positions.size())
            throw scene::Failure("has places for " + std::to_string(positions.size()) + " scans alone",
                                 "--scene " + sceneName, "ask for fewer with --scans");
        positions.resize(count);
        const scene::ScannedWorld world = worldOf(*synthetic, options.withColour), coloured = worldOf(*synthetic, true);
        writtenFromTrue = SampleScans(world, coloured, setUpAll(positions, {}, seed), seed, options).write(out);
    } else {
        const scene::PolygonScene polygons = scene::readPolygons(options.polygons);
        const scene::PolygonTracer tracer(polygons);
        const scene::SurfaceLight light(tracer, {});
        const scene::ScannedWorld world = worldOf(tracer, light, options.withColour),
                                  coloured = worldOf(tracer, light, true);
        const scene::Pose worldFromUpright = turned({1, 0, 0}, -std::numbers::pi / 2); // their +Y is up
        writtenFromTrue =
            SampleScans(world, coloured, setUpAll(spreadPositions(tracer, options.scans), worldFromUpright, seed), seed,
                        options)
                .write(out);
    }
    std::cout << options.scans << " scans ";
    if (options.photographs > 0) std::cout << "with " << options.photographs << " photographs each ";
    std::cout << "and their truth in " << out.string() << '\n';
    return writtenFromTrue;
}

} // namespace app
