#include "scene/align/register_pair.h"

#include "scene/align/joint_surfaces.h"
#include "scene/align/panorama_places.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <glm/geometric.hpp>

namespace scene {

namespace {

constexpr int kVoteStride = 2;      ///< of cells, in the coarsest panorama's
constexpr int kLeastVotes = 5;      ///< cells of two planes that lie on each other
constexpr double kLeastShare = 0.1; ///< of the smaller plane's cells
constexpr double kFacing = 0.985;   ///< cosine between planes that may be one
/// What cannot be outweighs what fits: where much repeats, most of a wrong pose fits. Poses that are only about right
/// have some against them, too.
constexpr double kAgainst = 30, kRoughAgainst = 5;
constexpr std::size_t kSettled = 30; ///< candidates whose planes are laid on each other
constexpr double kHopeless = 0.1;    ///< of PoseEvidence::againstShare
constexpr std::size_t kCompared = 6; ///< of those, how many are made exact and judged
constexpr double kElsewhereMetres = 0.15, kElsewhereCosine = 0.9994;
/// Poses nearer than this to a rough one are what its author may have meant.
constexpr double kRoughMetres = 1.0, kRoughCosine = 0.94;

bool isAbout(const Pose& rough, const Pose& pose) {
    return glm::distance(rough.translation, pose.translation) < kRoughMetres &&
           cosineBetween(rough.rotation, pose.rotation) > kRoughCosine;
}

void countMeetings(const ScanView& from, const ScanView& to, const Pose& toFromFrom, double metres, bool isSwapped,
                   std::map<std::pair<std::size_t, std::size_t>, int>& votes) {
    PanoramaPlaces places;
    for (const CellOnPlane& cell : from.cellsOnPlanes)
        places.add(cell.point);
    places.find(toFromFrom, to.panorama.height());
    std::vector<glm::dvec3> normals;
    for (const ScanPlane& plane : from.planes)
        normals.push_back(toFromFrom.rotation * plane.normal);
    std::pair<std::size_t, std::size_t> last;
    int* ofLast = nullptr; // cells beside each other mostly meet the same plane
    for (int k = 0; k < places.count(); ++k) {
        const int cell = places.cell(k);
        const std::int32_t seen = cell >= 0 ? to.planeAt.pixels()[static_cast<std::size_t>(cell)] : -1;
        if (seen < 0) continue;
        const auto i = static_cast<std::size_t>(from.cellsOnPlanes[static_cast<std::size_t>(k)].plane),
                   j = static_cast<std::size_t>(seen);
        const ScanPlane& plane = to.planes[j];
        if (std::abs(glm::dot(plane.normal, places.point(k)) - plane.offset) > metres) continue;
        if (glm::dot(plane.normal, normals[i]) < kFacing) continue;
        const auto pair = isSwapped ? std::pair(j, i) : std::pair(i, j);
        if (ofLast == nullptr || pair != last) ofLast = &votes[pair], last = pair;
        ++*ofLast;
    }
}

} // namespace

bool areElsewhere(const Pose& a, const Pose& b) {
    return glm::distance(a.translation, b.translation) > kElsewhereMetres ||
           cosineBetween(a.rotation, b.rotation) < kElsewhereCosine;
}

void listPlanes(ScanView& view) {
    const Panorama& panorama = view.panorama;
    view.planeAt = Image<std::int32_t>(panorama.width(), panorama.height());
    std::ranges::transform(panorama.cells.pixels(), view.planeAt.pixels().begin(), &PanoramaCell::plane);
    view.cellsOnPlanes.clear();
    const int stride = kVoteStride * panorama.finerThanCoarse();
    for (int y = 0; y < panorama.height(); y += stride)
        for (int x = 0; x < panorama.width(); x += stride)
            if (const PanoramaCell& cell = panorama.cells(x, y); cell.plane >= 0)
                view.cellsOnPlanes.push_back({cell.point, cell.plane});
}

ScanView viewOf(const Scan& scan) {
    ScanView view;
    view.name = scan.name;
    view.givenWorldFromScanner = scan.worldFromScanner;
    view.panorama = panoramaOf(scan);
    view.planes = planesOf(scan, view.panorama);
    listPlanes(view);
    std::vector<float> ranges;
    for (const PanoramaCell& cell : view.panorama.cells.pixels())
        if (cell.samples > 0) ranges.push_back(cell.nearest);
    if (!ranges.empty()) {
        const auto middle = ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() / 2);
        std::nth_element(ranges.begin(), middle, ranges.end());
        view.medianRangeMetres = static_cast<double>(*middle);
    }
    return view;
}

