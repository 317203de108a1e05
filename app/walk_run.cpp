// Which stage a walk is on: in the headset while there is one, at the desk meanwhile, on a device made anew when one is
// lost.
#include "app/walk.h"

#include "app/say.h"
#include "scene/errors.h"

#include <thread>
#include <utility>

namespace app {

namespace {

/// How often a headset that is not there is looked for: OpenXR has no event for a runtime that appears.
constexpr std::chrono::milliseconds kLookAgain{500};
/// Beside a walk at the desk: a runtime that cannot be reached may have much to say about it each time.
constexpr std::chrono::milliseconds kLookAgainAtDesk{2000};

} // namespace

WalkStage Walk::firstStage() {
    if (options_.isHeadless) return WalkStage::headless(drawnScene_, path_, options_);
    if (options_.isAtDesk) return WalkStage::atDesk(drawnScene_, deskSide_->desktop);
    try {
        return WalkStage::inHeadset(drawnScene_, std::make_unique<xr::Runtime>());
    } catch (const std::exception& e) {
        if (deskSide_ == nullptr) throw;
        say("no headset yet: " + std::string(e.what()));
        return WalkStage::atDesk(drawnScene_, deskSide_->desktop);
    }
}

void Walk::run() {
    std::optional<WalkStage> stage(firstStage());
    while (true) {
        say("walking: " + stage->name() + ", on " + stage->device().name());
        if (const std::string refusal = stage->askForRate(options_.framesPerSecond); !refusal.empty()) say(refusal);
        sayWhatCannotBeHad(stage->device(), knobs_.quality, stage->source().eyes());
        facts_.display = stage->name() + ", drawn on " + stage->device().name();
        Outcome outcome = Outcome::deviceLost;
        try {
            outcome = walkOn(*stage);
        } catch (const render::DeviceLost& loss) {
            losses_.tell(loss);
        }
        lastReport_ = reportOf(*stage);
        if (!change(outcome, stage)) break;
    }
    record_.write(lastReport_);
    if (const auto remark = report_.remark(); remark && options_.draw.polygons.empty() && scene_.damaged.empty())
        sayNote(*remark);
}

bool Walk::change(Outcome outcome, std::optional<WalkStage>& stage) {
    if (outcome == Outcome::over) return false;
    const bool isAlone = deskSide_ == nullptr;
    if (outcome == Outcome::deviceLost) return beginAnew(stage);
    if (outcome == Outcome::headsetGone) {
        say(isAlone ? "the headset is gone; looking for it (Ctrl-C ends the walk)"
                    : "the headset is gone; walking on at the desk until it is back");
        stage.reset();
        if (isAlone) return waitForHeadset(stage);
        stage.emplace(WalkStage::atDesk(drawnScene_, deskSide_->desktop));
        return true;
    }
    stage.reset();
    try {
        stage.emplace(WalkStage::inHeadset(drawnScene_, std::move(found_)));
    } catch (const std::exception&) {
        // It went away again at once.
        stage.emplace(WalkStage::atDesk(drawnScene_, deskSide_->desktop));
    }
    return true;
}

bool Walk::beginAnew(std::optional<WalkStage>& stage) {
    stage.reset();
    try {
        stage.emplace(WalkStage::inHeadset(drawnScene_, std::make_unique<xr::Runtime>()));
        return true;
    } catch (const std::exception& e) {
        say("no headset: " + std::string(e.what()));
    }
    if (deskSide_ == nullptr) return waitForHeadset(stage);
    stage.emplace(WalkStage::atDesk(drawnScene_, deskSide_->desktop));
    return true;
}

bool Walk::waitForHeadset(std::optional<WalkStage>& stage) {
    while (!isAskedToEnd()) {
        try {
            stage.emplace(WalkStage::inHeadset(drawnScene_, std::make_unique<xr::Runtime>()));
            return true;
        } catch (const std::exception&) {
            std::this_thread::sleep_for(kLookAgain);
        }
    }
    return false;
}

bool Walk::seekHeadset() {
    const auto now = std::chrono::steady_clock::now();
    if (!sought_.valid()) {
        if (now - soughtAt_ < kLookAgainAtDesk) return false;
        soughtAt_ = now;
        sought_ = std::async(std::launch::async, []() -> std::unique_ptr<xr::Runtime> {
            try {
                return std::make_unique<xr::Runtime>();
            } catch (const std::exception&) {
                return nullptr; // none yet
            }
        });
    }
    if (sought_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return false;
    found_ = sought_.get();
    return found_ != nullptr;
}

Walk::Outcome Walk::walkOn(WalkStage& stage) {
    const bool seeks = stage.headset() == nullptr && !options_.isHeadless && !options_.isAtDesk;
    bool hasAskedToEnd = false;
    while (true) {
        const bool isOver = isAskedToEnd();
        if (isOver && !hasAskedToEnd) {
            hasAskedToEnd = true;
            if (!stage.requestEnd()) return Outcome::over;
        }
        if (seeks && seekHeadset()) return Outcome::headsetThere;
        const xr::Frame frame = stage.source().begin();
        if (frame.kind == xr::Frame::Kind::lost) return isOver ? Outcome::over : Outcome::headsetGone;
        if (frame.kind == xr::Frame::Kind::end) return Outcome::over;
        if (frame.kind == xr::Frame::Kind::draw) {
            drawFrame(stage, stage.source(), frame);
        } else if (deskSide_ != nullptr && !stage.headset()->isRunning()) {
            // Nobody wears it: whoever sits at the desk goes on.
            const xr::Frame atDesk = deskSide_->desktop.begin();
            if (atDesk.kind == xr::Frame::Kind::draw) drawFrame(stage, deskSide_->desktop, atDesk);
        }
    }
}

} // namespace app
