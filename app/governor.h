#pragma once
// The governor holds a rate, for 99 frames in a hundred: when frames take too long it gives up quality rung by rung,
// and takes it back when there is room. It knows nothing of clocks and devices: numbers of frames and milliseconds go
// in, rungs come out.

#include "render/quality.h"

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace app {

struct Rung {
    std::string name; ///< what has been given up, in a few words
    render::Quality quality;
    double cost = 1; ///< of a frame, as a share of the first rung's: a guess, to know how far to fall
};

/// What may be given up of `base`, which is the first rung, each rung cheaper than the one before: first what costs the
/// least quality for the time it saves (docs/performance.md has the figures). The last rung is the floor.
std::vector<Rung> ladderOf(const render::Quality& base);

struct GovernorOptions {
    double budgetMilliseconds = 1000.0 / 90;
    double fullShare = 0.9;   ///< of the budget: frames that take longer are late; what is left is for what varies
    double roomShare = 0.75;  ///< of the budget: what the next better rung may be expected to take
    int window = 5, late = 3; ///< it falls when so many of the last `window` frames were late
    /// It also falls when more than this share of the last `rareWindow` frames, and more than two, were late, however
    /// far apart, and climbs only where no larger share would have been.
    double rareShare = 0.01;
    int rareWindow = 300;
    double stall = 2;  ///< what takes more than this times the budget is not the picture's doing: no rung mends it
    int hurry = 15;    ///< falling again within so many frames of a fall goes twice as far as before
    int memory = 1800; ///< frames until most of what a rung turned out to cost is forgotten
    int patience = 30; ///< frames of one rung before it climbs
    int trial = 300;   ///< falling back within so many frames of a climb doubles the patience ...
    int mostPatience = 1920; ///< ... up to this
};

class Governor {
  public:
    /// costs: of each rung (Rung::cost), the first one's first; at least one.
    Governor(std::vector<double> costs, const GovernorOptions& options);

    /// The rung to draw frame number `frame` on. Numbers grow by one from call to call; a smaller one is a new count,
    /// for which what was told before does not hold.
    int rungFor(std::uint64_t frame);

    /// What frame number `frame` took of processor and device, waiting left out. Known late: several frames may have
    /// been begun since.
    void tell(std::uint64_t frame, double milliseconds);

    struct Change {
        std::uint64_t frame = 0; ///< the first on the new rung, counted over all that were asked for
        int from = 0, to = 0;
        double milliseconds = 0; ///< of the frames that led to it
    };
    std::span<const Change> changes() const { return changes_; }
    /// Frames drawn on each rung.
    std::span<const std::uint64_t> frames() const { return frames_; }
    /// Of the frames that were told, those that took more than the budget.
    std::uint64_t overBudget() const { return overBudget_; }
    int rung() const { return rung_; }

  private:
    /// The rung that is called for, if not this one, and why.
    struct Wish {
        int rung = 0;
        double milliseconds = 0;
        bool isForTheRare = false;
    };
    std::optional<Wish> wish() const;
    std::optional<Wish> wishToFall() const;
    std::optional<Wish> wishToFallForTheRare() const;
    std::optional<Wish> wishToClimb() const;
    double full() const { return options_.fullShare * options_.budgetMilliseconds; }
    double costBeside(int rung) const;
    bool isSeldomLate(double cost, double forgiven) const;
    void change(Wish wish, std::uint64_t frame);
    void learnFrom(double milliseconds);

    std::vector<double> guesses_, costs_; ///< costs_: as they turned out where a climb failed
    GovernorOptions options_;
    int rung_ = 0;
    std::optional<std::uint64_t> last_; ///< asked for
    std::uint64_t first_ = 0;           ///< asked for on this rung
    std::uint64_t asked_ = 0;           ///< over all counts
    std::deque<double> told_;           ///< of frames on this rung, the newest last
    std::uint64_t framesOnRung_ = 0;
    int patience_;
    bool climbed_ = false;        ///< the last change was upwards
    int depth_ = 1;               ///< rungs that the last fall went at least
    double failedAt_ = 0;         ///< milliseconds on this rung before the climb that failed; 0: none has
    double climbedFrom_ = 0;      ///< milliseconds before the last climb
    std::vector<Change> changes_; ///< the first kMostChanges
    std::vector<std::uint64_t> frames_;
    std::uint64_t overBudget_ = 0;
};

/// How many changes are kept, however long a walk is.
inline constexpr std::size_t kMostChanges = 4096;

/// For report.json.
nlohmann::json toJson(const Governor& governor, std::span<const Rung> ladder, double framesPerSecond);

} // namespace app
