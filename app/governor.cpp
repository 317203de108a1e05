#include "app/governor.h"

#include "app/quality_file.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdio>

namespace app {

namespace {

/// A way of making surfaces (a name of the knob warp), what a frame of it takes beside one of the mesh, and the share
/// of that which does not go with the number of pixels: samples are read whatever they become.
struct Way {
    const char* name;
    bool (*is)(const render::Quality&);
    double cost, fixedShare;
    bool isStep;   ///< others may fall to it
    bool isScaled; ///< less of its resolution is better than falling to the next
};

/// From the best to the fastest, with what docs/performance.md measured. Fewer pixels save a seventh of what is
/// blended, the mesh a third to three fifths, for as little. What is blended takes 1.4 to 3.8 times the mesh, by how
/// many photographs there are of a place: between them. The adaptive mesh is not faster than the mesh everywhere.
constexpr std::array kWays{
    Way{"blended", [](const render::Quality& q) { return q.isBlended; }, 2.3, 0.7, false, false},
    // Whatever is no slower than the mesh may be asked for in its place. By confidence it takes as long and is better.
    Way{"confidence",
        [](const render::Quality& q) {
            return !q.isBlended && q.warp != render::Warp::points && q.warp != render::Warp::adaptive;
        },
        1, 0.6, true, true},
    Way{"adaptive", [](const render::Quality& q) { return !q.isBlended && q.warp == render::Warp::adaptive; }, 0.75,
        0.6, false, true},
    Way{"points", [](const render::Quality& q) { return !q.isBlended && q.warp == render::Warp::points; }, 0.6, 0.5,
        true, true}};

/// A little resolution goes first, then the way surfaces are made, then resolution down to where it is still a picture.
constexpr std::array kGentleScales{0.85, 0.7};
/// Samples as dense as the pixels that were asked for are still too wide to be merged at half the resolution; let a
/// little wider, two fifths of them are drawn, and hardly worse. Elsewhere on the way down it costs more than it saves.
struct Step {
    double scale, coarser; ///< coarser: times samplePixels
};
constexpr std::array kHardSteps{Step{0.6, 1}, Step{0.5, 1}, Step{0.5, 1.25}, Step{0.35, 1}};
/// Of the share that does not go with the number of pixels.
constexpr double kCostOfCoarser = 0.9;

std::string nameOf(const Step& step) {
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "resolution x %.2g%s", step.scale, step.coarser > 1 ? ", coarser" : "");
    return text.data();
}

/// Late frames that do not make it fall: by chance there are one or two.
constexpr double kForgiven = 2;

/// So many times what was guessed a rung may turn out to cost.
constexpr double kMostWrong = 3;

} // namespace

std::vector<Rung> ladderOf(const render::Quality& base) {
    const auto asked = std::find_if(kWays.begin(), kWays.end(), [&](const Way& way) { return way.is(base); });
    std::vector<Rung> ladder;
    const auto add = [&](const Way& way, const Step& step) {
        const double scale = step.scale, fixed = way.fixedShare * (step.coarser > 1 ? kCostOfCoarser : 1);
        Rung rung{nameOf(step), base, way.cost / asked->cost * (fixed + (1 - way.fixedShare) * scale * scale)};
        rung.quality.resolutionScale = base.resolutionScale * scale;
        rung.quality.samplePixels = std::min(base.samplePixels * step.coarser, kMostSamplePixels);
        if (way.name != asked->name) {
            turnKnob(rung.quality, "warp", way.name, "governor");
            rung.name = scale < 1 ? std::string(way.name) + ", " + rung.name : way.name;
        }
        if (ladder.empty()) rung.name = "as asked";
        // What is asked for may be near the floor already, and all samples may be asked for.
        const bool isOther = step.coarser == 1 || rung.quality.samplePixels > base.samplePixels;
        const bool isCheaper = ladder.empty() || (isOther && rung.cost < ladder.back().cost);
        if (isCheaper && (scale >= 1 || rung.quality.resolutionScale >= render::kMinResolutionScale))
            ladder.push_back(std::move(rung));
    };
    add(*asked, {1, 1});
    bool wasScaled = true;
    for (auto way = asked; way != kWays.end(); ++way) {
        if (way != asked && !way->isStep) continue;
        if (!wasScaled) add(*way, {1, 1});
        wasScaled = way->isScaled;
        if (!way->isScaled) continue;
        for (const double scale : kGentleScales)
            add(*way, {scale, 1});
    }
    for (const Step& step : kHardSteps)
        add(kWays.back(), step);
    return ladder;
}

