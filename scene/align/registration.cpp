#include "scene/align/registration.h"

#include "scene/align/joint_surfaces.h"
#include "scene/align/lost_scans.h"
#include "scene/align/mirrored.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include <glm/geometric.hpp>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr double kSameScannerMetres = 0.02;
constexpr double kOtherUnits =
    50; ///< times the range of another scan: millimetres, or feet and miles, not a larger room

/// "1.2 %" for sentences.
std::string shareText(double share) {
    char text[32];
    std::snprintf(text, sizeof text, "%.1f %%", 100 * share);
    return text;
}

/// Groups, laid on what their scans have in common and put where they were said to stand.
class Adjusting {
  public:
    Adjusting(const std::vector<ScanView>& scans, const ScanGroups& groups, const RegistrationOptions& options,
              Registration& registration)
        : scans_(scans), groups_(groups), options_(options), registration_(registration) {}

    void adjust(const std::vector<bool>& areSaid) {
        std::map<std::size_t, std::vector<std::size_t>> members;
        for (std::size_t i = 0; i < scans_.size(); ++i)
            members[groups_.groupOf(i)].push_back(i);
        for (const auto& [group, ofGroup] : members)
            adjustGroup(ofGroup, areSaid);
    }

  private:
    void adjustGroup(const std::vector<std::size_t>& members, const std::vector<bool>& areSaid) {
        const auto said = std::ranges::find_if(members, [&](std::size_t i) { return areSaid[i]; });
        const std::size_t fixed = said == members.end() ? 0 : static_cast<std::size_t>(said - members.begin());
        const std::size_t first = members[fixed];
        const Pose worldFromGroup = scans_[first].givenWorldFromScanner * inverse(groups_.groupFromScanner(first));
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
            poses.push_back(worldFromGroup * groups_.groupFromScanner(i));
        }
        poses[fixed] = scans_[first].givenWorldFromScanner; // to the last bit
        PoseCheckOptions check;
        check.stride = 2;
        std::vector<std::pair<std::size_t, std::size_t>> pairs;
        for (std::size_t i = 0; i < members.size(); ++i)
            for (std::size_t j = i + 1; j < members.size(); ++j)
                if (checkPose(*panoramas[i], *panoramas[j], inverse(poses[i]) * poses[j], check).agreeing >=
                    options_.leastJointOverlap)
                    pairs.emplace_back(i, j);
        const JointResult joint = layOnSurfaces(panoramas, pairs, poses, fixed);
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
                if (!areContradictory(evidence)) continue;
                registration_.remarks.push_back(
                    "Scans '" + scans_[i].name + "' and '" + scans_[j].name +
                    "' contradict each other where they were registered: " + shareText(evidence.againstShare()) +
                    " of what both saw stands where the other saw through.");
            }
    }

    const std::vector<ScanView>& scans_;
    const ScanGroups& groups_;
    const RegistrationOptions& options_;
    Registration& registration_;
};

bool faceOneWay(const std::vector<ScanPlane>& planes) {
    return std::all_of(planes.begin(), planes.end(), [&](const ScanPlane& plane) {
        return std::abs(glm::dot(plane.normal, planes[0].normal)) > 0.95;
    });
}

