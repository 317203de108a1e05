// How often scans are registered rightly, and how exactly: simulated scans from unknown poses, over many seeds.
//
//   revisit_registration_study OUT.json SCENE SEEDS [SAMPLES_PER_DEGREE [NOISE_MM]]

#include "scene/align/register_pair.h"
#include "scene/capture/simulated_scan.h"
#include "scene/synthetic_random.h"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

namespace {

using namespace scene;

Pose randomTurn(SeededSequence& chance) {
    return poseFromQuaternion({}, 0.02 * chance.normal(), 0.02 * chance.normal(), chance.normal(), chance.normal());
}

double degreesBetween(const Pose& a, const Pose& b) {
    glm::dmat3 d = glm::transpose(a.rotation) * b.rotation;
    const double s = glm::length(glm::dvec3(d[1][2] - d[2][1], d[2][0] - d[0][2], d[0][1] - d[1][0])) / 2;
    return std::atan2(s, (d[0][0] + d[1][1] + d[2][2] - 1) / 2) * 57.29577951308232;
}

} // namespace

int main(int argc, char** argv) {
    const std::string name = argv[2];
    const int seeds = std::atoi(argv[3]);
    const double density = argc > 4 ? std::atof(argv[4]) : 3, noise = argc > 5 ? std::atof(argv[5]) / 1000 : 0.005;
    const auto scene = makeSyntheticScene(name);
    const ScannedWorld world = worldOf(*scene, false);
    for (int seed = 1; seed <= seeds; ++seed) {
        SeededSequence chance(static_cast<std::uint64_t>(seed));
        std::vector<ScanView> views;
        std::vector<Pose> truth;
        for (const Pose& place : scanPositions(*scene)) {
            Pose pose = randomTurn(chance);
            pose.translation = place.translation + glm::dvec3(chance.between(-0.3, 0.3), chance.between(-0.3, 0.3),
                                                              chance.between(-0.1, 0.1));
            ScannerOptions options;
            options.farthestMetres = 40;
            options.noiseMetres = noise;
            options.seed = static_cast<std::uint32_t>(chance.bits());
            setDensity(options, density);
            const auto t0 = std::chrono::steady_clock::now();
            ScanWithIntensity read = readRawScan(simulateRawScan(world, pose, options), options.constants);
            const auto t1 = std::chrono::steady_clock::now();
            views.push_back(viewOf(read.scan));
            const auto t2 = std::chrono::steady_clock::now();
            truth.push_back(pose);
            if (seed == 1)
                std::printf("scan %zu points %zu planes %zu sim %.1f view %.1f\n", truth.size(),
                            read.scan.pointsInScanner.size(), views.back().planes.size(),
                            std::chrono::duration<double>(t1 - t0).count(),
                            std::chrono::duration<double>(t2 - t1).count());
        }
        for (std::size_t i = 0; i < views.size(); ++i)
            for (std::size_t j = i + 1; j < views.size(); ++j) {
                const auto t0 = std::chrono::steady_clock::now();
                const PairResult r = registerPair(views[i], views[j], {});
                const double s = std::chrono::duration<double>(std::chrono::steady_clock::now() - t0).count();
                const Pose t = inverse(truth[i]) * truth[j];
                const PoseEvidence e = checkPose(views[i].panorama, views[j].panorama, t);
                const auto at = settlePair(views[i], views[j], t, {});
                std::printf("seed %d %zu-%zu verdict %d err %.4f deg %.2f mm overlap %.3f against %.4f rms %.2f mm dev "
                            "%.2f mm planes %zu plaus %zu | rival %.3f %.4f | truth %.3f %.4f settled from truth %.4f "
                            "deg %.2f mm rv %.2f m %.1f s\n",
                            seed, i, j, static_cast<int>(r.verdict), degreesBetween(r.best.aFromB, t),
                            glm::distance(r.best.aFromB.translation, t.translation) * 1000, r.best.evidence.agreeing,
                            r.best.evidence.againstShare(), r.best.evidence.rmsMetres * 1000,
                            r.best.deviation.metres * 1000, r.best.matches.size(), r.plausible,
                            r.rival ? r.rival->evidence.agreeing : 0.0,
                            r.rival ? r.rival->evidence.againstShare() : 0.0, e.agreeing, e.againstShare(),
                            at ? degreesBetween(at->aFromB, t) : -1.0,
                            at ? 1000 * glm::distance(at->aFromB.translation, t.translation) : -1.0,
                            r.rival ? glm::distance(r.rival->aFromB.translation, t.translation) : -1.0, s);
                std::fflush(stdout);
            }
    }
}