Governor::Governor(std::vector<double> costs, const GovernorOptions& options)
    : guesses_(std::move(costs)), costs_(guesses_), options_(options), patience_(options.patience),
      frames_(costs_.size()) {
    assert(!costs_.empty() && options.late <= options.window && options.budgetMilliseconds > 0);
}

int Governor::rungFor(std::uint64_t frame) {
    if (last_ && frame <= *last_) {
        told_.clear();
        first_ = frame;
        framesOnRung_ = 0;
    }
    last_ = frame;
    for (std::size_t i = 0; i < costs_.size(); ++i)
        costs_[i] += (guesses_[i] - costs_[i]) / options_.memory;
    if (const std::optional<Wish> wished = wish()) change(*wished, frame);
    ++framesOnRung_, ++asked_;
    ++frames_[static_cast<std::size_t>(rung_)];
    return rung_;
}

void Governor::tell(std::uint64_t frame, double milliseconds) {
    if (!last_ || frame > *last_ || !(milliseconds >= 0)) return; // no clock that ran backwards
    if (milliseconds > options_.budgetMilliseconds) ++overBudget_;
    if (frame < first_) return; // nothing of before the change
    told_.push_back(milliseconds);
    if (told_.size() > static_cast<std::size_t>(std::max(options_.window, options_.rareWindow))) told_.pop_front();
}

/// Of a frame on another rung, as a share of this one's.
double Governor::costBeside(int rung) const {
    return costs_[static_cast<std::size_t>(rung)] / costs_[static_cast<std::size_t>(rung_)];
}

std::optional<Governor::Wish> Governor::wish() const {
    if (const std::optional<Wish> fall = wishToFall()) return fall;
    if (const std::optional<Wish> fall = wishToFallForTheRare()) return fall;
    return wishToClimb();
}

std::optional<Governor::Wish> Governor::wishToFall() const {
    const int floor = static_cast<int>(costs_.size()) - 1;
    const auto newest =
        told_.end() - static_cast<std::ptrdiff_t>(std::min(static_cast<std::size_t>(options_.window), told_.size()));
    const auto late = std::count_if(newest, told_.end(), [&](double ms) { return ms > full(); });
    if (late < options_.late || rung_ == floor) return std::nullopt;
    // The late ones say how far: those before may be of an easier place.
    std::vector<double> values(newest, told_.end());
    std::sort(values.begin(), values.end());
    const double load = values[values.size() - static_cast<std::size_t>(late) / 2 - 1];
    int rung = rung_ + 1;
    while (rung < floor && load * costBeside(rung) > full())
        ++rung;
    return Wish{rung, load};
}

/// Whether no more of the frames on this rung would have been late, had each cost so much of what it took, than are
/// forgiven.
bool Governor::isSeldomLate(double cost, double forgiven) const {
    const double stall = options_.stall * options_.budgetMilliseconds;
    const auto late =
        std::count_if(told_.begin(), told_.end(), [&](double ms) { return ms <= stall && ms * cost > full(); });
    return static_cast<double>(late) <= std::max(forgiven, options_.rareShare * static_cast<double>(told_.size()));
}