std::vector<PlaneMatch> planesThatMeet(const ScanView& a, const ScanView& b, const Pose& aFromB, double metres) {
    std::map<std::pair<std::size_t, std::size_t>, int> votes;
    countMeetings(a, b, inverse(aFromB), metres, false, votes);
    countMeetings(b, a, aFromB, metres, true, votes);
    std::vector<PlaneMatch> matches;
    for (const auto& [pair, count] : votes) {
        const auto asked = [](const ScanView& view, std::size_t plane) {
            const int stride = kVoteStride * view.panorama.finerThanCoarse();
            return view.planes[plane].cells / (stride * stride);
        };
        const int smaller = std::min(asked(a, pair.first), asked(b, pair.second));
        if (count >= kLeastVotes && count >= kLeastShare * smaller) matches.push_back({pair.first, pair.second});
    }
    return matches;
}

std::optional<PairFit> settleOnPlanes(const ScanView& a, const ScanView& b, const Pose& aFromB,
                                      const PairOptions& options) {
    PairFit fit;
    fit.aFromB = aFromB;
    const std::vector<const std::vector<ScanPlane>*> planes{&a.planes, &b.planes};
    for (const double metres : {0.12, 0.06, 0.03}) {
        fit.matches = planesThatMeet(a, b, fit.aFromB, metres);
        if (static_cast<int>(fit.matches.size()) < options.leastSharedPlanes) return std::nullopt;
        std::vector<SharedPlane> shared;
        for (const PlaneMatch& match : fit.matches)
            shared.push_back({{{0, match.a}, {1, match.b}}});
        const JointResult joint = adjustJointly(planes, shared, {Pose{}, fit.aFromB}, 0, metres / 3);
        fit.aFromB = joint.worldFromScanners[1];
    }
    return fit;
}

std::optional<PairFit> settlePair(const ScanView& a, const ScanView& b, const Pose& aFromB,
                                  const PairOptions& options) {
    std::optional<PairFit> fit = settleOnPlanes(a, b, aFromB, options);
    if (!fit) return fit;
    SurfaceOptions surfaces;
    surfaces.stride = 2;
    const JointResult laid = layOnSurfaces({&a.panorama, &b.panorama}, {{0, 1}}, {Pose{}, fit->aFromB}, 0, surfaces);
    fit->aFromB = laid.worldFromScanners[1];
    fit->rmsMetres = laid.rmsMetres;
    fit->deviation = laid.deviations[1];
    fit->isHeld = laid.isHeld;
    fit->evidence = checkPose(a.panorama, b.panorama, fit->aFromB);
    return fit;
}

