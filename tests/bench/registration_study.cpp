// How often scans are registered, never wrongly, and how exactly: simulated scans from unknown poses, over many seeds.
// Each seed has tripods of its own, turned any way and tilted by a degree, and noise of its own.
//
//   revisit_registration_study OUT.json room|corner|corridor SEEDS [SAMPLES_PER_DEGREE [NOISE_MM [SCANS [FIRST_SEED]]]]

#include "scene/align/registration.h"
#include "scene/capture/simulated_scan.h"
#include "scene/synthetic_random.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <nlohmann/json.hpp>

namespace {

using nlohmann::json;

/// A pose that is farther off is another place, and not this one less exactly.
constexpr double kWrongDegrees = 0.2, kWrongMetres = 0.05;

struct Error {
    double degrees = 0, metres = 0;
};

Error errorOf(const scene::Pose& found, const scene::Pose& truth) {
    const scene::Pose off = inverse(truth) * found;
    const glm::dmat3& r = off.rotation;
    const glm::dvec3 twist(r[1][2] - r[2][1], r[2][0] - r[0][2], r[0][1] - r[1][0]);
    const double sine = glm::length(twist) / 2, cosine = (r[0][0] + r[1][1] + r[2][2] - 1) / 2;
    return {std::atan2(sine, cosine) * 57.29577951308232, glm::length(off.translation)};
}

scene::Pose setUp(const scene::Pose& tripod, scene::SeededSequence& chance) {
    scene::Pose pose =
        scene::poseFromQuaternion({}, 0.01 * chance.normal(), 0.01 * chance.normal(), chance.normal(), chance.normal());
    pose.translation = tripod.translation +
                       glm::dvec3(chance.between(-0.2, 0.2), chance.between(-0.2, 0.2), chance.between(-0.1, 0.1));
    return pose;
}

double medianOf(std::vector<double> values) {
    if (values.empty()) return 0;
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

} // namespace

int main(int argc, char** argv) {
    const auto synthetic = argc < 4 ? std::nullopt : scene::makeSyntheticScene(argv[2]);
    if (!synthetic) {
        std::fprintf(stderr, "usage: revisit_registration_study OUT.json room|corner|corridor SEEDS "
                             "[SAMPLES_PER_DEGREE [NOISE_MM [SCANS [FIRST_SEED]]]]\n");
        return 2;
    }
    const int seeds = std::atoi(argv[3]);
    const double density = argc > 4 ? std::atof(argv[4]) : 4, noise = argc > 5 ? std::atof(argv[5]) / 1000 : 0.005;
    std::vector<scene::Pose> tripods = scanPositions(*synthetic);
    if (argc > 6) tripods.resize(std::min(tripods.size(), static_cast<std::size_t>(std::atoi(argv[6]))));
    const scene::ScannedWorld world = worldOf(*synthetic, false);

    std::vector<double> degrees, metres, seconds;
    int registered = 0, left = 0, wrong = 0;
    json runs = json::array();
    const int firstSeed = argc > 7 ? std::atoi(argv[7]) : 1;
    for (int seed = firstSeed; seed < firstSeed + seeds; ++seed) {
        scene::SeededSequence chance(static_cast<std::uint64_t>(seed));
        std::vector<scene::ScanView> views;
        std::vector<scene::Pose> truth;
        for (const scene::Pose& tripod : tripods) {
            truth.push_back(setUp(tripod, chance));
            scene::ScannerOptions options;
            options.farthestMetres = 40;
            options.noiseMetres = noise;
            options.seed = static_cast<std::uint32_t>(chance.bits());
            setDensity(options, density);
            scene::ScanWithIntensity read =
                readRawScan(simulateRawScan(world, truth.back(), options), options.constants);
            read.scan.name = "scan" + std::to_string(truth.size());
            views.push_back(viewOf(read.scan));
        }
        const auto start = std::chrono::steady_clock::now();
        const scene::Registration found = registerScans(views);
        seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
        json scans = json::array();
        std::printf("seed %d:", seed);
        for (std::size_t i = 0; i < views.size(); ++i) {
            const scene::ScanOutcome& scan = found.scans[i];
            if (!scan.isRegistered) {
                ++left;
                scans.push_back({{"why", scan.why}});
                std::printf(" [%s]", scan.why.c_str());
                continue;
            }
            if (scan.group == i) continue;
            const std::size_t g = scan.group;
            const Error error =
                errorOf(inverse(found.scans[g].worldFromScanner) * scan.worldFromScanner, inverse(truth[g]) * truth[i]);
            const bool isWrong = error.degrees > kWrongDegrees || error.metres > kWrongMetres;
            ++registered;
            wrong += isWrong;
            if (!isWrong) degrees.push_back(error.degrees), metres.push_back(error.metres);
            scans.push_back({{"error_deg", error.degrees},
                             {"error_m", error.metres},
                             {"deviation_m", scan.deviation.metres},
                             {"deviation_deg", scan.deviation.radians * 57.29577951308232}});
            std::printf(" %.4f deg %.2f mm (known to %.2f)%s", error.degrees, 1e3 * error.metres,
                        1e3 * scan.deviation.metres, isWrong ? " WRONG" : "");
        }
        std::printf("\n");
        for (const scene::PairOutcome& pair : found.pairs) {
            const scene::PairFit& best = pair.result.best;
            const Error error = errorOf(best.aFromB, inverse(truth[pair.a]) * truth[pair.b]);
            std::printf(
                "    %zu, %zu: verdict %d, %s, %.1f %% agree, %.3f %% against, %d plausible, off by %.3f deg %.0f mm\n",
                pair.a + 1, pair.b + 1, static_cast<int>(pair.result.verdict), pair.isUsed ? "used" : "not used",
                100 * best.evidence.agreeing, 100 * best.evidence.againstShare(),
                static_cast<int>(pair.result.plausible.size()), error.degrees, 1e3 * error.metres);
        }
        std::fflush(stdout);
        runs.push_back(scans);
    }
    const auto most = [](const std::vector<double>& v) {
        return v.empty() ? 0 : *std::max_element(v.begin(), v.end());
    };
    std::printf(
        "%d registered, %d of them wrong, %d left; median %.4f deg %.2f mm, worst %.4f deg %.2f mm; %.1f s each\n",
        registered, wrong, left, medianOf(degrees), 1e3 * medianOf(metres), most(degrees), 1e3 * most(metres),
        medianOf(seconds));
    std::ofstream(argv[1]) << json{{"scene", argv[2]}, {"samples_per_degree", density},
                                   {"noise_m", noise}, {"registered", registered},
                                   {"wrong", wrong},   {"left", left},
                                   {"runs", runs}}
                                  .dump(1)
                           << '\n';
}