std::optional<Governor::Wish> Governor::wishToFallForTheRare() const {
    const int floor = static_cast<int>(costs_.size()) - 1;
    if (rung_ == floor || isSeldomLate(1, kForgiven)) return std::nullopt;
    int rung = rung_ + 1;
    while (rung < floor && !isSeldomLate(costBeside(rung), kForgiven))
        ++rung;
    return Wish{rung, *std::max_element(told_.begin(), told_.end()), true};
}

std::optional<Governor::Wish> Governor::wishToClimb() const {
    const auto patience = static_cast<std::size_t>(options_.patience);
    if (rung_ == 0 || told_.size() < patience) return std::nullopt;
    std::vector<double> values(told_.end() - options_.patience, told_.end());
    const auto middle = values.begin() + options_.patience / 2;
    std::nth_element(values.begin(), middle, values.end());
    const double load = *middle;
    // What made the last climb fail is gone: no reason to be patient any longer.
    const bool isEased = failedAt_ > 0 && load < 0.7 * failedAt_;
    if (framesOnRung_ < static_cast<std::uint64_t>(isEased ? options_.patience : patience_)) return std::nullopt;
    const double cost = costBeside(rung_ - 1);
    if (load * cost < options_.roomShare * options_.budgetMilliseconds && isSeldomLate(cost, 0))
        return Wish{rung_ - 1, load};
    return std::nullopt;
}

/// A climb has failed. That the machine was slower meanwhile, or the place heavier, cannot be told from it; it is
/// forgotten in time.
void Governor::learnFrom(double milliseconds) {
    if (!(climbedFrom_ > 0)) return;
    double& cost = costs_[static_cast<std::size_t>(rung_)];
    const double below = costs_[static_cast<std::size_t>(rung_) + 1];
    cost = std::clamp(below * milliseconds / climbedFrom_, cost, kMostWrong * cost);
}

void Governor::change(Wish wish, std::uint64_t frame) {
    const bool climbs = wish.rung < rung_;
    const double load = wish.milliseconds;
    if (!climbs && climbed_ && framesOnRung_ <= static_cast<std::uint64_t>(options_.trial)) {
        patience_ = std::min(2 * patience_, options_.mostPatience);
        failedAt_ = climbedFrom_;
        if (!wish.isForTheRare) learnFrom(load);
    }
    if (!climbs) {
        const bool isHurried =
            !climbed_ && !changes_.empty() && framesOnRung_ <= static_cast<std::uint64_t>(options_.hurry);
        depth_ = isHurried ? 2 * depth_ : 1;
        wish.rung = std::min(std::max(wish.rung, rung_ + depth_), static_cast<int>(costs_.size()) - 1);
    }
    if (climbs && failedAt_ > 0 && load < 0.7 * failedAt_) patience_ = options_.patience, failedAt_ = 0;
    climbedFrom_ = load;
    climbed_ = climbs;
    if (changes_.size() < kMostChanges) changes_.push_back({asked_, rung_, wish.rung, load});
    rung_ = wish.rung;
    first_ = frame;
    framesOnRung_ = 0;
    told_.clear();
}

nlohmann::json toJson(const Governor& governor, std::span<const Rung> ladder, double framesPerSecond) {
    nlohmann::json changes = nlohmann::json::array(), rungs = nlohmann::json::array();
    const auto nameOf = [&](int rung) { return ladder[static_cast<std::size_t>(rung)].name; };
    for (const Governor::Change& change : governor.changes())
        changes.push_back({{"frame", change.frame},
                           {"from", nameOf(change.from)},
                           {"to", nameOf(change.to)},
                           {"load_ms", change.milliseconds}});
    for (std::size_t i = 0; i < ladder.size(); ++i)
        rungs.push_back(
            {{"name", ladder[i].name}, {"quality", toJson(ladder[i].quality)}, {"frames", governor.frames()[i]}});
    return {{"rate_hz", framesPerSecond},
            {"frames_over_budget", governor.overBudget()},
            {"rungs", rungs},
            {"changes", changes}};
}

} // namespace app
