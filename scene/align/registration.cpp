#include "scene/align/registration.h"

#include "scene/align/joint_surfaces.h"
#include "scene/align/mirrored.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include <glm/geometric.hpp>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr double kSameScannerMetres = 0.02;
constexpr double kOtherUnits =
    50; ///< times the range of another scan: millimetres, or feet and miles, not a larger room
/// Scans of a group contradict each other if as much of what both saw cannot be. More than for a pair alone: errors of
/// several pairs add up before all are adjusted.
constexpr double kContradiction = 0.02, kLeastContradiction = 0.003;

/// "1.2 %" for sentences.
std::string shareText(double share) {
    char text[32];
    std::snprintf(text, sizeof text, "%.1f %%", 100 * share);
    return text;
}

bool isIdentity(const Pose& pose) {
    return pose.rotation == glm::dmat3(1.0) && pose.translation == glm::dvec3(0.0);
}

/// Of each scan, whether anybody said where it stands. Files without poses leave scans at the origin, unturned; that
/// one alone stands so may be meant.
std::vector<bool> arePosesGiven(const std::vector<ScanView>& scans) {
    const auto unturned = std::count_if(scans.begin(), scans.end(),
                                        [](const ScanView& scan) { return isIdentity(scan.givenWorldFromScanner); });
    std::vector<bool> areGiven;
    for (const ScanView& scan : scans)
        areGiven.push_back(unturned < 2 || !isIdentity(scan.givenWorldFromScanner));
    return areGiven;
}

class Joining {
  public:
    Joining(const std::vector<ScanView>& scans, const RegistrationOptions& options, Registration& registration)
        : scans_(scans), options_(options), registration_(registration), group_(scans.size()), poses_(scans.size()) {
        std::iota(group_.begin(), group_.end(), std::size_t{0});
    }

    /// The surest pair first; a pair that would make two scans contradict each other joins nothing, nor does one that
    /// not more pairs agree with than deny: of two that differ one is wrong, and neither says which.
    void join() {
        std::vector<PairOutcome*> sure;
        for (PairOutcome& pair : registration_.pairs)
            if (pair.result.verdict == PairVerdict::registered) sure.push_back(&pair);
        std::stable_sort(sure.begin(), sure.end(), [](const PairOutcome* x, const PairOutcome* y) {
            return x->result.best.evidence.agreeing > y->result.best.evidence.agreeing;
        });
        for (PairOutcome* pair : sure) {
            const Pose groupFromB = poses_[pair->a] * pair->result.best.aFromB;
            if (group_[pair->a] == group_[pair->b]) {
                // A loop: it must close.
                pair->isRefused = areElsewhere(inverse(poses_[pair->a]) * poses_[pair->b], pair->result.best.aFromB);
                pair->isUsed = !pair->isRefused;
                continue;
            }
            const Pose aFromOther = groupFromB * inverse(poses_[pair->b]);
            const std::size_t from = group_[pair->b], into = group_[pair->a];
            if (!isBelieved(into, from, aFromOther) || !areCompatible(into, from, aFromOther)) {
                pair->isRefused = true;
                continue;
            }
            pair->isUsed = true;
            for (std::size_t i = 0; i < scans_.size(); ++i) {
                if (group_[i] != from) continue;
                poses_[i] = aFromOther * poses_[i];
                group_[i] = into;
            }
        }
    }

    void adjust() {
        for (std::size_t first = 0; first < scans_.size(); ++first) {
            std::vector<std::size_t> members;
            for (std::size_t i = 0; i < scans_.size(); ++i)
                if (group_[i] == group_[first]) members.push_back(i);
            if (members[0] == first) adjustGroup(members);
        }
    }

  private:
    /// Every pair between the groups that is sure has a say, and an ambiguous one denies what is none of its poses.
    bool isBelieved(std::size_t into, std::size_t from, const Pose& intoFromOther) const {
        int agreeing = 0, denying = 0;
        for (const PairOutcome& pair : registration_.pairs) {
            const PairVerdict verdict = pair.result.verdict;
            if (verdict != PairVerdict::registered && verdict != PairVerdict::ambiguous) continue;
            const bool isForth = group_[pair.a] == into && group_[pair.b] == from;
            const bool isBack = group_[pair.a] == from && group_[pair.b] == into;
            if (!isForth && !isBack) continue;
            const Pose intoFromA = isForth ? poses_[pair.a] : intoFromOther * poses_[pair.a];
            const Pose intoFromB = isForth ? intoFromOther * poses_[pair.b] : poses_[pair.b];
            const Pose aFromB = inverse(intoFromA) * intoFromB;
            const std::vector<Pose>& known = pair.result.plausible;
            const bool agrees =
                std::any_of(known.begin(), known.end(), [&](const Pose& pose) { return !areElsewhere(pose, aFromB); });
            denying += !agrees;
            agreeing += agrees && verdict == PairVerdict::registered; // one that fits at several places speaks for none
        }
        return agreeing > denying;
    }

