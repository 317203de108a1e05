#pragma once
// One person's walk: frame by frame from the source of views through the walker's wishes to the pictures. It goes on at
// the desk when the headset goes away, and in the headset when that comes back.

#include "app/annotate.h"
#include "app/damage_teller.h"
#include "app/desk.h"
#include "app/device_trouble.h"
#include "app/drawn_scene.h"
#include "app/governed_quality.h"
#include "app/model_aim.h"
#include "app/selection.h"
#include "app/walk_record.h"
#include "app/walk_stage.h"

#include "input/locomotion.h"

#include <future>
#include <optional>

namespace app {

/// The window's side of a walk, where there is a window.
struct DeskSide {
    Desk& desk;
    xr::Desktop& desktop;
};

class Walk {
  public:
    /// All must outlive it. deskSide may be null.
    Walk(const scene::Scene& scene, const WalkOptions& options, DeskSide* deskSide);

    /// Until the end; in any thread. Throws scene::Failure.
    void run();

    static Knobs knobsOf(const WalkOptions& options);

    /// Asks a walk to end as the walker would; safe in a signal handler. Holds for the next ones, too.
    static void askToEnd();
    static void forgetAskedToEnd();

  private:
    enum class Outcome { over, headsetGone, headsetThere, deviceLost };
    WalkStage firstStage();
    Outcome walkOn(WalkStage& stage);
    /// In a headset; if there is none, at the desk, or when one comes. False if asked to end.
    bool beginAnew(std::optional<WalkStage>& stage);
    /// The next stage after that outcome; none if it is over.
    bool change(Outcome outcome, std::optional<WalkStage>& stage);
    /// Waits for a headset where there is no desk to walk at meanwhile; false if asked to end.
    bool waitForHeadset(std::optional<WalkStage>& stage);
    bool isAskedToEnd() const;

    void drawFrame(WalkStage& stage, xr::ViewSource& source, const xr::Frame& frame);
    /// Where the walker goes until this frame; once a frame.
    void advance(WalkStage& stage, const xr::ViewSource& source, const xr::Frame& frame);
    /// What the walker sees there; again, if the device failed in it.
    void draw(WalkStage& stage, xr::ViewSource& source, const xr::Frame& frame);
    /// Until it is drawn: on a device made anew if it is lost, with less if it is full. Throws render::DeviceLost where
    /// a headset hangs on the device.
    void drawSomehow(WalkStage& stage, xr::ViewSource& source, const xr::Frame& frame);
    void warmUp(render::Renderer& renderer, std::span<const scene::View> eyes);
    void mirror(render::Renderer& renderer, bool isAtDesk, const xr::Frame& frame);
    /// One clock for the walk, whoever counts its frames.
    void tellTime(const xr::ViewSource& source, const xr::Frame& frame);
    /// Moves the walker: as the path leads, or as controllers, keys and mouse say.
    void go(WalkStage& stage, const xr::ViewSource& source, const xr::Frame& frame);
    /// What the hands hold, when that changes; and once that they hold nothing.
    void sayControllers(const input::Actions& actions);
    /// Home is where walks through this scene begin.
    void setHome();
    /// From now on walks through this scene begin where the walker stands.
    void startHere();
    /// What of space is shown as unseen; null if nothing is.
    const scene::Coverage* findShownUnseen(const WalkStage& stage);
    /// What rays may meet: what the walker is shown.
    scene::PickOptions pickOptions() const;
    /// Where a ray of walk space meets something really seen.
    std::optional<input::Surface> hit(const glm::dvec3& from, const glm::dvec3& direction) const;
    /// What the walker is shown over the scene in this frame.
    void fillOverlay(const xr::ViewSource& source);
    void note(const input::Wants& wants, bool isAtDesk);
    input::Wants hearWants(WalkStage& stage, const xr::ViewSource& source, const xr::Frame& frame);
    bool isDesk(const xr::ViewSource& source) const { return deskSide_ != nullptr && &source == &deskSide_->desktop; }
    /// Looks for a headset in another thread, now and then. True once there is one; found_ is its runtime.
    bool seekHeadset();
    void findModels();
    void say(const std::string& notice);
    nlohmann::json reportOf(const WalkStage& stage) const;

    const scene::Scene& scene_;
    DrawnScene drawnScene_;
    const WalkOptions& options_;
    DeskSide* deskSide_;
    Knobs knobs_;
    scene::Pose worldFromWalk_;
    std::optional<input::StartPose> start_;
    bool hasBegun_ = false, startsHere_ = false;
    input::Surroundings surroundings_;
    input::Locomotion locomotion_;
    std::optional<bool> wasAtDesk_; ///< in the frame before
    xr::Headless::Path path_;
    std::optional<scene::Pose> firstHead_;
    WalkRecord record_;
    FrameReport report_;
    DamageTeller damage_;
    Selection selection_;
    nlohmann::json lastReport_;
    render::FrameStats stats_;
    std::optional<GovernedQuality> governed_;
    LossWatch losses_;
    GivenUp givenUp_;
    render::Quality drawn_; ///< of the frame drawn last
    render::Overlay overlay_;
    std::array<std::string, input::kHands> controllers_;
    int framesWithoutController_ = 0;
    std::optional<Annotator> annotator_;
    std::optional<ModelAim> models_;
    std::array<input::Hand, input::kHands> hands_{}; ///< in the frame before it is drawn
    bool pressMeasures_ = false; ///< whether the press at the desk that is under way is of a distance
    render::FramePictures mirrored_;
    WalkFacts facts_;
    std::future<std::unique_ptr<xr::Runtime>> sought_;
    std::unique_ptr<xr::Runtime> found_;
    std::chrono::steady_clock::time_point soughtAt_, frameAt_, frameBegan_; ///< the last: or was warmed up
    double heading_ = 0;            ///< of the head in the frame before, walk space
    double wentAt_ = 0;             ///< seconds_ when the walker was moved last
    double seconds_ = 0;            ///< of this frame, since the walk began
    const void* clockOf_ = nullptr; ///< the source that frameSeconds_ is from
    double frameSeconds_ = 0, clockOffset_ = 0;
    std::chrono::steady_clock::time_point began_;
    std::size_t frame_ = 0;
    std::optional<std::int64_t> refreshesMissed_; ///< of a headset's display that is known
    bool wasWarmedUp_ = false;                    ///< in the frame before, which took long
    bool wasTracked_ = true;
    const scene::Coverage* shownUnseen_ = nullptr; ///< null: nothing is
    std::optional<scene::Coverage> coarser_;       ///< as it is drawn, if that is not all of it
    int coarserLevels_ = 0;
};

} // namespace app
