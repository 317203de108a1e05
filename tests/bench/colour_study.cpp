// How often photographs are laid on their scans, never wrongly, and how exactly: simulated scans and photographs with
// distorting lenses, drifting exposures and wrong poses, over many seeds. Each seed has tripods, noise and turns of its
// own; photographs are also given scans they do not belong to, and turns beyond reach: those must be refused.
//
//   revisit_colour_study OUT.json room|corner SEEDS [SHOTS [SAMPLES_PER_DEGREE [MOST_TURN_DEG [PICTURES]]]]
//
// PICTURES: a folder that is there: pictures of edges, before and after, of the first seed.

#include "scene/align/colour_to_range.h"
#include "scene/align/reflectance.h"
#include "scene/capture/simulated_camera.h"
#include "scene/import/straighten.h"
#include "scene/project/dropouts.h"
#include "scene/project/planar_projection.h"
#include "scene/synthetic_random.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

namespace {

using nlohmann::json;

constexpr double kDegrees = 57.29577951308232;
constexpr double kWrongDegrees = 0.2; ///< another place of the picture, and not this one less exactly
constexpr double kWantedDegrees = 0.05;
constexpr int kWidth = 640, kHeight = 480;
constexpr double kAcross = 65;

struct ScanInHand {
    scene::Scan scan; ///< colours are evened reflectance
    scene::AngularSteps steps;
    double noise = 0;
};

struct Shot {
    scene::Pose scannerFromCamera; ///< the truth; the camera stands where the scanner does
    scene::Image<scene::Rgb8> picture;
};

double degreesBetween(const glm::dmat3& a, const glm::dmat3& b) {
    const glm::dmat3 r = glm::transpose(a) * b;
    const glm::dvec3 twist(r[1][2] - r[2][1], r[2][0] - r[0][2], r[0][1] - r[1][0]);
    return std::atan2(glm::length(twist) / 2, (r[0][0] + r[1][1] + r[2][2] - 1) / 2) * kDegrees;
}

glm::dvec3 anyDirection(scene::SeededSequence& chance) {
    return glm::normalize(glm::dvec3(chance.normal(), chance.normal(), chance.normal()));
}

scene::Pose setUp(const scene::Pose& tripod, scene::SeededSequence& chance) {
    scene::Pose pose =
        scene::poseFromQuaternion({}, 0.01 * chance.normal(), 0.01 * chance.normal(), chance.normal(), chance.normal());
    pose.translation = tripod.translation +
                       glm::dvec3(chance.between(-0.2, 0.2), chance.between(-0.2, 0.2), chance.between(-0.1, 0.1));
    return pose;
}

/// Looks to the horizon at an azimuth, x right, y down.
scene::Pose lookingTo(double azimuth, double elevation) {
    const glm::dvec3 forward(std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
                             std::sin(elevation));
    const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 0, 1)));
    return {glm::dmat3(right, glm::cross(forward, right), forward), glm::dvec3(0)};
}

scene::ColourFit fitOf(const ScanInHand& scan, const Shot& shot, const scene::CameraFile& lens,
                       const scene::Pose& scannerFromGiven, const std::string& pictures) {
    const double pixel = std::max(0.5 * std::max(scan.steps.horizontal, scan.steps.vertical), 1 / lens.camera.fx);
    scene::Camera camera =
        resized(lens.camera, static_cast<int>(std::lround(lens.camera.width / (pixel * lens.camera.fx))),
                static_cast<int>(std::lround(lens.camera.height / (pixel * lens.camera.fx))));
    const scene::ColourToRangeOptions options;
    scene::PlanarOptions planar;
    planar.noiseMetres = scan.noise;
    scene::DepthImage seen = projectToCamera(scan.scan, scan.steps, inverse(scannerFromGiven),
                                             scene::widened(camera, options.reachRadians, 1 / camera.fx), planar);
    fillDropouts(seen);
    const scene::StraightPicture straight = straightened(shot.picture, lens, camera);
    const scene::ColourFit fit = findTurn(seen, straight.colour, camera, options);
    if (!pictures.empty()) {
        const auto write = [&](const std::string& name, const scene::Image<scene::Rgb8>& picture) {
            cv::Mat3b bgr(picture.height(), picture.width());
            for (int y = 0; y < bgr.rows; ++y)
                for (int x = 0; x < bgr.cols; ++x)
                    bgr(y, x) = {picture(x, y).b, picture(x, y).g, picture(x, y).r};
            cv::imwrite(pictures + name + ".png", bgr);
        };
        const scene::EdgeImage mine = scene::photographEdges(straight.colour), theirs = scene::scanEdges(seen);
        write("-photograph", straight.colour);
        write("-reflectance", seen.colour);
        write("-photograph-edges", pictureOfEdges(mine));
        write("-scan-edges", pictureOfEdges(theirs));
        for (const bool isAfter : {false, true}) {
            scene::Image<scene::Rgb8> both(camera.width, camera.height);
            for (int y = 0; y < camera.height; ++y)
                for (int x = 0; x < camera.width; ++x) {
                    const glm::dvec3 ray = rayThrough(camera, x + 0.5, y + 0.5);
                    const glm::dvec2 at = project(seen.camera, isAfter ? fit.givenFromFound * ray : ray);
                    const auto i = static_cast<int>(at.x), j = static_cast<int>(at.y);
                    if (i < 0 || j < 0 || i >= seen.camera.width || j >= seen.camera.height) continue;
                    both(x, y) = {static_cast<std::uint8_t>(255 * std::min(mine(x, y).x, 1.0f)),
                                  static_cast<std::uint8_t>(255 * std::min(theirs(i, j).x, 1.0f)), 0};
                }
            write(isAfter ? "-after" : "-before", both);
        }
    }
    return fit;
}

