#include "render/draw_order.h"

#include "render/pipeline.h"
#include "scene/preference.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <numeric>
#include <vector>

namespace render {

namespace {

constexpr std::uint32_t kBatches = 3;
constexpr std::array kWarpsInOrder{Warp::adaptive, Warp::mesh, Warp::points, Warp::splats};
constexpr std::uint32_t kWarps = kWarpsInOrder.size();
constexpr std::uint32_t kReaches = 4;
constexpr std::uint32_t kKindsOfBatch = 2 * kWarps * kReaches; ///< near or far, warp, reach
constexpr std::uint32_t kKinds = kBatches * kKindsOfBatch;

/// Samples are put into a batch until they could cover the picture so many times. Those of one batch may hide each
/// other in vain; each further batch costs a look at the z-buffer, of which the first is dear.
constexpr std::array<double, kBatches - 1> kBatchCovers{1.5, 3};
using BatchEnds = std::array<std::uint32_t, kBatches - 1>; ///< the bins that batches go down to, descending

/// Fewer plain or small tiles go with those that need more: a dispatch more costs more than they save.
constexpr std::uint32_t kLeastPlain = 32;

/// Where what stands in view covers the picture less often, looking costs more than it saves.
constexpr double kLeastCover = 3;

/// Positive floats order as their bits do; a bin is an eighth of an octave.
constexpr std::uint32_t kBinShift = 20, kBins = 1u << (31 - kBinShift);
std::uint32_t binOf(float orderDisparity) {
    return std::bit_cast<std::uint32_t>(std::max(orderDisparity, 0.0f)) >> kBinShift;
}

/// All that was chosen by its place in list.chosen, piece by piece or band by band.
void putInTurn(bool byBand, DrawList& list) {
    list.inTurn.clear();
    for (std::size_t p = 0; p < list.counts.size(); ++p)
        for (std::uint32_t i = 0; i < list.counts[p]; ++i)
            list.inTurn.push_back(list.firstOfPiece[p] + i);
    if (!byBand) return;
    std::array<std::uint32_t, kBands + 1> next{};
    for (const std::uint32_t place : list.inTurn)
        ++next[list.chosen[place].band + 1];
    std::partial_sum(next.begin(), next.end(), next.begin());
    list.byBand.resize(list.inTurn.size());
    for (const std::uint32_t place : list.inTurn)
        list.byBand[next[list.chosen[place].band]++] = place;
    list.inTurn.swap(list.byBand);
}

/// What was chosen, in parts that are gone through at the same time. Where they begin depends on what was chosen alone,
/// so that sums are rounded alike on any number of threads.
class Parts {
  public:
    explicit Parts(DrawList& list) : list_(list) {
        constexpr std::size_t kDrawsPerPart = 4096, kMostParts = 16;
        count_ = std::clamp<std::size_t>(list.inTurn.size() / kDrawsPerPart, 1, kMostParts);
    }
    std::size_t count() const { return count_; }

    /// visit(part, chosen, its place in list.chosen): parts at the same time, each in order.
    template <class Visit>
    void forAll(Visit&& visit) const {
        tbb::parallel_for(std::size_t{0}, count(), [&](std::size_t part) {
            const std::size_t all = list_.inTurn.size(), end = (part + 1) * all / count_;
            for (std::size_t i = part * all / count_; i < end; ++i)
                visit(part, list_.chosen[list_.inTurn[i]], list_.inTurn[i]);
        });
    }

  private:
    DrawList& list_;
    std::size_t count_ = 1;
};

/// All of zero if everything goes into the first.
BatchEnds divide(const Parts& parts, double picturePixels) {
    BatchEnds ends{};
    if (picturePixels <= 0) return ends;
    std::vector<double> areas(parts.count() * kBins, 0.0);
    parts.forAll([&](std::size_t part, const DrawList::Chosen& chosen, std::size_t) {
        areas[part * kBins + binOf(chosen.orderDisparity)] += static_cast<double>(chosen.area);
    });
    for (std::size_t i = kBins; i < areas.size(); ++i)
        areas[i % kBins] += areas[i];
    areas.resize(kBins);
    if (std::accumulate(areas.begin(), areas.end(), 0.0) < kLeastCover * picturePixels) return ends;
    double sum = 0;
    std::size_t batch = 0;
    for (std::uint32_t bin = kBins; bin > 0 && batch < ends.size(); --bin) {
        sum += areas[bin - 1];
        while (batch < ends.size() && sum >= kBatchCovers[batch] * picturePixels)
            ends[batch++] = bin - 1;
    }
    return ends;
}

std::uint32_t kindOf(const DrawList::Chosen& chosen, const BatchEnds& batchEnds) {
    const std::uint32_t bin = binOf(chosen.orderDisparity);
    std::uint32_t batch = 0;
    while (batch < batchEnds.size() && bin < batchEnds[batch])
        ++batch;
    std::uint32_t rank = 0;
    while (kWarpsInOrder[rank] != chosen.warp)
        ++rank;
    // Points stand among the others: so they were measured before they looked at what is there already.
    const bool isFar = chosen.orderLevel == scene::kMaxOrderLevel && chosen.warp != Warp::points;
    return batch * kKindsOfBatch + kReaches * (rank + (isFar ? kWarps : 0)) + static_cast<std::uint32_t>(chosen.reach);
}
std::uint32_t batchOf(std::uint32_t kind) {
    return kind / kKindsOfBatch;
}
Warp warpOf(std::uint32_t kind) {
    return kWarpsInOrder[kind / kReaches % kWarps];
}
Reach reachOf(std::uint32_t kind) {
    return static_cast<Reach>(kind % kReaches);
}

/// How many are drawn of each kind from each page, counted by part. A bucket is one kind and one page.
struct Buckets {
    std::uint32_t pages = 1;
    std::size_t perPart = 0;
    std::vector<std::uint32_t>& counts; ///< part by part; then, where the next of each goes

