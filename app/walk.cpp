#include "app/walk.h"

#include "app/view_files.h"

#include "scene/errors.h"
#include "xr/check.h"
#include "xr/window.h"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <thread>

namespace app {

namespace {

using nlohmann::json;

volatile std::sig_atomic_t wasAskedToEnd = 0;

/// How often a headset that is not there is looked for: OpenXR has no event for a runtime that appears.
constexpr std::chrono::milliseconds kLookAgain{500};

/// The head's pose along a path file, at the keys' times.
xr::Headless::Path pathOf(const WalkOptions& options, const scene::Scene& scene) {
    const scene::Camera anyCamera{1, 1, 1, 1, 0.5, 0.5};
    std::vector<NamedView> keys = readPathFile(options.path, scene.walkFromWorld, anyCamera);
    const scene::Pose cameraFromHead{glm::dmat3(1, 0, 0, 0, -1, 0, 0, 0, -1), glm::dvec3(0)};
    return [keys = std::move(keys), walkFromWorld = scene.walkFromWorld,
            cameraFromHead](double seconds) -> std::optional<scene::Pose> {
        if (seconds > keys.back().seconds) return std::nullopt;
        const auto next = std::upper_bound(keys.begin(), keys.end(), seconds + 1e-9,
                                           [](double t, const NamedView& key) { return t < key.seconds; });
        const NamedView& key = next == keys.begin() ? keys.front() : *std::prev(next);
        return walkFromWorld * key.worldFromCamera * cameraFromHead;
    };
}

} // namespace

Knobs Walk::knobsOf(const WalkOptions& options) {
    Knobs knobs;
    knobs.quality = qualityOf(options.draw);
    return knobs;
}

void Walk::askToEnd() {
    wasAskedToEnd = 1;
}

void Walk::forgetAskedToEnd() {
    wasAskedToEnd = 0;
}

bool Walk::isAskedToEnd() const {
    return wasAskedToEnd != 0 || (options_.frames > 0 && frame_ >= static_cast<std::size_t>(options_.frames));
}

Walk::Walk(const scene::Scene& scene, const WalkOptions& options, DeskSide* deskSide)
    : scene_(scene), options_(options), deskSide_(deskSide), knobs_(knobsOf(options)),
      worldFromWalk_(inverse(scene.walkFromWorld)), record_(options) {
    if (!options.path.empty()) path_ = pathOf(options, scene);
}

void Walk::say(const std::string& notice) {
    std::fprintf(stderr, "%s\n", notice.c_str());
    facts_.notice = notice;
}

WalkStage Walk::firstStage() {
    if (options_.isHeadless) return WalkStage::headless(scene_, path_, options_);
    if (options_.isAtDesk) return WalkStage::atDesk(scene_, deskSide_->desktop);
    try {
        return WalkStage::inHeadset(scene_, std::make_unique<xr::Runtime>());
    } catch (const std::exception& e) {
        if (deskSide_ == nullptr) throw;
        say("no headset yet: " + std::string(e.what()));
        return WalkStage::atDesk(scene_, deskSide_->desktop);
    }
}

void Walk::run() {
    std::optional<WalkStage> stage(firstStage());
    while (true) {
        say("walking: " + stage->name() + ", on " + stage->device().name());
        facts_.display = stage->name() + ", drawn on " + stage->device().name();
        const Outcome outcome = walkOn(*stage);
        lastReport_ = reportOf(*stage);
        if (!change(outcome, stage)) break;
    }
    record_.write(lastReport_);
}

bool Walk::change(Outcome outcome, std::optional<WalkStage>& stage) {
    if (outcome == Outcome::over) return false;
    const bool isAlone = deskSide_ == nullptr;
    if (outcome == Outcome::headsetGone) {
        say(isAlone ? "the headset is gone; looking for it (Ctrl-C ends the walk)"
                    : "the headset is gone; walking on at the desk until it is back");
        stage.reset();
        if (isAlone) return waitForHeadset(stage);
        stage.emplace(WalkStage::atDesk(scene_, deskSide_->desktop));
        return true;
    }
    stage.reset();
    try {
        stage.emplace(WalkStage::inHeadset(scene_, std::move(found_)));
        firstHead_.reset();
    } catch (const std::exception&) {
        // It went away again at once.
        stage.emplace(WalkStage::atDesk(scene_, deskSide_->desktop));
    }
    return true;
}

bool Walk::waitForHeadset(std::optional<WalkStage>& stage) {
    while (!isAskedToEnd()) {
        try {
            stage.emplace(WalkStage::inHeadset(scene_, std::make_unique<xr::Runtime>()));
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
        if (now - soughtAt_ < kLookAgain) return false;
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

void Walk::drawFrame(WalkStage& stage, xr::ViewSource& source, const xr::Frame& frame) {
    const auto start = std::chrono::steady_clock::now();
    draw(stage, source, frame);
    source.end(frame);
    const std::chrono::duration<double, std::milli> passed = std::chrono::steady_clock::now() - start;
    report_.add({}, stats_, passed.count());
    ++frame_;
}

/// A path leads the walker; in a headset the head moves about it as it likes.
void Walk::lead(const xr::Frame& frame) {
    if (options_.isHeadless || !path_) return;
    const auto led = path_(frame.seconds);
    if (!led) return;
    if (!firstHead_) firstHead_ = frame.trackingFromHead;
    walkFromTracking_ = *led * inverse(*firstHead_);
}

void Walk::draw(WalkStage& stage, xr::ViewSource& source, const xr::Frame& frame) {
    if (deskSide_ != nullptr) knobs_ = deskSide_->desk.knobs();
    lead(frame);
    if (frame.isTracked != wasTracked_)
        say(frame.isTracked ? "the head is tracked again" : "the head is not tracked; its last place is kept");
    wasTracked_ = frame.isTracked;
    record_.addPose(frame.seconds, walkFromTracking_ * frame.trackingFromHead);

    render::Renderer& renderer = stage.rendererFor(source);
    const auto eyes = static_cast<std::size_t>(source.eyes());
    std::array<scene::View, xr::kEyes> views;
    std::array<render::EyeOutput, xr::kEyes> outputs;
    for (std::size_t eye = 0; eye < eyes; ++eye) {
        views[eye] = {frame.eyes[eye].camera, worldFromWalk_ * walkFromTracking_ * frame.eyes[eye].worldFromEye};
        outputs[eye].image = frame.images[eye].image;
        outputs[eye].layer = frame.images[eye].layer;
    }
    const bool isAtDesk = deskSide_ != nullptr && &source == &deskSide_->desktop;
    if (isAtDesk || (deskSide_ != nullptr && deskSide_->desk.wantsPicture())) renderer.keepNext();
    stats_ = renderer.draw(std::span(views).first(eyes), knobs_.quality, std::span(outputs).first(eyes));
    if (deskSide_ != nullptr) mirror(renderer, stage, isAtDesk, frame);

    if (!record_.wantsPicture(static_cast<int>(frame_))) return;
    std::vector<render::EyeImage> pictures = renderer.readBack();
    for (std::size_t eye = 0; eye < eyes; ++eye) {
        // Where there is a headset, what it was given counts and not what we have.
        if (outputs[eye].image != VK_NULL_HANDLE)
            pictures[eye].colour = render::readOutput(stage.device(), outputs[eye], source.width(), source.height());
        record_.addPicture(static_cast<int>(frame_), eye, views[eye], std::move(pictures[eye]));
    }
}

void Walk::mirror(render::Renderer& renderer, const WalkStage& stage, bool isAtDesk, const xr::Frame& frame) {
    // At the desk the picture is for the window and is waited for; in a headset the newest that is finished will do.
    if (isAtDesk) stats_ = renderer.finish();
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - frameAt_).count();
    frameAt_ = now;
    if (seconds < 1) facts_.framesPerSecond += 0.1 * (1 / std::max(seconds, 1e-6) - facts_.framesPerSecond);
    facts_.isAtDesk = isAtDesk;
    facts_.isTracked = frame.isTracked;
    facts_.stats = stats_;
    facts_.place = walkFromTracking_ * frame.trackingFromHead.translation;
    deskSide_->desk.tell(facts_);
    static_cast<void>(stage);
    if (!renderer.takeKept(mirrored_)) return;
    deskSide_->desk.show(mirrored_);
    xr::Window::wake();
}

json Walk::reportOf(const WalkStage& stage) const {
    return report_.summarise(stage.device(), stage.gpuScene(),
                             {{"scene", options_.scene.string()},
                              {"display", stage.name()},
                              {"warp", knobs_.quality.warp == render::Warp::mesh ? "mesh" : "points"},
                              {"eyes", xr::kEyes},
                              {"near_baseline", knobs_.quality.preference.nearBaseline},
                              {"max_footprint", knobs_.quality.maxFootprint}});
}

} // namespace app