double quantileOf(std::vector<double> values, double share) {
    if (values.empty()) return 0;
    std::sort(values.begin(), values.end());
    return values[std::min(values.size() - 1, static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

json describe(const scene::ColourFit& fit) {
    return {{"sure", fit.isSure},
            {"why", fit.why},
            {"score", fit.score},
            {"rival_share", fit.rivalShare},
            {"agreeing", fit.agreeing},
            {"parts", fit.parts},
            {"turned_deg", fit.turnedRadians * kDegrees},
            {"deviation_deg", fit.deviationRadians * kDegrees}};
}

struct Tally {
    std::vector<double> errors, seconds; ///< of sure fits
    int sure = 0, refused = 0, wanted = 0, wrong = 0, strangers = 0, strangersTaken = 0, beyond = 0, beyondTaken = 0;
};

} // namespace

int main(int argc, char** argv) {
    const auto synthetic = argc < 4 ? std::nullopt : scene::makeSyntheticScene(argv[2]);
    if (!synthetic) {
        std::fprintf(stderr, "usage: revisit_colour_study OUT.json room|corner SEEDS [SHOTS [SAMPLES_PER_DEGREE "
                             "[MOST_TURN_DEG [PICTURES]]]]\n");
        return 2;
    }
    const int seeds = std::atoi(argv[3]), shots = argc > 4 ? std::atoi(argv[4]) : 4;
    const double density = argc > 5 ? std::atof(argv[5]) : 4, mostTurn = argc > 6 ? std::atof(argv[6]) : 3;
    const std::string pictures = argc > 7 ? argv[7] : "";
    const scene::ScannedWorld world = worldOf(*synthetic, false), coloured = worldOf(*synthetic, true);
    const scene::CameraFile lens = scene::usualCamera(kWidth, kHeight, kAcross);

    Tally tally;
    json runs = json::array();
    for (int seed = 1; seed <= seeds; ++seed) {
        scene::SeededSequence chance(static_cast<std::uint64_t>(seed));
        // From 1 mm to 2 cm over the seeds.
        const double noise = 0.001 * std::pow(20.0, seeds > 1 ? (seed - 1.0) / (seeds - 1.0) : 0.5);
        ScanInHand before;
        std::size_t number = 0;
        for (const scene::Pose& tripod : scanPositions(*synthetic)) {
            const scene::Pose worldFromScanner = setUp(tripod, chance);
            scene::ScannerOptions scanner;
            scanner.farthestMetres = 40;
            scanner.noiseMetres = noise;
            scanner.seed = static_cast<std::uint32_t>(chance.bits());
            setDensity(scanner, density);
            scene::ScanWithIntensity read =
                readRawScan(simulateRawScan(world, worldFromScanner, scanner), scanner.constants);
            read.scan.colours = evenedReflectance(read);
            ScanInHand scan{std::move(read.scan), {}, 0};
            scan.steps = scene::stepsOf(scan.scan, glm::dvec3(0));
            scan.noise = rangeNoiseOf(scan.scan);
            ++number;
            std::printf("seed %d scan %zu (noise %.1f mm, found %.1f):", seed, number, 1e3 * noise, 1e3 * scan.noise);
            for (int i = 0; i < shots; ++i) {
                Shot shot;
                shot.scannerFromCamera =
                    lookingTo(2 * 3.14159265358979 * (i + chance.unit()) / shots, chance.between(-0.15, 0.1));
                scene::SimulatedCameraOptions camera;
                camera.lens = lens;
                camera.exposureStops = chance.between(-0.5, 0.5);
                camera.whiteBalance = {chance.between(0.9, 1.1), 1, chance.between(0.9, 1.1)};
                camera.seed = static_cast<std::uint32_t>(chance.bits());
                shot.picture = takePhotograph(coloured, worldFromScanner * shot.scannerFromCamera, camera);
                const double turn = mostTurn * std::cbrt(chance.unit()) / kDegrees;
                scene::Pose given = shot.scannerFromCamera;
                given.rotation = given.rotation * scene::rotationOf(turn * anyDirection(chance));
                const auto start = std::chrono::steady_clock::now();
                const scene::ColourFit fit =
                    fitOf(scan, shot, lens, given,
                          pictures.empty() || seed > 1
                              ? std::string()
                              : pictures + "/scan" + std::to_string(number) + "-" + std::to_string(i + 1));
                tally.seconds.push_back(
                    std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
                const double error =
                    degreesBetween(shot.scannerFromCamera.rotation, given.rotation * fit.givenFromFound);
                json run = describe(fit);
                run["seed"] = seed, run["scan"] = number, run["noise_m"] = noise,
                run["given_off_deg"] = turn * kDegrees;
                run["error_deg"] = error;
                const glm::dmat3 off =
                    glm::transpose(shot.scannerFromCamera.rotation) * given.rotation * fit.givenFromFound;
                run["error_axes_deg"] = {0.5 * kDegrees * (off[1][2] - off[2][1]),
                                         0.5 * kDegrees * (off[2][0] - off[0][2]),
                                         0.5 * kDegrees * (off[0][1] - off[1][0])};
                run["kind"] = "own";
                runs.push_back(run);
                (fit.isSure ? tally.sure : tally.refused)++;
                if (fit.isSure) tally.errors.push_back(error), tally.wanted += error <= kWantedDegrees;
                tally.wrong += fit.isSure && error > kWrongDegrees;
                std::printf(" %.3f%s", error, !fit.isSure ? "(refused)" : error > kWrongDegrees ? " WRONG" : "");
                if (!before.scan.pointsInScanner.empty()) {
                    const scene::ColourFit stranger = fitOf(before, shot, lens, given, "");
                    ++tally.strangers, tally.strangersTaken += stranger.isSure;
                    json other = describe(stranger);
                    other["kind"] = "stranger";
                    runs.push_back(other);
                }
                scene::Pose far = shot.scannerFromCamera;
                far.rotation = far.rotation * scene::rotationOf((6 / kDegrees) * anyDirection(chance));
                const scene::ColourFit beyond = fitOf(scan, shot, lens, far, "");
                const double farError =
                    degreesBetween(shot.scannerFromCamera.rotation, far.rotation * beyond.givenFromFound);
                ++tally.beyond, tally.beyondTaken += beyond.isSure && farError > kWrongDegrees;
                json other = describe(beyond);
                other["kind"] = "beyond", other["error_deg"] = farError;
                runs.push_back(other);
            }
            std::printf("\n");
            std::fflush(stdout);
            before = std::move(scan);
        }
    }
    const auto share = [](int part, std::size_t whole) {
        return whole ? 100.0 * part / static_cast<double>(whole) : 0;
    };
    const std::size_t all = static_cast<std::size_t>(tally.sure + tally.refused);
    std::printf(
        "%zu photographs: %d sure (%.1f %% within %.2f degrees of all), %d refused, %d wrong; errors median %.4f, "
        "95 %% %.4f, worst %.4f degrees\n%d with scans they do not belong to: %d taken; %d beyond reach: %d taken; "
        "%.2f s each\n",
        all, tally.sure, share(tally.wanted, all), kWantedDegrees, tally.refused, tally.wrong,
        quantileOf(tally.errors, 0.5), quantileOf(tally.errors, 0.95), quantileOf(tally.errors, 1), tally.strangers,
        tally.strangersTaken, tally.beyond, tally.beyondTaken, quantileOf(tally.seconds, 0.5));
    std::ofstream(argv[1]) << json{{"scene", argv[2]},
                                   {"samples_per_degree", density},
                                   {"most_turn_deg", mostTurn},
                                   {"photographs", all},
                                   {"sure", tally.sure},
                                   {"within_wanted", tally.wanted},
                                   {"refused", tally.refused},
                                   {"wrong", tally.wrong},
                                   {"strangers", tally.strangers},
                                   {"strangers_taken", tally.strangersTaken},
                                   {"beyond", tally.beyond},
                                   {"beyond_taken", tally.beyondTaken},
                                   {"runs", runs}}
                                  .dump(1)
                           << '\n';
}
