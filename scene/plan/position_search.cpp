#include "scene/plan/position_search.h"

#include "scene/plan/walk_cells.h"

#include <algorithm>
#include <cassert>
#include <map>
#include <numeric>
#include <optional>
#include <random>

#include <glm/geometric.hpp>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

using Corners = std::vector<std::uint32_t>; ///< positions whose images are drawn, ascending

double meanUnknownShare(const WalkCells& cells, const UnknownSpace& space, std::span<const glm::dvec3> testPlaces) {
    std::vector<double> shares(testPlaces.size());
    tbb::parallel_for(std::size_t{0}, testPlaces.size(), [&](std::size_t i) {
        std::uint32_t cell = 0;
        shares[i] = space.countAt(testPlaces[i], cells.cornersAt(testPlaces[i], cell)).unknownShare();
    });
    return shares.empty() ? 0 : std::accumulate(shares.begin(), shares.end(), 0.0) / static_cast<double>(shares.size());
}

class Search {
  public:
    Search(std::span<const glm::dvec3> places, const CaptureSmall& capture, const PositionSearchOptions& options)
        : places_(places), capture_(capture), options_(options), space_(options.unknown), random_(options.seed),
          values_(places.size()) {}

    void insert(std::size_t place) {
        positions_.push_back(places_[place]);
        isTaken_.resize(places_.size(), false);
        isTaken_[place] = true;
        space_.add(capture_(places_[place]));
        cells_ = WalkCells(positions_);
        divide();
    }

    /// The best of the best of all cells; nothing if no place is left, or none is worth it.
    std::optional<std::size_t> next() {
        evaluations_ = 0;
        const bool mayPassOver = options_.search == CellSearch::remembering;
        std::vector<const Cell*> order;
        for (const Cell& cell : members_)
            order.push_back(&cell);
        std::stable_sort(order.begin(), order.end(),
                         [](const Cell* a, const Cell* b) { return a->second.size() > b->second.size(); });
        std::optional<std::size_t> best;
        double most = 0;
        for (const Cell* cell : order) {
            const auto& [corners, members] = *cell;
            const auto room = static_cast<double>(members.size());
            // What all of a cell's view unknown would be worth bounds it: most cells need not be looked into. The
            // article looks into all that are new.
            if (mayPassOver && best && room * mostOf(members) <= most) continue;
            std::optional<std::size_t>& found = bestOf_[corners];
            if (!found || cornersOf_[*found] != corners || isTaken_[*found]) found = breed(members);
            if (!found) continue;
            const double worth = room * valueOf(*found);
            if (worth > most) most = worth, best = found;
        }
        if (best && most / static_cast<double>(places_.size()) < options_.leastGain) return std::nullopt;
        return best;
    }

    std::int64_t evaluations() const { return evaluations_; }
    const WalkCells& cells() const { return cells_; }
    const UnknownSpace& space() const { return space_; }

  private:
    using Cell = std::pair<const Corners, std::vector<std::size_t>>; ///< and the places in it
    struct Value {
        Corners corners; ///< it was worked out with
        double objective = 0;
    };

    /// Which places count to which cell. What is known of a place holds for as long as its corners are the same.
    void divide() {
        members_.clear();
        cornersOf_.resize(places_.size());
        std::uint32_t cell = 0;
        for (std::size_t i = 0; i < places_.size(); ++i) {
            cornersOf_[i] = cells_.cornersAt(places_[i], cell);
            members_[cornersOf_[i]].push_back(i);
        }
        std::erase_if(bestOf_, [&](const auto& best) { return !members_.contains(best.first); });
    }

    bool isKnown(std::size_t place) const { return values_[place] && values_[place]->corners == cornersOf_[place]; }

    /// No place of them can be worth more than this.
    double mostOf(const std::vector<std::size_t>& members) const {
        double most = 0;
        for (const std::size_t place : members) {
            if (!isKnown(place)) return 1;
            most = std::max(most, values_[place]->objective);
        }
        return most;
    }

