// align: where the scans of a capture stand, found by what they have in common.

#include "app/build_stages.h"
#include "app/progress.h"

#include "scene/align/matches_file.h"
#include "scene/align/registration.h"
#include "scene/camera_json.h"

#include <cstdio>
#include <numbers>

namespace app {

namespace {

using nlohmann::json;

/// Changed whenever what registration finds changes, so that results of older versions are not taken for new ones.
constexpr int kRegisterVersion = 3;

const char* nameOf(const scene::PairOutcome& pair) {
    if (pair.isRefused) return "refused by a third scan";
    switch (pair.result.verdict) {
    case scene::PairVerdict::registered:
        return pair.result.isDecidedByGivenPose ? "registered as given" : "registered";
    case scene::PairVerdict::ambiguous:
        return "ambiguous";
    case scene::PairVerdict::contradicted:
        return "contradicted";
    case scene::PairVerdict::loose:
        return "free to slide";
    case scene::PairVerdict::apart:
        break;
    }
    return "too little in common";
}

json describe(const std::vector<scene::ScanView>& views, const scene::Registration& registration) {
    json scans = json::array(), pairs = json::array();
    for (std::size_t i = 0; i < views.size(); ++i) {
        const scene::ScanOutcome& scan = registration.scans[i];
        scans.push_back({{"name", views[i].name},
                         {"registered", scan.isRegistered},
                         {"group", views[scan.group].name},
                         {"world_from_scanner", scene::rowMajor(scan.worldFromScanner)},
                         {"given_world_from_scanner", scene::rowMajor(views[i].givenWorldFromScanner)},
                         {"deviation_m", scan.deviation.metres},
                         {"deviation_deg", scan.deviation.radians * kDegrees},
                         {"planes", views[i].planes.size()},
                         {"why", scan.why}});
    }
    for (const scene::PairOutcome& pair : registration.pairs) {
        const scene::PairFit& best = pair.result.best;
        pairs.push_back({{"a", views[pair.a].name},
                         {"b", views[pair.b].name},
                         {"verdict", nameOf(pair)},
                         {"used", pair.isUsed},
                         {"a_from_b", scene::rowMajor(best.aFromB)},
                         {"overlap", best.evidence.agreeing},
                         {"against_share", best.evidence.againstShare()},
                         {"rms_m", best.rmsMetres},
                         {"deviation_m", best.deviation.metres},
                         {"deviation_deg", best.deviation.radians * kDegrees},
                         {"shared_planes", best.matches.size()},
                         {"plausible_poses", pair.result.plausible.size()}});
    }
    return {{"scans", scans}, {"pairs", pairs}, {"rms_m", registration.rmsMetres}, {"remarks", registration.remarks}};
}

std::string keyOfRegistration(const scene::Capture& capture, const std::string& how,
                              const scene::RegistrationOptions& options) {
    json scans = json::array();
    for (const scene::ScanSource& scan : capture.scans)
        scans.push_back(
            {scan.name, fingerprintOf(scan.path), scan.indexInFile, scan.byteInFile, describeReading(scan)});
    const scene::PairOptions& pair = options.pair;
    return keyOf({kRegisterVersion,
                  scans,
                  how == "auto" ? json(how) : fingerprintOf(how),
                  {pair.leastOverlap, pair.mostAgainstShare, pair.mostAgainstShareGiven, pair.mostAgainstShareRival,
                   pair.leastSharedPlanes, options.leastJointOverlap}});
}

/// One scan's points are held at a time; what is kept of it has a fixed size.
std::vector<scene::ScanView> viewsOf(const scene::Capture& capture) {
    std::vector<scene::ScanView> views;
    Progress progress("planes", capture.scans.size());
    for (const scene::ScanSource& source : capture.scans) {
        views.push_back(viewOf(readScan(source)));
        progress.advance();
    }
    return views;
}

scene::Registration registerAsMatched(const std::vector<scene::ScanView>& views, const std::filesystem::path& file,
                                      const scene::RegistrationOptions& options) {
    std::vector<std::string> names;
    for (const scene::ScanView& view : views)
        names.push_back(view.name);
    std::vector<scene::PairOutcome> pairs;
    for (const scene::GivenMatches& matches : scene::readMatchesFile(file, names))
        pairs.push_back({matches.a, matches.b, pairFromMatches(views, matches, options.pair, file), false, false});
    return joinScans(views, std::move(pairs), options);
}

} // namespace

scene::Pose poseOf(const json& rows, const std::filesystem::path& file) {
    glm::dmat4 matrix(1);
    for (int i = 0; i < 16; ++i)
        matrix[i % 4][i / 4] = rows.at(static_cast<std::size_t>(i)).get<double>();
    scene::Pose pose;
    if (!poseFromMatrix(matrix, 1e-6, pose))
        throw scene::Failure("holds a pose that is none", file, "remove the folder it stands in, and build again");
    return pose;
}

json registerCapture(scene::Capture& capture, const BuildOptions& options, StageStore& store) {
    if (!options.movesScans() || capture.scans.empty()) return nullptr;
    const scene::RegistrationOptions registrationOptions;
    const std::string key = keyOfRegistration(capture, options.registration, registrationOptions);
    const std::filesystem::path folder = store.find("registration", key, [&](const std::filesystem::path& part) {
        const std::vector<scene::ScanView> views = viewsOf(capture);
        if (options.registration != "auto") {
            const scene::Registration registration =
                registerAsMatched(views, options.registration, registrationOptions);
            writeWhole(part / "registration.json", describe(views, registration).dump());
            return;
        }
        Progress progress("register", views.size() * (views.size() - 1) / 2);
        const scene::Registration registration = registerScans(views, registrationOptions, [&] { progress.advance(); });
        writeWhole(part / "registration.json", describe(views, registration).dump());
    });
    const json report = readJson(folder / "registration.json");
    for (std::size_t i = 0; i < capture.scans.size(); ++i) {
        const json& scan = report.at("scans").at(i);
        const std::string why = scan.at("why");
        if (!why.empty()) tell(capture, why + ".");
        if (scan.at("registered").get<bool>())
            capture.scans[i].registeredWorldFromScanner =
                poseOf(scan.at("world_from_scanner"), folder / "registration.json");
    }
    for (const json& sentence : report.at("remarks"))
        tell(capture, sentence);
    return report;
}

} // namespace app