    std::uint32_t total(std::size_t bucket) const {
        std::uint32_t sum = 0;
        for (std::size_t i = bucket; i < counts.size(); i += perPart)
            sum += counts[i];
        return sum;
    }
    std::uint32_t of(const DrawList::Chosen& chosen) const { return chosen.kind * pages + chosen.page; }
    std::uint32_t kindOf(std::size_t bucket) const { return static_cast<std::uint32_t>(bucket) / pages; }
};

/// Where too few are plain, or small, those go with others beside them that need more. Plain splats never do: they
/// leave out corners. Returns into which bucket what is of one goes.
std::vector<std::uint32_t> joinFewPlain(Buckets& buckets) {
    std::vector<std::uint32_t> joined(buckets.perPart);
    std::iota(joined.begin(), joined.end(), 0u);
    for (std::size_t few = 0; few < buckets.perPart; ++few) {
        const std::uint32_t kind = buckets.kindOf(few);
        if (reachOf(kind) >= Reach::any || warpOf(kind) == Warp::splats) continue;
        const std::uint32_t count = buckets.total(few);
        if (count == 0 || count >= kLeastPlain) continue;
        std::size_t others = few + buckets.pages;
        if (reachOf(kind) == Reach::plain && buckets.total(others) == 0) others += buckets.pages;
        if (buckets.total(others) == 0) continue;
        for (std::size_t first = 0; first < buckets.counts.size(); first += buckets.perPart) {
            buckets.counts[first + others] += buckets.counts[first + few];
            buckets.counts[first + few] = 0;
        }
        joined[few] = static_cast<std::uint32_t>(others);
    }
    for (std::uint32_t& into : joined) // what went with small ones that went on themselves
        into = joined[into];
    return joined;
}

void makeRuns(const Buckets& buckets, DrawList& list) {
    list.runs.clear();
    std::uint32_t first = 0;
    for (std::size_t bucket = 0; bucket < buckets.perPart; ++bucket) {
        const std::uint32_t kind = buckets.kindOf(bucket);
        for (std::uint32_t left = buckets.total(bucket); left > 0;) {
            DrawRun next{static_cast<std::uint32_t>(bucket % buckets.pages),
                         first,
                         0,
                         warpOf(kind),
                         batchOf(kind),
                         0,
                         reachOf(kind)};
            if (list.runs.empty() || !areOfOneRun(list.runs.back(), next) || list.runs.back().count == kMaxWorkgroups) {
                const bool isOfBatch = !list.runs.empty() && list.runs.back().batch == next.batch;
                next.number = isOfBatch ? list.runs.back().number + 1 : 0;
                list.runs.push_back(next);
            }
            const std::uint32_t taken = std::min(left, kMaxWorkgroups - list.runs.back().count);
            list.runs.back().count += taken;
            left -= taken, first += taken;
        }
    }
    list.tiles = first;
}

/// From how many there are of each to where each part's first goes.
void placeParts(Buckets& buckets) {
    std::uint32_t next = 0;
    for (std::size_t bucket = 0; bucket < buckets.perPart; ++bucket)
        for (std::size_t i = bucket; i < buckets.counts.size(); i += buckets.perPart) {
            const std::uint32_t count = buckets.counts[i];
            buckets.counts[i] = next;
            next += count;
        }
}

} // namespace

std::uint32_t bandOf(double row) {
    return static_cast<std::uint32_t>(std::clamp(row / kBandRows, 0.0, kBands - 1.0));
}

void orderDraws(double picturePixels, std::uint64_t leastItems, DrawList& list) {
    putInTurn(picturePixels > 0, list);
    const Parts parts(list);
    std::vector<std::uint64_t> items(parts.count(), 0);
    parts.forAll([&](std::size_t part, const DrawList::Chosen& chosen, std::size_t) { items[part] += chosen.items; });
    list.items = std::accumulate(items.begin(), items.end(), std::uint64_t{0});
    // What is likely seen comes first, so that the rest finds itself hidden early.
    const BatchEnds batchEnds = divide(parts, list.items < leastItems ? 0 : picturePixels);
    std::vector<std::uint32_t> pages(parts.count(), 1);
    parts.forAll([&](std::size_t part, DrawList::Chosen& chosen, std::size_t) {
        chosen.kind = kindOf(chosen, batchEnds);
        chosen.batch = batchOf(chosen.kind);
        pages[part] = std::max(pages[part], chosen.page + 1);
    });

    Buckets buckets{*std::max_element(pages.begin(), pages.end()), 0, list.firsts};
    buckets.perPart = std::size_t{kKinds} * buckets.pages;
    list.firsts.assign(parts.count() * buckets.perPart, 0);
    parts.forAll([&](std::size_t part, DrawList::Chosen& chosen, std::size_t) {
        ++list.firsts[part * buckets.perPart + buckets.of(chosen)];
    });
    const std::vector<std::uint32_t> joined = joinFewPlain(buckets);
    makeRuns(buckets, list);
    placeParts(buckets);
    list.order.resize(list.tiles);
    parts.forAll([&](std::size_t part, DrawList::Chosen& chosen, std::uint32_t place) {
        const std::uint32_t bucket = joined[buckets.of(chosen)];
        chosen.kind = buckets.kindOf(bucket);
        list.order[list.firsts[part * buckets.perPart + bucket]++] = place;
    });
}

} // namespace render
