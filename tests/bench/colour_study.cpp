// How often photographs are laid on their scans, never wrongly, and how exactly: simulated scans and photographs with
// distorting lenses, drifting exposures and wrong poses, over many seeds. Each seed has tripods, noise and turns of its
// own; photographs are also given scans they do not belong to, and turns beyond reach: those must be refused.
//
//   revisit_colour_study OUT.json room|corner SEEDS [SHOTS [SAMPLES_PER_DEGREE [MOST_TURN_DEG [PICTURES [OWN_ONLY]]]]]
//
// SEEDS: how many, or of so many which, as in 20:7,8,10.
// PICTURES: a folder that is there, or -: pictures of edges, before and after, of the first seed.

#include "scene/capture/simulated_camera.h"
#include "scene/project/photographs_on_scan.h"
#include "scene/synthetic_random.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

namespace {

using nlohmann::json;

constexpr double kPi = std::numbers::pi, kDegrees = 180 / kPi;
constexpr double kWrongDegrees = 0.2; ///< another place of the picture, and not this one less exactly
constexpr double kWantedDegrees = 0.05;
constexpr int kWidth = 960, kHeight = 720;
constexpr double kAcross = 65;

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

glm::dmat3 turnBy(double radians, const glm::dvec3& axis) {
    const glm::dvec3 v = axis * std::sin(radians / 2);
    return scene::poseFromQuaternion({}, v.x, v.y, v.z, std::cos(radians / 2)).rotation;
}

/// Looks to the horizon at an azimuth, x right, y down.
scene::Pose lookingTo(double azimuth, double elevation) {
    const glm::dvec3 forward(std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
                             std::sin(elevation));
    const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 0, 1)));
    return {glm::dmat3(right, glm::cross(forward, right), forward), glm::dvec3(0)};
}

void writePictures(const scene::ScanForPhotographs& scan, const scene::PhotographForScan& photo,
                   const scene::ColourFit& fit, const std::string& stem) {
    const auto write = [&](const std::string& name, const scene::Image<scene::Rgb8>& picture) {
        cv::Mat3b bgr(picture.height(), picture.width());
        for (int y = 0; y < bgr.rows; ++y)
            for (int x = 0; x < bgr.cols; ++x)
                bgr(y, x) = {picture(x, y).b, picture(x, y).g, picture(x, y).r};
        cv::imwrite(stem + name + ".png", bgr);
    };
    scene::Scan grey = scan.scan;
    grey.colours = scan.reflectance;
    grey.isColoured = {};
    scene::DepthImage seen = projectToCamera(
        grey, scan.traits, inverse(photo.scannerFromGiven),
        scene::widened(photo.camera, scene::ColourToRangeOptions{}.reachRadians, 1 / photo.camera.fx), scan.planar);
    fillDropouts(seen);
    const scene::EdgeImage mine = scene::photographEdges(photo.straight.colour), theirs = scene::scanEdges(seen);
    write("-photograph", photo.straight.colour);
    write("-reflectance", seen.colour);
    write("-photograph-edges", pictureOfEdges(mine));
    write("-scan-edges", pictureOfEdges(theirs));
    for (const bool isAfter : {false, true}) {
        scene::Image<scene::Rgb8> both(photo.camera.width, photo.camera.height);
        for (int y = 0; y < photo.camera.height; ++y)
            for (int x = 0; x < photo.camera.width; ++x) {
                const glm::dvec3 ray = rayThrough(photo.camera, x + 0.5, y + 0.5);
                const glm::dvec2 at = project(seen.camera, isAfter ? fit.givenFromFound * ray : ray);
                const auto i = static_cast<int>(at.x), j = static_cast<int>(at.y);
                if (i < 0 || j < 0 || i >= seen.camera.width || j >= seen.camera.height) continue;
                both(x, y) = {static_cast<std::uint8_t>(255 * std::min(mine(x, y).x, 1.0f)),
                              static_cast<std::uint8_t>(255 * std::min(theirs(i, j).x, 1.0f)), 0};
            }
        write(isAfter ? "-after" : "-before", both);
    }
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
            {"neighbours", fit.neighbours},
            {"agreeing", fit.agreeing},
            {"parts", fit.parts},
            {"turned_deg", fit.turnedRadians * kDegrees},
            {"deviation_deg", fit.deviationRadians * kDegrees}};
}