    double valueOf(std::size_t place) {
        if (!isKnown(place)) {
            values_[place] = Value{cornersOf_[place], space_.countAt(places_[place], cornersOf_[place]).objective()};
            ++evaluations_;
        }
        return isTaken_[place] ? -1 : values_[place]->objective;
    }

    /// Section 6 of the article: each iteration makes two children, drawn by their parents' worth, and drops the two
    /// worst. A child stands between its parents, at the place nearest to a random point of their line.
    std::optional<std::size_t> breed(const std::vector<std::size_t>& members) {
        std::vector<std::size_t> individuals;
        std::uniform_int_distribution<std::size_t> any(0, members.size() - 1);
        std::uniform_real_distribution<double> unit(0, 1);
        for (int i = 0; i < options_.geneticIndividuals; ++i)
            individuals.push_back(members[any(random_)]);
        const auto pick = [&] {
            std::vector<double> weights;
            for (const std::size_t place : individuals)
                weights.push_back(std::max(valueOf(place), 0.0) + 1e-6);
            return individuals[std::discrete_distribution<std::size_t>(weights.begin(), weights.end())(random_)];
        };
        for (int i = 0; i < options_.geneticIterations; ++i) {
            for (int child = 0; child < 2; ++child) {
                const glm::dvec3 &a = places_[pick()], &b = places_[pick()];
                // Somewhat beyond them, too: else no child would ever leave its parents' hull.
                const glm::dvec3 wanted = a + (2 * unit(random_) - 0.5) * (b - a);
                individuals.push_back(
                    *std::min_element(members.begin(), members.end(), [&](std::size_t p, std::size_t q) {
                        return glm::length(places_[p] - wanted) < glm::length(places_[q] - wanted);
                    }));
            }
            // The article draws each child's pictures, whether its place was tried before or not.
            const std::int64_t before = evaluations_;
            std::stable_sort(individuals.begin(), individuals.end(),
                             [&](std::size_t p, std::size_t q) { return valueOf(p) > valueOf(q); });
            if (options_.search == CellSearch::genetic) evaluations_ = before + 2;
            individuals.resize(static_cast<std::size_t>(options_.geneticIndividuals));
        }
        if (isTaken_[individuals.front()]) return std::nullopt;
        return individuals.front();
    }

    std::span<const glm::dvec3> places_;
    const CaptureSmall& capture_;
    const PositionSearchOptions& options_;
    UnknownSpace space_;
    std::mt19937 random_;
    std::vector<glm::dvec3> positions_;
    std::vector<bool> isTaken_;
    WalkCells cells_;
    std::vector<Corners> cornersOf_; ///< of each place
    std::map<Corners, std::vector<std::size_t>> members_;
    std::map<Corners, std::optional<std::size_t>>
        bestOf_; ///< the best place of each cell, for as long as there is the cell
    std::vector<std::optional<Value>> values_;
    std::int64_t evaluations_ = 0;
};

} // namespace

std::vector<PositionSearchStep> searchPositions(std::span<const glm::dvec3> places,
                                                std::span<const glm::dvec3> testPlaces, const CaptureSmall& capture,
                                                const PositionSearchOptions& options,
                                                const std::function<void(const PositionSearchStep&)>& told) {
    assert(options.count > 0 && places.size() >= static_cast<std::size_t>(options.count));
    Search search(places, capture, options);
    std::vector<PositionSearchStep> steps;
    std::optional<std::size_t> place = 0;
    while (place && std::ssize(steps) < options.count) {
        const std::int64_t evaluations = search.evaluations();
        search.insert(*place);
        steps.push_back({places[*place], evaluations, meanUnknownShare(search.cells(), search.space(), testPlaces)});
        if (told) told(steps.back());
        if (std::ssize(steps) < options.count) place = search.next();
    }
    return steps;
}

double unknownShareOf(std::span<const glm::dvec3> positions, std::span<const glm::dvec3> testPlaces,
                      const CaptureSmall& capture, const UnknownSpaceOptions& options) {
    UnknownSpace space(options);
    for (const glm::dvec3& position : positions)
        space.add(capture(position));
    return meanUnknownShare(WalkCells(positions), space, testPlaces);
}

} // namespace scene
