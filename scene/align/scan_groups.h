#pragma once
// Scans joined into groups by what is known of pairs. A pair that is sure joins two groups; and where places repeat, so
// that no pair is sure, all scans of two groups tell at which of the places that pairs know nothing is seen through.

#include "scene/align/register_pair.h"

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace scene {

struct PairOutcome {
    std::size_t a = 0, b = 0; ///< indices of scans
    PairResult result;        ///< as the two alone have it
    bool isGiven = false;     ///< somebody says so: it goes before all that was found
    bool isUsed = false;      ///< it joins two scans of a group
    bool isRefused = false;   ///< sure by itself, but a third scan says otherwise
    bool isSettled = false;   ///< ambiguous by itself, used at the place that is left by other scans
};

/// Scans contradict each other if as much of what both saw cannot be. More than for a pair alone: errors of several
/// pairs add up before all are adjusted.
bool areContradictory(const PoseEvidence& evidence);

/// Of PoseEvidence::againstShare over all scans of two groups, as PairOptions has them for a pair.
struct SeveralOptions {
    double mostAgainstShare = 0.002, mostAgainstShareRival = 0.004;
};

/// Every scan is a group at first. Both are to stay as long as the groups do; what becomes of pairs is marked in them.
class ScanGroups {
  public:
    ScanGroups(std::span<const ScanView> scans, std::span<PairOutcome> pairs);

    /// What was given first, then the surest pair; one that would make two scans contradict each other joins nothing,
    /// nor does, of those that were found, one that not more pairs agree with than deny: of two that differ one is
    /// wrong, and neither says which.
    void joinBySure();

    /// Then by pairs of which none is sure. Two groups are joined at a place that more pairs between them know than do
    /// not, if at all other places that any of those pairs knows the scans of both groups together contradict each
    /// other. What most pairs know goes first.
    void joinBySeveral(const SeveralOptions& options = {});

    std::size_t groupOf(std::size_t scan) const { return group_[scan]; }          ///< the first of its scans, mostly
    const Pose& groupFromScanner(std::size_t scan) const { return poses_[scan]; } ///< not yet adjusted

  private:
    /// A place of one group in another, and the pairs that fit there.
    struct Meeting {
        std::size_t into = 0, from = 0;
        Pose intoFromOther;
        std::vector<PairOutcome*> agreeing;
    };

    bool isBetween(const PairOutcome& pair, std::size_t into, std::size_t from) const;
    bool agrees(const PairOutcome& pair, std::size_t into, const Pose& intoFromOther) const;
    bool isBelieved(std::size_t into, std::size_t from, const Pose& intoFromOther) const;
    bool areCompatible(std::size_t into, std::size_t from, const Pose& intoFromOther) const;
    PoseEvidence evidenceOf(const Meeting& meeting) const; ///< of all scans of both, summed
    std::vector<Meeting> meetingsOf(std::size_t into, std::size_t from, const std::vector<PairOutcome*>& between) const;
    std::optional<Meeting> onlyMeeting(std::size_t into, std::size_t from, const SeveralOptions& options) const;
    void merge(std::size_t into, std::size_t from, const Pose& intoFromOther);

    std::span<const ScanView> scans_;
    std::span<PairOutcome> pairs_;
    std::vector<std::size_t> group_;
    std::vector<Pose> poses_; ///< groupFromScanner
};

} // namespace scene