/// "3" is 1, 2 and 3; "20:7,8" is 7 and 8.
std::vector<int> chosenSeeds(const std::string& text) {
    std::vector<int> chosen;
    const std::size_t colon = text.find(':');
    if (colon == std::string::npos) {
        for (int seed = 1; seed <= std::atoi(text.c_str()); ++seed)
            chosen.push_back(seed);
        return chosen;
    }
    std::istringstream list(text.substr(colon + 1));
    for (std::string seed; std::getline(list, seed, ',');)
        chosen.push_back(std::atoi(seed.c_str()));
    return chosen;
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
                             "[MOST_TURN_DEG [PICTURES [OWN_ONLY]]]]]\n");
        return 2;
    }
    const int seeds = std::atoi(argv[3]);
    const std::vector<int> chosen = chosenSeeds(argv[3]);
    if (chosen.empty() || *std::min_element(chosen.begin(), chosen.end()) < 1 ||
        *std::max_element(chosen.begin(), chosen.end()) > seeds) {
        std::fprintf(stderr, "revisit_colour_study: SEEDS are 20, or some of 1 to 20 as in 20:7,8; not %s\n", argv[3]);
        return 2;
    }
    const int shots = argc > 4 ? std::atoi(argv[4]) : 4;
    const double density = argc > 5 ? std::atof(argv[5]) : 4, mostTurn = argc > 6 ? std::atof(argv[6]) : 3;
    const std::string pictures = argc > 7 && argv[7] != std::string("-") ? argv[7] : "";
    const bool hasFalse = argc <= 8;
    const scene::ScannedWorld world = worldOf(*synthetic, false), coloured = worldOf(*synthetic, true);
    const scene::CameraFile lens = scene::usualCamera(kWidth, kHeight, kAcross);

    std::vector<scene::Pose> tripods = scanPositions(*synthetic);
    tripods.resize(std::min<std::size_t>(tripods.size(), argv[2] == std::string("corner") ? 3 : 4));

    Tally tally;
    json runs = json::array();
    const auto share = [](int part, std::size_t whole) {
        return whole ? 100.0 * part / static_cast<double>(whole) : 0;
    };
    const auto write = [&] {
        std::ofstream(argv[1]) << json{{"scene", argv[2]},
                                       {"samples_per_degree", density},
                                       {"most_turn_deg", mostTurn},
                                       {"photographs", tally.sure + tally.refused},
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
    };
    for (const int seed : chosen) {
        scene::SeededSequence chance(static_cast<std::uint64_t>(seed));
        // From 1 mm to 2 cm over the seeds.
        const double noise = 0.001 * std::pow(20.0, seeds > 1 ? (seed * 7 % seeds) / (seeds - 1.0) : 0.5);
        scene::ScanForPhotographs before;
        std::size_t number = 0;
        for (const scene::Pose& tripod : tripods) {
            const scene::Pose worldFromScanner = setUp(tripod, chance);
            scene::ScannerOptions scanner;
            scanner.farthestMetres = 40;
            scanner.noiseMetres = noise;
            scanner.seed = static_cast<std::uint32_t>(chance.bits());
            setDensity(scanner, density);
            scene::ScanForPhotographs scan = scene::forPhotographs(
                readRawScan(simulateRawScan(world, worldFromScanner, scanner), scanner.constants));
            ++number;
            std::printf("seed %d scan %zu (noise %.1f mm, found %.1f):", seed, number, 1e3 * noise,
                        1e3 * scan.planar.noiseMetres);
            std::vector<scene::Pose> truth;
            std::vector<scene::PhotographForScan> own, far;
            std::vector<double> turns;
            for (int i = 0; i < shots; ++i) {
                truth.push_back(lookingTo(2 * kPi * (i + 0.2 * chance.unit()) / shots, chance.between(-0.15, 0.1)));
                scene::SimulatedCameraOptions camera;
                camera.lens = lens;
                camera.exposureStops = chance.between(-0.5, 0.5);
                camera.whiteBalance = {chance.between(0.9, 1.1), 1, chance.between(0.9, 1.1)};
                camera.seed = static_cast<std::uint32_t>(chance.bits());
                const auto picture = takePhotograph(coloured, worldFromScanner * truth.back(), camera);
                turns.push_back(mostTurn * std::cbrt(chance.unit()));
                scene::Pose given = truth.back();
                given.rotation = given.rotation * turnBy(turns.back() / kDegrees, anyDirection(chance));
                own.push_back(forScan(picture, lens, given, scan));
                given.rotation = truth.back().rotation * turnBy(6 / kDegrees, anyDirection(chance));
                far.push_back(forScan(picture, lens, given, scan));
            }
            const auto start = std::chrono::steady_clock::now();
            const std::vector<scene::ColourFit> fits = layOnScan(scan, own);
            tally.seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() /
                                    shots);
            for (std::size_t i = 0; i < fits.size(); ++i) {
                const scene::ColourFit& fit = fits[i];
                const glm::dmat3 found = own[i].scannerFromGiven.rotation * fit.givenFromFound;
                const double error = degreesBetween(truth[i].rotation, found);
                json run = describe(fit);
                run["seed"] = seed, run["scan"] = number, run["noise_m"] = noise, run["given_off_deg"] = turns[i];
                run["error_deg"] = error;
                const glm::dmat3 off = glm::transpose(truth[i].rotation) * found;
                run["error_axes_deg"] = {0.5 * kDegrees * (off[1][2] - off[2][1]),
                                         0.5 * kDegrees * (off[2][0] - off[0][2]),
                                         0.5 * kDegrees * (off[0][1] - off[1][0])};
                run["kind"] = "own";
                runs.push_back(run);
                (fit.isSure ? tally.sure : tally.refused)++;
                if (fit.isSure) tally.errors.push_back(error), tally.wanted += error <= kWantedDegrees;
                tally.wrong += fit.isSure && error > kWrongDegrees;
                std::printf(" %.3f%s", error, !fit.isSure ? "(refused)" : error > kWrongDegrees ? " WRONG" : "");
                if (!pictures.empty() && seed == chosen.front())
                    writePictures(scan, own[i], fit,
                                  pictures + "/scan" + std::to_string(number) + "-" + std::to_string(i + 1));
            }
            std::printf("\n");
            std::fflush(stdout);
            // One at a time: nothing but the scan may refuse them.
            for (std::size_t i = 0; hasFalse && i < far.size(); ++i) {
                const scene::ColourFit beyond = layOnScan(scan, std::span(far).subspan(i, 1)).front();
                const double error =
                    degreesBetween(truth[i].rotation, far[i].scannerFromGiven.rotation * beyond.givenFromFound);
                ++tally.beyond, tally.beyondTaken += beyond.isSure && error > kWrongDegrees;
                runs.push_back(describe(beyond));
                runs.back()["kind"] = "beyond", runs.back()["error_deg"] = error;
                if (before.scan.pointsInScanner.empty()) continue;
                const scene::ColourFit stranger = layOnScan(before, std::span(own).subspan(i, 1)).front();
                ++tally.strangers, tally.strangersTaken += stranger.isSure;
                runs.push_back(describe(stranger));
                runs.back()["kind"] = "stranger";
            }
            if (hasFalse && !before.scan.pointsInScanner.empty()) {
                // All together: they agree with each other, and must not be believed for that.
                for (const scene::ColourFit& fit : layOnScan(before, own))
                    ++tally.strangers, tally.strangersTaken += fit.isSure;
            }
            before = std::move(scan);
        }
        write(); // what there is if it is stopped
    }
    const std::size_t all = static_cast<std::size_t>(tally.sure + tally.refused);
    std::printf(
        "%zu photographs: %d sure (%.1f %% within %.2f degrees of all), %d refused, %d wrong; errors median %.4f, "
        "95 %% %.4f, worst %.4f degrees\n%d with scans they do not belong to: %d taken; %d beyond reach: %d taken; "
        "%.2f s each\n",
        all, tally.sure, share(tally.wanted, all), kWantedDegrees, tally.refused, tally.wrong,
        quantileOf(tally.errors, 0.5), quantileOf(tally.errors, 0.95), quantileOf(tally.errors, 1), tally.strangers,
        tally.strangersTaken, tally.beyond, tally.beyondTaken, quantileOf(tally.seconds, 0.5));
    write();
}
