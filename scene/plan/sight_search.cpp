#include "scene/plan/sight_search.h"

#include "scene/directions.h"
#include "scene/plan/walk_cells.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

#include <glm/geometric.hpp>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

using Word = std::uint64_t;
constexpr int kWordBits = 64;

/// Every so many of a list.
std::vector<glm::dvec3> spreadOver(std::span<const glm::dvec3> places, int most) {
    const std::size_t count = std::min(places.size(), static_cast<std::size_t>(most));
    std::vector<glm::dvec3> some;
    for (std::size_t i = 0; i < count; ++i)
        some.push_back(places[(2 * i + 1) * places.size() / (2 * count)]);
    return some;
}

/// What a walker sees in one direction.
struct Look {
    SightEnd end;
    double spread = 0; ///< area of surface for each unit of solid angle, square metres
};

double spreadOf(const SightEnd& end, const glm::dvec3& from) {
    const glm::dvec3 way = end.position - from;
    const double cosine = std::abs(glm::dot(glm::normalize(way), end.normal));
    return glm::dot(way, way) / std::max(cosine, 1e-3);
}

/// What is seen of a curtain from behind is not what is seen of it.
bool isSameSide(const SightEnd& end, const glm::dvec3& a, const glm::dvec3& b) {
    return glm::dot(a - end.position, end.normal) * glm::dot(b - end.position, end.normal) > 0;
}

/// Which candidate knows which end of a look: bits, each walker's in words of its own.
class Sight {
  public:
    Sight(std::span<const glm::dvec3> places, const SightLines& lines, const SightSearchOptions& options)
        : candidates_(spreadOver(places, options.candidates)), walkers_(spreadOver(places, options.walkers)),
          words_((static_cast<std::size_t>(options.looks) + kWordBits - 1) / kWordBits) {
        findAbout(static_cast<std::size_t>(options.exchanged));
        findLooks(lines, options.looks);
        findKnown(lines, options.mostStretch);
    }

    std::span<const glm::dvec3> candidates() const { return candidates_; }
    std::int64_t rays() const { return rays_; }

    /// The candidates nearest to one, itself the first.
    std::span<const std::size_t> about(std::size_t candidate) const { return about_[candidate]; }

    /// Of all looks that end on a surface, those whose end no image knows that is drawn there.
    double unknownShare(std::span<const std::size_t> chosen) const {
        std::vector<glm::dvec3> positions;
        for (const std::size_t candidate : chosen)
            positions.push_back(candidates_[candidate]);
        const WalkCells cells(positions);
        std::uint32_t cell = 0;
        std::int64_t known = 0;
        for (std::size_t walker = 0; walker < walkers_.size(); ++walker) {
            const std::vector<std::uint32_t> drawn = cells.cornersAt(walkers_[walker], cell);
            for (std::size_t word = 0; word < words_; ++word) {
                Word bits = 0;
                for (const std::uint32_t position : drawn)
                    bits |= known_[placeOf(chosen[position], walker) + word];
                known += std::popcount(bits);
            }
        }
        return lookCount_ > 0 ? 1 - static_cast<double>(known) / static_cast<double>(lookCount_) : 0;
    }

  private:
    void findAbout(std::size_t count) {
        about_.resize(candidates_.size());
        std::vector<std::size_t> all(candidates_.size());
        std::iota(all.begin(), all.end(), std::size_t{0});
        tbb::parallel_for(std::size_t{0}, candidates_.size(), [&](std::size_t i) {
            const auto away = [&](std::size_t other) {
                const glm::dvec3 way = candidates_[other] - candidates_[i];
                return std::pair(glm::dot(way, way), other);
            };
            about_[i].resize(std::min(count, all.size()));
            std::partial_sort_copy(all.begin(), all.end(), about_[i].begin(), about_[i].end(),
                                   [&](std::size_t a, std::size_t b) { return away(a) < away(b); });
        });
    }

    void findLooks(const SightLines& lines, int looks) {
        const std::vector<glm::dvec3> directions = spreadDirections(looks);
        looks_.resize(walkers_.size());
        tbb::parallel_for(std::size_t{0}, walkers_.size(), [&](std::size_t walker) {
            for (const glm::dvec3& direction : directions)
                if (const std::optional<SightEnd> end = lines.cast(walkers_[walker], direction))
                    looks_[walker].push_back({*end, spreadOf(*end, walkers_[walker])});
        });
        for (const std::vector<Look>& own : looks_)
            lookCount_ += std::ssize(own);
        rays_ += std::ssize(walkers_) * looks;
    }

