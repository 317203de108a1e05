#include "render/pair_list.h"

#include "render/pipeline.h"
#include "render/target.h"

#include <algorithm>
#include <cassert>

namespace render {

namespace {

bool isOfSamples(const DrawList& list, bool mayBeWide) {
    return std::all_of(list.runs.begin(), list.runs.end(), [&](const DrawRun& run) {
        return (run.warp == Warp::points || run.warp == Warp::splats) && (mayBeWide || run.reach != Reach::wide);
    });
}

const DrawList::Chosen& chosenOf(const DrawList& list, std::uint32_t draw) {
    return list.chosen[list.order[draw]];
}

/// Pairs in no order, and the bucket of each. A tile stands once in each list: drawn twice is only what surfaces are
/// drawn of, too.
void findPairs(std::size_t tiles, const DrawList& left, const DrawList& right, PairList& list) {
    list.unsorted.clear(), list.buckets.clear();
    list.rightOfTile.resize(tiles, kNoDraw);
    std::uint32_t pages = 0;
    for (const DrawList* of : {&left, &right})
        for (const DrawRun& run : of->runs)
            pages = std::max(pages, run.page + 1);
    const auto add = [&](PairDraw pair, const DrawList::Chosen& chosen) {
        list.unsorted.push_back(pair);
        list.buckets.push_back(chosen.kind * pages + chosen.page);
    };
    for (std::uint32_t i = 0; i < right.tiles; ++i)
        list.rightOfTile[chosenOf(right, i).tile] = i;
    for (std::uint32_t i = 0; i < left.tiles; ++i) {
        const DrawList::Chosen& chosen = chosenOf(left, i);
        std::uint32_t& other = list.rightOfTile[chosen.tile];
        const bool isShared = other != kNoDraw && chosenOf(right, other).batch == chosen.batch &&
                              chosenOf(right, other).warp == chosen.warp;
        add({i, isShared ? other : kNoDraw, 0, kAllRows, kAllRows}, chosen);
        if (isShared) other = kNoDraw;
    }
    for (std::uint32_t i = 0; i < right.tiles; ++i) {
        const DrawList::Chosen& chosen = chosenOf(right, i);
        std::uint32_t& rest = list.rightOfTile[chosen.tile];
        if (rest != kNoDraw) add({kNoDraw, i, 0, kAllRows, kAllRows}, chosen);
        rest = kNoDraw;
    }
}

} // namespace

bool uniteDraws(std::size_t tiles, const DrawList& left, const DrawList& right, bool mayBeWide, PairList& list) {
    if (!isOfSamples(left, mayBeWide) || !isOfSamples(right, mayBeWide)) return false;
    findPairs(tiles, left, right, list);

    const auto highest = std::max_element(list.buckets.begin(), list.buckets.end());
    list.firsts.assign(highest != list.buckets.end() ? std::size_t{*highest} + 2 : 1, 0);
    for (const std::uint32_t bucket : list.buckets)
        ++list.firsts[bucket + 1];
    for (std::size_t i = 1; i < list.firsts.size(); ++i)
        list.firsts[i] += list.firsts[i - 1];
    list.pairs.resize(list.unsorted.size());
    for (std::size_t i = 0; i < list.unsorted.size(); ++i)
        list.pairs[list.firsts[list.buckets[i]]++] = list.unsorted[i];

    list.runs.clear();
    std::uint32_t run = 0; // of its batch
    for (std::uint32_t i = 0; i < list.pairs.size(); ++i) {
        PairDraw& pair = list.pairs[i];
        const DrawList::Chosen& chosen = pair.left != kNoDraw ? chosenOf(left, pair.left) : chosenOf(right, pair.right);
        DrawRun next{chosen.page, i, 0, chosen.warp, chosen.batch};
        if (list.runs.empty() || !areOfOneRun(list.runs.back(), next) || list.runs.back().count == kMaxWorkgroups) {
            run = list.runs.empty() || list.runs.back().batch != next.batch ? 0 : run + 1;
            if (run >= kMostTestedRuns) return false;
            next.number = run;
            list.runs.push_back(next);
        }
        pair.run = run;
        ++list.runs.back().count;
    }
    return true;
}

} // namespace render