    bool areCompatible(std::size_t into, std::size_t from, const Pose& intoFromOther) const {
        PoseCheckOptions check;
        check.stride = 3;
        check.toleranceMetres = 0.08;
        for (std::size_t i = 0; i < scans_.size(); ++i)
            for (std::size_t j = 0; j < scans_.size(); ++j) {
                if (group_[i] != into || group_[j] != from) continue;
                const Pose iFromJ = inverse(poses_[i]) * intoFromOther * poses_[j];
                const PoseEvidence evidence = checkPose(scans_[i].panorama, scans_[j].panorama, iFromJ, check);
                if (evidence.against > kLeastContradiction && evidence.againstShare() > kContradiction) return false;
            }
        return true;
    }

    void adjustGroup(const std::vector<std::size_t>& members) {
        const std::size_t first = members[0];
        const Pose worldFromGroup = scans_[first].givenWorldFromScanner * inverse(poses_[first]);
        for (const std::size_t i : members)
            registration_.scans[i].group = first;
        if (members.size() == 1) {
            registration_.scans[first].worldFromScanner = scans_[first].givenWorldFromScanner;
            return;
        }
        std::vector<const Panorama*> panoramas;
        std::vector<Pose> poses;
        for (const std::size_t i : members) {
            panoramas.push_back(&scans_[i].panorama);
            poses.push_back(worldFromGroup * poses_[i]);
        }
        PoseCheckOptions check;
        check.stride = 2;
        std::vector<std::pair<std::size_t, std::size_t>> pairs;
        for (std::size_t i = 0; i < members.size(); ++i)
            for (std::size_t j = i + 1; j < members.size(); ++j)
                if (checkPose(*panoramas[i], *panoramas[j], inverse(poses[i]) * poses[j], check).agreeing >=
                    options_.leastJointOverlap)
                    pairs.emplace_back(i, j);
        const JointResult joint = layOnSurfaces(panoramas, pairs, poses, 0);
        for (std::size_t i = 0; i < members.size(); ++i) {
            ScanOutcome& scan = registration_.scans[members[i]];
            scan.isRegistered = true;
            scan.worldFromScanner = joint.worldFromScanners[i];
            scan.deviation = joint.deviations[i];
        }
        registration_.rmsMetres = std::max(registration_.rmsMetres, joint.rmsMetres);
        if (!joint.isHeld)
            registration_.remarks.push_back("What scan '" + scans_[first].name + "' and those registered to it " +
                                            "have in common leaves one of them free to slide.");
        judge(members);
    }

    /// After all were adjusted two scans may contradict each other that did not by themselves.
    void judge(const std::vector<std::size_t>& members) {
        for (const std::size_t i : members)
            for (const std::size_t j : members) {
                if (j <= i) continue;
                const Pose iFromJ =
                    inverse(registration_.scans[i].worldFromScanner) * registration_.scans[j].worldFromScanner;
                const PoseEvidence evidence = checkPose(scans_[i].panorama, scans_[j].panorama, iFromJ);
                if (evidence.against <= kLeastContradiction || evidence.againstShare() <= kContradiction) continue;
                registration_.remarks.push_back(
                    "Scans '" + scans_[i].name + "' and '" + scans_[j].name +
                    "' contradict each other where they were registered: " + shareText(evidence.againstShare()) +
                    " of what both saw stands where the other saw through.");
            }
    }

    const std::vector<ScanView>& scans_;
    const RegistrationOptions& options_;
    Registration& registration_;
    std::vector<std::size_t> group_;
    std::vector<Pose> poses_; ///< groupFromScanner
};

bool faceOneWay(const std::vector<ScanPlane>& planes) {
    return std::all_of(planes.begin(), planes.end(), [&](const ScanPlane& plane) {
        return std::abs(glm::dot(plane.normal, planes[0].normal)) > 0.95;
    });
}

std::string whyNot(std::size_t scan, const std::vector<ScanView>& scans, const Registration& registration) {
    const std::string name = "Scan '" + scans[scan].name + "' stands where it was said to stand: ";
    if (scans[scan].planes.empty()) return name + "no plane was found in it";
    if (faceOneWay(scans[scan].planes)) return name + "all its planes face one way, which leaves it free to slide";
    const PairOutcome* best = nullptr;
    for (const PairOutcome& pair : registration.pairs)
        if ((pair.a == scan || pair.b == scan) &&
            (!best || pair.result.best.evidence.agreeing > best->result.best.evidence.agreeing))
            best = &pair;
    if (!best) return name + "it was compared with no other";
    const std::string other = "'" + scans[best->a == scan ? best->b : best->a].name + "'";
    const PoseEvidence& evidence = best->result.best.evidence;
    if (best->isRefused)
        return name + "where " + other + " would have it, a third scan sees through its surfaces or has it elsewhere";
    switch (best->result.verdict) {
    case PairVerdict::ambiguous:
        return name + "it fits " + other + " in " + std::to_string(best->result.plausible.size()) + " places";
    case PairVerdict::contradicted:
        return name + "where it fits " + other + " best, " + shareText(evidence.againstShare()) +
               " of what both saw stands where the other saw through";
    case PairVerdict::loose:
        return name + "what it shares with " + other + " leaves it free to slide";
    case PairVerdict::registered:
    case PairVerdict::apart:
        break;
    }
    return name + "it has too little in common with any other, at most " + shareText(evidence.agreeing) + " with " +
           other;
}

