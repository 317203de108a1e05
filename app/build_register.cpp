// align: where the scans of a capture stand, found by what they have in common.

#include "app/build_stages.h"
#include "app/progress.h"

#include "scene/align/matches_file.h"
#include "scene/align/pair_record.h"
#include "scene/align/registration.h"
#include "scene/camera_json.h"

#include <algorithm>
#include <limits>
#include <mutex>
#include <optional>

namespace app {

namespace {

using nlohmann::json;

/// Changed whenever what registration finds changes, so that results of older versions are not taken for new ones.
constexpr int kRegisterVersion = 4;
/// The same of a pair alone.
constexpr int kPairVersion = 1;

const char* nameOf(const scene::PairOutcome& pair) {
    if (pair.isRefused) return "refused by a third scan";
    switch (pair.result.verdict) {
    case scene::PairVerdict::registered:
        return pair.result.isDecidedByGivenPose ? "registered as given" : "registered";
    case scene::PairVerdict::ambiguous:
        return pair.isSettled ? "ambiguous, settled by other scans" : "ambiguous";
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
                         {"left_out", scan.isLost},
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

/// What of a scan's file decides what is found.
json describePoints(const scene::ScanSource& scan) {
    return {fingerprintOf(scan.path), scan.indexInFile, scan.byteInFile, describeReading(scan)};
}

json describe(const scene::PairOptions& pair) {
    return {pair.leastOverlap, pair.mostAgainstShare, pair.mostAgainstShareGiven, pair.mostAgainstShareRival,
            pair.leastSharedPlanes};
}

std::string keyOfRegistration(const scene::Capture& capture, const std::string& how,
                              const scene::RegistrationOptions& options) {
    json scans = json::array();
    for (const scene::ScanSource& scan : capture.scans)
        scans.push_back({scan.name, describePoints(scan)});
    return keyOf({kRegisterVersion, kPairVersion, scans, how == "auto" ? json(how) : fingerprintOf(how),
                  describe(options.pair), options.leastJointOverlap, options.several.mostAgainstShare,
                  options.several.mostAgainstShareRival});
}

/// What is kept of a scan has a fixed size.
std::vector<scene::ScanView> viewsOf(const scene::Capture& capture, std::uint64_t memoryBytes) {
    std::vector<scene::ScanView> views(capture.scans.size());
    Progress progress("planes", views.size());
    scene::visitEach(views.size(), scansTogether(capture.scans, memoryBytes), [&](std::size_t i) {
        views[i] = viewOf(readScan(capture.scans[i]));
        progress.advance();
    });
    return views;
}

/// Of many scans there are thousands of pairs, of some seconds each. What is found of one is kept in a file of its own,
/// by the points of the two alone: a build that was stopped goes on there, and so does one with further scans.
scene::Registration registerAll(const scene::Capture& capture, const std::vector<scene::ScanView>& views,
                                std::vector<scene::PairOutcome> known, const scene::RegistrationOptions& options,
                                StageStore& store) {
    const std::filesystem::path folder = store.folderOf("pairs", keyOf({kPairVersion, describe(options.pair)}));
    const std::size_t all = views.size() * (views.size() - 1) / 2;
    Progress progress("register", all - std::min(all, known.size()));
    std::mutex writing; // a scan that was given twice has the same pairs
    const auto findPair = [&](std::size_t a, std::size_t b, const std::optional<scene::Pose>& rough) {
        const std::filesystem::path file =
            folder / keyOf({describePoints(capture.scans[a]), describePoints(capture.scans[b]),
                            rough ? json(scene::rowMajor(*rough)) : json(nullptr)});
        std::optional<scene::PairResult> result;
        std::error_code none;
        if (std::filesystem::exists(file, none)) result = scene::unpackPair(readWhole(file));
        if (!result) {
            result = registerPair(views[a], views[b], rough, options.pair);
            const std::scoped_lock lock(writing);
            writeWhole(file, scene::packPair(*result));
        }
        progress.advance();
        return *result;
    };
    return registerScans(views, options, findPair, std::move(known));
}

/// What a person says of pairs, in a file.
std::vector<scene::PairOutcome> pairsAsMatched(const std::vector<scene::ScanView>& views,
                                               const std::filesystem::path& file,
                                               const scene::RegistrationOptions& options) {
    std::vector<std::string> names;
    for (const scene::ScanView& view : views)
        names.push_back(view.name);
    std::vector<scene::PairOutcome> pairs;
    for (const scene::GivenMatches& matches : scene::readMatchesFile(file, names))
        pairs.push_back({matches.a, matches.b, pairFromMatches(views, matches, options.pair, file), true});
    return pairs;
}

/// With the photographs beside them.
void leaveOut(const std::vector<std::uint8_t>& isLost, scene::Capture& capture, scene::HeldOut& heldOut) {
    static constexpr std::size_t kGone = std::numeric_limits<std::size_t>::max();
    const auto take = [](auto& items, const auto& isGone) {
        std::vector<std::size_t> places;
        std::size_t kept = 0;
        for (std::size_t i = 0; i < items.size(); ++i) {
            places.push_back(isGone(i) ? kGone : kept);
            if (isGone(i)) continue;
            if (kept != i) items[kept] = std::move(items[i]);
            ++kept;
        }
        items.erase(items.begin() + static_cast<std::ptrdiff_t>(kept), items.end());
        return places;
    };
    const auto scans = take(capture.scans, [&](std::size_t i) { return isLost[i] != 0; });
    const auto photos =
        take(capture.scanPhotos, [&](std::size_t i) { return scans[capture.scanPhotos[i].scan] == kGone; });
    for (scene::ScanPhoto& photo : capture.scanPhotos)
        photo.scan = scans[photo.scan];
    for (std::size_t& photo : heldOut.scanPhotos)
        photo = photos[photo];
    const auto gone = std::ranges::count(photos, kGone), keptOut = std::ranges::count(heldOut.scanPhotos, kGone);
    if (gone > 0)
        tell(capture, std::to_string(gone) + " photographs beside scans that are left out are left out, too" +
                          (keptOut > 0 ? "; " + std::to_string(keptOut) + " of them were to be held out." : "."));
    std::erase(heldOut.scanPhotos, kGone);
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

json registerCapture(scene::Capture& capture, scene::HeldOut& heldOut, const BuildOptions& options, StageStore& store) {
    if (!options.movesScans() || capture.scans.empty()) return nullptr;
    const scene::RegistrationOptions registrationOptions;
    const std::string key = keyOfRegistration(capture, options.registration, registrationOptions);
    const std::filesystem::path folder = store.find("registration", key, [&](const std::filesystem::path& part) {
        const std::vector<scene::ScanView> views = viewsOf(capture, options.memoryBytes);
        std::vector<scene::PairOutcome> known;
        if (options.registration != "auto") known = pairsAsMatched(views, options.registration, registrationOptions);
        const scene::Registration registration =
            registerAll(capture, views, std::move(known), registrationOptions, store);
        writeWhole(part / "registration.json", describe(views, registration).dump());
    });
    const json report = readJson(folder / "registration.json");
    std::vector<std::uint8_t> isLost;
    for (std::size_t i = 0; i < capture.scans.size(); ++i) {
        const json& scan = report.at("scans").at(i);
        const std::string why = scan.at("why");
        if (!why.empty()) tell(capture, why + ".");
        if (scan.at("registered").get<bool>())
            capture.scans[i].registeredWorldFromScanner =
                poseOf(scan.at("world_from_scanner"), folder / "registration.json");
        isLost.push_back(scan.at("left_out").get<bool>());
    }
    for (const json& sentence : report.at("remarks"))
        tell(capture, sentence);
    leaveOut(isLost, capture, heldOut);
    return report;
}

} // namespace app