PairResult registerPair(const ScanView& a, const ScanView& b, const std::optional<Pose>& roughAFromB,
                        const PairOptions& options) {
    std::vector<Pose> starts;
    if (roughAFromB) starts.push_back(*roughAFromB);
    // What the candidates are worth is told by a quick look first, made exact where that is promising.
    struct Looked {
        Pose aFromB;
        double score;
    };
    std::vector<Looked> looked;
    PoseCheckOptions quick;
    quick.stride = 4;
    quick.toleranceMetres = 0.15;
    quick.toleranceShare = 0.03;
    for (const PoseCandidate& candidate : findCandidates(a.planes, b.planes, options.candidates))
        looked.push_back(
            {candidate.aFromB, checkPose(a.panorama, b.panorama, candidate.aFromB, quick).score(kRoughAgainst)});
    const auto isMeant = [&](const Pose& aFromB) { return roughAFromB && isAbout(*roughAFromB, aFromB); };
    std::stable_sort(looked.begin(), looked.end(), [&](const Looked& x, const Looked& y) {
        if (isMeant(x.aFromB) != isMeant(y.aFromB)) return isMeant(x.aFromB);
        return x.score > y.score;
    });
    for (std::size_t i = 0; i < std::min(looked.size(), kSettled); ++i)
        starts.push_back(looked[i].aFromB);

    std::vector<PairFit> rough;
    for (const Pose& start : starts) {
        std::optional<PairFit> fit = settleOnPlanes(a, b, start, options);
        if (!fit) continue;
        const bool isKnown = std::any_of(
            rough.begin(), rough.end(), [&](const PairFit& other) { return !areElsewhere(other.aFromB, fit->aFromB); });
        if (isKnown) continue;
        PoseCheckOptions check;
        check.stride = 2;
        check.toleranceMetres = 0.06;
        fit->evidence = checkPose(a.panorama, b.panorama, fit->aFromB, check);
        rough.push_back(std::move(*fit));
    }
    // A pose that nothing speaks against comes before any that fits more and cannot be.
    const auto isBetter = [&](const PairFit& x, const PairFit& y) {
        const auto isFree = [&](const PairFit& fit) {
            return fit.evidence.agreeing >= options.leastOverlap &&
                   fit.evidence.againstShare() <= options.mostAgainstShare;
        };
        if (isFree(x) != isFree(y)) return isFree(x);
        return x.evidence.score(kAgainst) > y.evidence.score(kAgainst);
    };
    std::stable_sort(rough.begin(), rough.end(), isBetter);
    std::stable_partition(rough.begin(), rough.end(), [&](const PairFit& fit) { return isMeant(fit.aFromB); });
    if (rough.size() > kCompared) rough.resize(kCompared);
    // What is seen through all over gets no better by a closer look; the first two are kept to tell of.
    if (rough.size() > 2)
        rough.erase(std::remove_if(rough.begin() + 2, rough.end(),
                                   [](const PairFit& fit) { return fit.evidence.againstShare() > kHopeless; }),
                    rough.end());
    std::vector<PairFit> fits;
    for (const PairFit& start : rough) {
        std::optional<PairFit> fit = settlePair(a, b, start.aFromB, options);
        if (!fit) continue;
        const bool isKnown = std::any_of(
            fits.begin(), fits.end(), [&](const PairFit& other) { return !areElsewhere(other.aFromB, fit->aFromB); });
        if (!isKnown) fits.push_back(std::move(*fit));
    }
    std::stable_sort(fits.begin(), fits.end(), isBetter);

    PairResult result;
    if (fits.empty()) return result;
    const auto fitsWith = [&](const PairFit& fit, double mostAgainst) {
        return fit.evidence.agreeing >= options.leastOverlap && fit.evidence.againstShare() <= mostAgainst;
    };
    // Somebody's word decides between poses that fit, and makes up for a little that does not.
    if (roughAFromB) {
        std::vector<const PairFit*> meant;
        for (const PairFit& fit : fits)
            if (isMeant(fit.aFromB) && fit.isHeld && fitsWith(fit, options.mostAgainstShareGiven))
                meant.push_back(&fit);
        const bool isOnly = !meant.empty() && std::none_of(meant.begin() + 1, meant.end(), [&](const PairFit* other) {
            return other->evidence.againstShare() <=
                   std::max(options.mostAgainstShareRival, 2 * meant[0]->evidence.againstShare());
        });
        if (isOnly) {
            result.best = *meant[0];
            result.plausible = {result.best.aFromB};
            result.verdict = PairVerdict::registered;
            result.isDecidedByGivenPose = meant[0] != &fits[0];
            return result;
        }
    }
    result.best = fits[0];
    if (fits.size() > 1) result.rival = fits[1];
    for (const PairFit& fit : fits)
        if (fitsWith(fit, options.mostAgainstShareRival)) result.plausible.push_back(fit.aFromB);
    if (result.best.evidence.agreeing < options.leastOverlap) return result;
    if (!fitsWith(result.best, options.mostAgainstShare))
        result.verdict = PairVerdict::contradicted;
    else if (result.plausible.size() > 1)
        result.verdict = PairVerdict::ambiguous;
    else
        result.verdict = result.best.isHeld ? PairVerdict::registered : PairVerdict::loose;
    return result;
}

} // namespace scene