/// Groups that nothing joins overlap by chance: each has its first scan where that was said to stand.
void remarkGroups(const std::vector<ScanView>& scans, Registration& registration) {
    std::map<std::size_t, std::string> groups;
    for (std::size_t i = 0; i < scans.size(); ++i) {
        if (!registration.scans[i].isRegistered) continue;
        std::string& names = groups[registration.scans[i].group];
        names += (names.empty() ? "'" : ", '") + scans[i].name + "'";
    }
    if (groups.size() < 2) return;
    std::string all;
    for (const auto& [first, names] : groups)
        all += (all.empty() ? "" : "; and ") + names;
    registration.remarks.push_back("The scans fall into " + std::to_string(groups.size()) +
                                   " groups that nothing joins: " + all +
                                   ". Where the groups stand to each other is as their files say, or not known.");
}

/// What one can know of a scan before anything is compared.
void remarkUnits(const std::vector<ScanView>& scans, std::vector<std::string>& remarks) {
    std::vector<const ScanView*> filled;
    std::vector<double> ranges;
    for (const ScanView& scan : scans)
        if (scan.medianRangeMetres > 0) filled.push_back(&scan), ranges.push_back(scan.medianRangeMetres);
    if (filled.size() < 2) return;
    if (filled.size() == 2) {
        const auto [least, most] = std::minmax(ranges[0], ranges[1]);
        if (most > kOtherUnits * least)
            remarks.push_back("One of the scans '" + filled[0]->name + "' and '" + filled[1]->name +
                              "' is in other units (millimetres, metres) than the other; export both in metres.");
        return;
    }
    std::nth_element(ranges.begin(), ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() / 2), ranges.end());
    const double usual = ranges[ranges.size() / 2];
    for (const ScanView* scan : filled) {
        const double times = scan->medianRangeMetres / usual;
        if (times > kOtherUnits || times * kOtherUnits < 1)
            remarks.push_back("Scan '" + scan->name + "' is " +
                              std::string(times > 1 ? "much larger" : "much smaller") +
                              " than the others, as if it were in other units (millimetres, metres); export it in "
                              "metres.");
    }
}

} // namespace

Registration registerScans(const std::vector<ScanView>& scans, const RegistrationOptions& options,
                           const std::function<void()>& told) {
    std::vector<PairOutcome> pairs;
    for (std::size_t i = 0; i < scans.size(); ++i)
        for (std::size_t j = i + 1; j < scans.size(); ++j)
            pairs.push_back({i, j, {}, false, false});
    const std::vector<bool> areGiven = arePosesGiven(scans);
    tbb::parallel_for(std::size_t{0}, pairs.size(), [&](std::size_t k) {
        const ScanView &a = scans[pairs[k].a], &b = scans[pairs[k].b];
        std::optional<Pose> rough;
        if (areGiven[pairs[k].a] && areGiven[pairs[k].b])
            rough = inverse(a.givenWorldFromScanner) * b.givenWorldFromScanner;
        pairs[k].result = registerPair(a, b, rough, options.pair);
        if (told) told();
    });
    return joinScans(scans, std::move(pairs), options);
}

Registration joinScans(const std::vector<ScanView>& scans, std::vector<PairOutcome> pairs,
                       const RegistrationOptions& options) {
    Registration registration;
    registration.scans.resize(scans.size());
    registration.pairs = std::move(pairs);
    if (scans.empty()) return registration;
    remarkUnits(scans, registration.remarks);
    Joining joining(scans, options, registration);
    joining.join();
    joining.adjust();
    remarkGroups(scans, registration);

    for (std::size_t i = 0; i < scans.size(); ++i) {
        ScanOutcome& scan = registration.scans[i];
        if (scan.isRegistered) continue;
        scan.why = whyNot(i, scans, registration);
        const std::size_t other = i == 0 ? 1 : 0;
        // Places that repeat often look alike in a mirror, too: that says nothing.
        const bool fitsNowhere = std::none_of(registration.pairs.begin(), registration.pairs.end(), [&](const auto& p) {
            return (p.a == i || p.b == i) && p.result.verdict != PairVerdict::apart &&
                   p.result.verdict != PairVerdict::contradicted;
        });
        if (fitsNowhere && other < scans.size() && isMirrorOf(scans[other], scans[i], options.pair))
            scan.why += "; seen in a mirror it fits '" + scans[other].name +
                        "': one axis of the one or of the other is turned round, export both with right-handed axes";
    }
    for (const PairOutcome& pair : registration.pairs)
        if (pair.isUsed && glm::length(pair.result.best.aFromB.translation) < kSameScannerMetres)
            registration.remarks.push_back("Scans '" + scans[pair.a].name + "' and '" + scans[pair.b].name +
                                           "' were taken from the same place.");
    return registration;
}

} // namespace scene