    void findKnown(const SightLines& lines, double mostStretch) {
        known_.resize(candidates_.size() * walkers_.size() * words_);
        tbb::parallel_for(std::size_t{0}, candidates_.size(), [&](std::size_t candidate) {
            const glm::dvec3& from = candidates_[candidate];
            for (std::size_t walker = 0; walker < walkers_.size(); ++walker)
                for (std::size_t i = 0; i < looks_[walker].size(); ++i) {
                    const Look& look = looks_[walker][i];
                    const bool isDense = spreadOf(look.end, from) <= mostStretch * mostStretch * look.spread;
                    if (isDense && isSameSide(look.end, from, walkers_[walker]) &&
                        !lines.isBlocked(from, look.end.position))
                        known_[placeOf(candidate, walker) + i / kWordBits] |= Word{1} << (i % kWordBits);
                }
        });
        rays_ += std::ssize(candidates_) * lookCount_;
    }

    std::size_t placeOf(std::size_t candidate, std::size_t walker) const {
        return (candidate * walkers_.size() + walker) * words_;
    }

    std::vector<glm::dvec3> candidates_, walkers_;
    std::size_t words_; ///< of a walker
    std::vector<std::vector<std::size_t>> about_;
    std::vector<std::vector<Look>> looks_;
    std::int64_t lookCount_ = 0, rays_ = 0;
    std::vector<Word> known_;
};

class Choice {
  public:
    explicit Choice(const Sight& sight) : sight_(&sight) {}

    /// Adds the candidate that makes most known.
    void add() {
        std::vector<std::size_t> all(sight_->candidates().size());
        std::iota(all.begin(), all.end(), std::size_t{0});
        chosen_.push_back(all.front());
        share_ = std::numeric_limits<double>::infinity();
        improve(chosen_.size() - 1, all);
    }

    /// Once through all that were chosen, the oldest first; whether any was exchanged.
    bool exchange() {
        bool isBetter = false;
        for (std::size_t i = 0; i < chosen_.size(); ++i)
            isBetter |= improve(i, sight_->about(chosen_[i]));
        return isBetter;
    }

    std::span<const std::size_t> chosen() const { return chosen_; }
    double share() const { return share_; }
    std::int64_t trials() const { return trials_; }

  private:
    /// Puts the best of some candidates into the place of one that was chosen, if that is better.
    bool improve(std::size_t at, std::span<const std::size_t> candidates) {
        std::vector<double> shares(candidates.size(), std::numeric_limits<double>::infinity());
        tbb::parallel_for(std::size_t{0}, candidates.size(), [&](std::size_t i) {
            std::vector<std::size_t> tried = chosen_;
            tried[at] = candidates[i];
            if (std::count(tried.begin(), tried.end(), candidates[i]) > 1) return;
            shares[i] = sight_->unknownShare(tried);
        });
        trials_ += std::ssize(candidates);
        const auto best = std::min_element(shares.begin(), shares.end());
        if (!(*best < share_)) return false;
        chosen_[at] = candidates[static_cast<std::size_t>(best - shares.begin())];
        share_ = *best;
        return true;
    }

    const Sight* sight_;
    std::vector<std::size_t> chosen_;
    double share_ = 1;
    std::int64_t trials_ = 0;
};

} // namespace

SightSearchResult searchBySight(std::span<const glm::dvec3> places, const SightLines& lines,
                                const SightSearchOptions& options, const std::function<void()>& told) {
    assert(options.count > 0 && places.size() >= static_cast<std::size_t>(options.count));
    const Sight sight(places, lines, options);
    Choice choice(sight);
    SightSearchResult result;
    while (std::ssize(choice.chosen()) < std::min<std::ptrdiff_t>(options.count, std::ssize(sight.candidates()))) {
        Choice next = choice;
        next.add();
        next.exchange();
        if (!result.unknownShares.empty() && choice.share() - next.share() < options.leastGain) break;
        choice = std::move(next);
        result.unknownShares.push_back(choice.share());
        if (told) told();
    }
    for (int round = 1; round < options.exchangeRounds && choice.exchange(); ++round) {
    }
    for (const std::size_t candidate : choice.chosen())
        result.positions.push_back(sight.candidates()[candidate]);
    result.unknownShare = choice.share();
    result.rays = sight.rays();
    result.trials = choice.trials();
    return result;
}

} // namespace scene
