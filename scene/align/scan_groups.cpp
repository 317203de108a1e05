#include "scene/align/scan_groups.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr double kContradiction = 0.02, kLeastContradiction = 0.003;

} // namespace

bool areContradictory(const PoseEvidence& evidence) {
    return evidence.against > kLeastContradiction && evidence.againstShare() > kContradiction;
}

ScanGroups::ScanGroups(std::span<const ScanView> scans, std::span<PairOutcome> pairs)
    : scans_(scans), pairs_(pairs), group_(scans.size()), poses_(scans.size()) {
    std::iota(group_.begin(), group_.end(), std::size_t{0});
}

void ScanGroups::joinBySure() {
    std::vector<PairOutcome*> sure;
    for (PairOutcome& pair : pairs_)
        if (pair.result.verdict == PairVerdict::registered) sure.push_back(&pair);
    std::stable_sort(sure.begin(), sure.end(), [](const PairOutcome* x, const PairOutcome* y) {
        if (x->isGiven != y->isGiven) return x->isGiven;
        return x->result.best.evidence.agreeing > y->result.best.evidence.agreeing;
    });
    for (PairOutcome* pair : sure) {
        if (group_[pair->a] == group_[pair->b]) {
            // A loop: it must close.
            pair->isRefused = areElsewhere(inverse(poses_[pair->a]) * poses_[pair->b], pair->result.best.aFromB);
            pair->isUsed = !pair->isRefused;
            continue;
        }
        const Pose aFromOther = poses_[pair->a] * pair->result.best.aFromB * inverse(poses_[pair->b]);
        const std::size_t from = group_[pair->b], into = group_[pair->a];
        pair->isUsed = (pair->isGiven || isBelieved(into, from, aFromOther)) && areCompatible(into, from, aFromOther);
        pair->isRefused = !pair->isUsed;
        if (pair->isUsed) merge(into, from, aFromOther);
    }
}

void ScanGroups::joinBySeveral(const SeveralOptions& options) {
    // What two groups know of each other stays as it is until one of them grows.
    std::map<std::pair<std::size_t, std::size_t>, std::optional<Meeting>> known;
    for (;;) {
        const std::set<std::size_t> groups(group_.begin(), group_.end());
        const Meeting* best = nullptr;
        for (auto into = groups.begin(); into != groups.end(); ++into)
            for (auto from = std::next(into); from != groups.end(); ++from) {
                const auto [entry, isNew] = known.try_emplace({*into, *from});
                if (isNew) entry->second = onlyMeeting(*into, *from, options);
                const std::optional<Meeting>& meeting = entry->second;
                if (meeting && (!best || meeting->agreeing.size() > best->agreeing.size())) best = &*meeting;
            }
        if (!best) return;
        const Meeting joined = *best;
        for (PairOutcome* pair : joined.agreeing) {
            pair->isUsed = true, pair->isRefused = false;
            pair->isSettled = pair->result.verdict == PairVerdict::ambiguous;
        }
        merge(joined.into, joined.from, joined.intoFromOther);
        std::erase_if(known, [&](const auto& entry) {
            const auto& [into, from] = entry.first;
            return into == joined.into || from == joined.into || into == joined.from || from == joined.from;
        });
    }
}

void ScanGroups::merge(std::size_t into, std::size_t from, const Pose& intoFromOther) {
    for (std::size_t i = 0; i < scans_.size(); ++i) {
        if (group_[i] != from) continue;
        poses_[i] = intoFromOther * poses_[i];
        group_[i] = into;
    }
}

/// Those that say where: they are sure, or know of several places.
bool ScanGroups::isBetween(const PairOutcome& pair, std::size_t into, std::size_t from) const {
    const PairVerdict verdict = pair.result.verdict;
    if (verdict != PairVerdict::registered && verdict != PairVerdict::ambiguous) return false;
    return (group_[pair.a] == into && group_[pair.b] == from) || (group_[pair.a] == from && group_[pair.b] == into);
}

/// Whether one of the places that the pair knows is where its scans stand then.
bool ScanGroups::agrees(const PairOutcome& pair, std::size_t into, const Pose& intoFromOther) const {
    const bool isForth = group_[pair.a] == into;
    const Pose intoFromA = isForth ? poses_[pair.a] : intoFromOther * poses_[pair.a];
    const Pose intoFromB = isForth ? intoFromOther * poses_[pair.b] : poses_[pair.b];
    const Pose aFromB = inverse(intoFromA) * intoFromB;
    return std::ranges::any_of(pair.result.plausible, [&](const Pose& pose) { return !areElsewhere(pose, aFromB); });
}

