// How exactly the constants of a scanner are found: simulated scans of both faces, over many seeds, each with an
// instrument, tripods and noise of its own.
//
//   revisit_calibration_study OUT.json room|corner SEEDS [SAMPLES_PER_DEGREE [NOISE_MM [SCANS [FIRST_SEED]]]]

#include "scene/align/scanner_calibration.h"
#include "scene/capture/simulated_scan.h"
#include "scene/synthetic_random.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include <glm/trigonometric.hpp>
#include <nlohmann/json.hpp>

namespace {

using nlohmann::json;

scene::Pose setUp(const scene::Pose& tripod, scene::SeededSequence& chance) {
    scene::Pose pose =
        scene::poseFromQuaternion({}, 0.01 * chance.normal(), 0.01 * chance.normal(), chance.normal(), chance.normal());
    pose.translation = tripod.translation;
    return pose;
}

/// What differs from what is believed, in units of what is asked for: a step, thousandths of a degree, millimetres.
std::array<double, 4> errorsOf(const scene::ScannerConstants<double>& a, const scene::ScannerConstants<double>& b) {
    return {a.panStepsPerHalfTurn - b.panStepsPerHalfTurn, 1e3 * glm::degrees(a.mirrorRadians - b.mirrorRadians),
            1e3 * (a.horizonPosition - b.horizonPosition) * 360 / scene::kEncoderPositions,
            1e3 * (a.mirrorMetres - b.mirrorMetres)};
}

} // namespace

int main(int argc, char** argv) {
    const auto synthetic = argc < 4 ? std::nullopt : scene::makeSyntheticScene(argv[2]);
    if (!synthetic) {
        std::fprintf(stderr, "usage: revisit_calibration_study OUT.json room|corner SEEDS [SAMPLES_PER_DEGREE "
                             "[NOISE_MM [SCANS [FIRST_SEED]]]]\n");
        return 2;
    }
    const int seeds = std::atoi(argv[3]), firstSeed = argc > 7 ? std::atoi(argv[7]) : 1;
    const double density = argc > 4 ? std::atof(argv[4]) : 4, noise = argc > 5 ? std::atof(argv[5]) / 1000 : 0.005;
    std::vector<scene::Pose> tripods = scanPositions(*synthetic);
    if (argc > 6) tripods.resize(std::min(tripods.size(), static_cast<std::size_t>(std::atoi(argv[6]))));
    const scene::ScannedWorld world = worldOf(*synthetic, false);

    json runs = json::array();
    std::array<std::vector<double>, 4> sizes, inDeviations;
    int refused = 0;
    for (int seed = firstSeed; seed < firstSeed + seeds; ++seed) {
        scene::SeededSequence chance(static_cast<std::uint64_t>(seed));
        scene::ScannerConstants<double> truth;
        truth.panStepsPerHalfTurn += chance.between(-60, 60);
        truth.mirrorRadians += glm::radians(chance.between(-0.3, 0.3));
        truth.horizonPosition += chance.between(-12, 12);
        truth.mirrorMetres += chance.between(-0.01, 0.01);
        std::vector<scene::Scan> scans;
        for (const scene::Pose& tripod : tripods) {
            scene::ScannerOptions options;
            options.constants = truth;
            options.panDegrees = 360;
            options.farthestMetres = 40;
            options.noiseMetres = noise;
            options.seed = static_cast<std::uint32_t>(chance.bits());
            setDensity(options, density);
            scans.push_back(readRawScan(simulateRawScan(world, setUp(tripod, chance), options), {}).scan);
            scans.back().name = "scan" + std::to_string(scans.size());
        }
        const auto start = std::chrono::steady_clock::now();
        const scene::ScannerCalibration found =
            scene::calibrateScanner(scans.size(), [&](std::size_t i) { return scans[i]; }, {});
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        const std::array<double, 4> errors = errorsOf(found.constants, truth),
                                    known = errorsOf(found.deviations, scene::ScannerConstants<double>{0, 0, 0, 0});
        std::printf("seed %d: %+.2f steps (%.2f), mirror %+.2f mdeg (%.2f), horizon %+.2f mdeg (%.2f), %+.2f mm "
                    "(%.2f); %d planes, %.2f -> %.2f mm, %.0f s %s\n",
                    seed, errors[0], known[0], errors[1], known[1], errors[2], known[2], errors[3], known[3],
                    found.planes, 1e3 * found.rmsBeforeMetres, 1e3 * found.rmsAfterMetres, seconds, found.why.c_str());
        std::fflush(stdout);
        refused += !found.why.empty();
        runs.push_back({{"errors", errors},
                        {"deviations", known},
                        {"planes", found.planes},
                        {"seconds", seconds},
                        {"why", found.why}});
        if (!found.why.empty()) continue;
        for (std::size_t i = 0; i < 4; ++i) {
            sizes[i].push_back(std::abs(errors[i]));
            inDeviations[i].push_back(std::abs(errors[i]) / known[i]);
        }
    }
    const auto most = [](const std::vector<double>& v) {
        return v.empty() ? 0 : *std::max_element(v.begin(), v.end());
    };
    json worst = json::array(), worstInDeviations = json::array();
    for (std::size_t i = 0; i < 4; ++i)
        worst.push_back(most(sizes[i])), worstInDeviations.push_back(most(inDeviations[i]));
    const json result{{"place", argv[2]},
                      {"samples_per_degree", density},
                      {"noise_m", noise},
                      {"scans", tripods.size()},
                      {"refused", refused},
                      {"worst_steps_mdeg_mdeg_mm", worst},
                      {"worst_in_deviations", worstInDeviations},
                      {"runs", runs}};
    std::ofstream(argv[1]) << result.dump(1) << '\n';
    std::printf("refused %d of %d; worst %.2f steps, %.2f and %.2f thousandths of a degree, %.2f mm\n", refused, seeds,
                worst[0].get<double>(), worst[1].get<double>(), worst[2].get<double>(), worst[3].get<double>());
    return 0;
}