std::string whyNot(std::size_t scan, const std::vector<ScanView>& scans, const Registration& registration) {
    const std::string name =
        "Scan '" + scans[scan].name +
        (registration.scans[scan].isLost ? "' is left out, since nothing says where it stands to the others: "
                                         : "' stands where it was said to stand: ");
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

std::string listOf(const std::vector<std::string>& names) {
    std::string list;
    for (const std::string& name : names)
        list += (list.empty() ? "'" : ", '") + name + "'";
    return list;
}

/// Each scan that is not registered has its own sentence (whyNot).
void remarkGroups(const std::vector<ScanView>& scans, Registration& registration) {
    std::map<std::size_t, std::vector<std::string>> groups;
    std::vector<std::string> lost;
    bool isAnyLost = false;
    for (std::size_t i = 0; i < scans.size(); ++i) {
        const ScanOutcome& scan = registration.scans[i];
        isAnyLost |= scan.isLost;
        if (!scan.isRegistered) continue;
        groups[scan.group].push_back(scans[i].name);
        if (scan.isLost) lost.push_back(scans[i].name);
    }
    if (groups.size() > 1) {
        std::string all;
        for (const auto& [first, names] : groups)
            all += (all.empty() ? "" : "; and ") + listOf(names);
        registration.remarks.push_back(
            "The scans fall into " + std::to_string(groups.size()) + " groups that nothing joins: " + all + "." +
            (lost.empty() ? " Where the groups stand to each other is as their files say." : ""));
    }
    if (!lost.empty())
        registration.remarks.push_back("Nothing says where scans " + listOf(lost) +
                                       " stand to the others: they are left out.");
    if (isAnyLost)
        registration.remarks.push_back(
            "Scans that are left out can be built by themselves, or be placed by planes that they share with others, "
            "in a file for --register (README); --register given draws all where their files have them.");
}

void findLostScans(const std::vector<ScanView>& scans, const std::vector<bool>& areSaid,
                   std::vector<ScanOutcome>& outcomes) {
    std::vector<FoundPlace> found;
    for (const ScanOutcome& scan : outcomes)
        found.push_back({scan.isRegistered, scan.group, scan.worldFromScanner});
    const std::vector<bool> isLost = findLost(scans, areSaid, found);
    for (std::size_t i = 0; i < outcomes.size(); ++i)
        outcomes[i].isLost = isLost[i];
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

/// The best of several places need not be the one that was taken.
void tellOfSettled(const std::vector<ScanView>& scans, const PairOptions& options,
                   const std::vector<ScanOutcome>& outcomes, std::vector<PairOutcome>& pairs) {
    for (PairOutcome& pair : pairs) {
        if (!pair.isSettled) continue;
        const Pose aFromB = inverse(outcomes[pair.a].worldFromScanner) * outcomes[pair.b].worldFromScanner;
        std::optional<PairFit> fit = settlePair(scans[pair.a], scans[pair.b], aFromB, options);
        if (!fit || areElsewhere(fit->aFromB, aFromB)) {
            fit.emplace();
            fit->aFromB = aFromB;
            fit->evidence = checkPose(scans[pair.a].panorama, scans[pair.b].panorama, aFromB);
            fit->rmsMetres = fit->evidence.rmsMetres;
            const PoseDeviation &a = outcomes[pair.a].deviation, &b = outcomes[pair.b].deviation;
            fit->deviation = {std::hypot(a.metres, b.metres), std::hypot(a.radians, b.radians), b.loosest};
        }
        pair.result.best = std::move(*fit);
    }
}

} // namespace

Registration registerScans(const std::vector<ScanView>& scans, const RegistrationOptions& options,
                           const FindPair& findPair, std::vector<PairOutcome> known) {
    std::set<std::pair<std::size_t, std::size_t>> areKnown;
    for (const PairOutcome& pair : known)
        areKnown.insert(std::minmax(pair.a, pair.b));
    std::vector<PairOutcome> pairs;
    for (std::size_t i = 0; i < scans.size(); ++i)
        for (std::size_t j = i + 1; j < scans.size(); ++j)
            if (!areKnown.contains({i, j})) pairs.push_back({i, j, {}});
    const std::vector<bool> areSaid = arePosesSaid(scans);
    tbb::parallel_for(std::size_t{0}, pairs.size(), [&](std::size_t k) {
        const std::size_t i = pairs[k].a, j = pairs[k].b;
        std::optional<Pose> rough;
        if (areSaid[i] && areSaid[j]) rough = inverse(scans[i].givenWorldFromScanner) * scans[j].givenWorldFromScanner;
        pairs[k].result = findPair ? findPair(i, j, rough) : registerPair(scans[i], scans[j], rough, options.pair);
    });
    std::ranges::move(known, std::back_inserter(pairs));
    return joinScans(scans, std::move(pairs), options);
}

Registration joinScans(const std::vector<ScanView>& scans, std::vector<PairOutcome> pairs,
                       const RegistrationOptions& options) {
    Registration registration;
    registration.scans.resize(scans.size());
    registration.pairs = std::move(pairs);
    if (scans.empty()) return registration;
    remarkUnits(scans, registration.remarks);
    ScanGroups groups(scans, registration.pairs);
    groups.joinBySure();
    groups.joinBySeveral(options.several);
    const std::vector<bool> areSaid = arePosesSaid(scans);
    Adjusting(scans, groups, options, registration).adjust(areSaid);
    findLostScans(scans, areSaid, registration.scans);
    remarkGroups(scans, registration);
    tellOfSettled(scans, options.pair, registration.scans, registration.pairs);

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