/// Every pair between the groups that is sure has a say, and an ambiguous one denies what is none of its poses.
bool ScanGroups::isBelieved(std::size_t into, std::size_t from, const Pose& intoFromOther) const {
    int agreeing = 0, denying = 0;
    for (const PairOutcome& pair : pairs_) {
        if (!isBetween(pair, into, from)) continue;
        const bool isSo = agrees(pair, into, intoFromOther);
        denying += !isSo;
        agreeing += isSo && pair.result.verdict == PairVerdict::registered; // several places speak for none
    }
    return agreeing > denying;
}

bool ScanGroups::areCompatible(std::size_t into, std::size_t from, const Pose& intoFromOther) const {
    PoseCheckOptions check;
    check.stride = 3;
    check.toleranceMetres = 0.08;
    for (std::size_t i = 0; i < scans_.size(); ++i)
        for (std::size_t j = 0; j < scans_.size(); ++j) {
            if (group_[i] != into || group_[j] != from) continue;
            const Pose iFromJ = inverse(poses_[i]) * intoFromOther * poses_[j];
            if (areContradictory(checkPose(scans_[i].panorama, scans_[j].panorama, iFromJ, check))) return false;
        }
    return true;
}

PoseEvidence ScanGroups::evidenceOf(const Meeting& meeting) const {
    PoseCheckOptions check;
    check.stride = 2;
    check.toleranceMetres = 0.06; // nothing is adjusted yet
    std::vector<std::pair<std::size_t, std::size_t>> pairs;
    for (std::size_t i = 0; i < scans_.size(); ++i)
        for (std::size_t j = 0; j < scans_.size(); ++j)
            if (group_[i] == meeting.into && group_[j] == meeting.from) pairs.emplace_back(i, j);
    std::vector<PoseEvidence> ofPairs(pairs.size());
    tbb::parallel_for(std::size_t{0}, pairs.size(), [&](std::size_t k) {
        const auto [i, j] = pairs[k];
        const Pose iFromJ = inverse(poses_[i]) * meeting.intoFromOther * poses_[j];
        ofPairs[k] = checkPose(scans_[i].panorama, scans_[j].panorama, iFromJ, check);
    });
    PoseEvidence all;
    for (const PoseEvidence& of : ofPairs)
        all.agreeing += of.agreeing, all.against += of.against;
    return all;
}

std::vector<ScanGroups::Meeting> ScanGroups::meetingsOf(std::size_t into, std::size_t from,
                                                        const std::vector<PairOutcome*>& between) const {
    std::vector<Meeting> meetings;
    for (const PairOutcome* pair : between)
        for (const Pose& aFromB : pair->result.plausible) {
            const Pose forth = poses_[pair->a] * aFromB * inverse(poses_[pair->b]);
            Meeting meeting{into, from, group_[pair->a] == into ? forth : inverse(forth), {}};
            std::ranges::copy_if(between, std::back_inserter(meeting.agreeing),
                                 [&](const PairOutcome* of) { return agrees(*of, into, meeting.intoFromOther); });
            const auto known = std::ranges::find_if(meetings, [&](const Meeting& other) {
                return !areElsewhere(other.intoFromOther, meeting.intoFromOther);
            });
            if (known == meetings.end())
                meetings.push_back(std::move(meeting));
            else if (known->agreeing.size() < meeting.agreeing.size())
                *known = std::move(meeting);
        }
    return meetings;
}

std::optional<ScanGroups::Meeting> ScanGroups::onlyMeeting(std::size_t into, std::size_t from,
                                                           const SeveralOptions& options) const {
    const auto isAlone = [&](std::size_t group) { return std::ranges::count(group_, group) == 1; };
    if (isAlone(into) && isAlone(from)) return std::nullopt; // the two have said it all
    std::vector<PairOutcome*> between;
    for (PairOutcome& pair : pairs_)
        if (isBetween(pair, into, from)) between.push_back(&pair);
    // First those that most pairs know: mostly there is none, and nothing else is to be asked.
    std::vector<Meeting> meetings = meetingsOf(into, from, between);
    std::ranges::stable_sort(meetings, std::ranges::greater{}, [](const Meeting& m) { return m.agreeing.size(); });
    std::optional<Meeting> only;
    for (Meeting& meeting : meetings) {
        const bool isOfMost = 2 * meeting.agreeing.size() > between.size();
        if (!only && !isOfMost) return std::nullopt;
        const double against = evidenceOf(meeting).againstShare();
        if (against > options.mostAgainstShareRival) continue;
        if (only || against > options.mostAgainstShare) return std::nullopt;
        only = std::move(meeting);
    }
    if (only && !areCompatible(into, from, only->intoFromOther)) return std::nullopt;
    return only;
}

} // namespace scene
