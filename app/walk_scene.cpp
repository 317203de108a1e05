#include "app/walk_scene.h"

#include "app/frame_pictures.h"
#include "app/frame_report.h"
#include "app/stage_store.h"
#include "app/view_files.h"
#include "app/walk_stage.h"

#include "scene/errors.h"
#include "scene/scene_file.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <optional>
#include <thread>

namespace app {

namespace {

using nlohmann::json;

volatile std::sig_atomic_t wasAskedToEnd = 0;

/// How often a headset that went away is looked for.
constexpr std::chrono::milliseconds kLookAgain{500};

/// Ctrl-C ends the walk as the wearer would: what was recorded is written.
class EndBySignal {
  public:
    EndBySignal() {
        wasAskedToEnd = 0;
        struct sigaction action {};
        action.sa_handler = [](int) { wasAskedToEnd = 1; };
        sigaction(SIGINT, &action, &previousInt_);
        sigaction(SIGTERM, &action, &previousTerm_);
    }
    ~EndBySignal() {
        sigaction(SIGINT, &previousInt_, nullptr);
        sigaction(SIGTERM, &previousTerm_, nullptr);
    }
    EndBySignal(const EndBySignal&) = delete;
    EndBySignal& operator=(const EndBySignal&) = delete;

  private:
    struct sigaction previousInt_ {
    }, previousTerm_{};
};

/// What was seen, for the files that are asked for.
class Record {
  public:
    Record(const WalkOptions& options, const scene::Pose& worldFromWalk)
        : options_(options), worldFromWalk_(worldFromWalk) {}

    void addPose(double seconds, const scene::Pose& walkFromHead) {
        if (options_.record.empty()) return;
        const glm::dvec3& p = walkFromHead.translation;
        const glm::dvec4 q = quaternionOf(walkFromHead);
        poses_.push_back({{"t", seconds}, {"position", {p.x, p.y, p.z}}, {"orientation", {q.x, q.y, q.z, q.w}}});
    }

    bool wantsPicture(int frame) const {
        return options_.pictureEvery > 0 && !options_.out.empty() && frame % options_.pictureEvery == 0;
    }

    /// What the eye was given, and the camera it was given for.
    void addPicture(int frame, std::size_t eye, const scene::View& view, render::EyeImage image) {
        char name[64];
        std::snprintf(name, sizeof name, "frame-%06d-%s", frame, eye == 0 ? "left" : "right");
        writePictures(image, options_.out, name, false);
        json rows = json::array();
        const glm::dmat4 m = toMatrix(view.worldFromEye);
        for (int i = 0; i < 16; ++i)
            rows.push_back(m[i % 4][i / 4]);
        const scene::Camera& c = view.camera;
        cameras_.push_back({{"name", name},
                            {"width", c.width},
                            {"height", c.height},
                            {"fx", c.fx},
                            {"fy", c.fy},
                            {"cx", c.cx},
                            {"cy", c.cy},
                            {"world_from_camera", rows}});
    }

    void write() const {
        if (!options_.record.empty())
            writeWhole(options_.record, json{{"space", "walk"}, {"poses", poses_}}.dump(1) + "\n");
        if (!cameras_.empty()) writeWhole(options_.out / "cameras.json", json{{"cameras", cameras_}}.dump(1) + "\n");
    }

  private:
    const WalkOptions& options_;
    scene::Pose worldFromWalk_;
    json poses_ = json::array(), cameras_ = json::array();
};

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

/// One person's walk; goes on when the headset has been away.
class Walk {
  public:
    Walk(const scene::Scene& scene, const WalkOptions& options)
        : scene_(scene), options_(options), quality_(qualityOf(options.draw)),
          worldFromWalk_(inverse(scene.walkFromWorld)), record_(options, worldFromWalk_) {
        if (!options.path.empty()) path_ = pathOf(options, scene);
    }

    void run() {
        WalkStage stage =
            options_.isHeadless ? WalkStage::headless(scene_, path_, options_) : WalkStage::inHeadset(scene_);
        std::fprintf(stderr, "walking: %s, on %s, %dx%d an eye\n", stage.name().c_str(), stage.device().name().c_str(),
                     stage.source().width(), stage.source().height());
        std::optional<WalkStage> current(std::move(stage));
        json report;
        while (true) {
            const bool isLost = walkOn(*current);
            report = reportOf(*current);
            if (!isLost) break;
            std::fprintf(stderr, "the headset is gone; looking for it (Ctrl-C ends the walk)\n");
            current.reset();
            if (!comeBack(current)) break;
            std::fprintf(stderr, "the headset is back: %s\n", current->name().c_str());
        }
        record_.write();
        if (!options_.out.empty())
            writeWhole(options_.out / "report.json", report.dump(1, ' ', false, json::error_handler_t::replace) + "\n");
    }

  private:
    /// Until the end (false) or until the headset is gone (true).
    bool walkOn(WalkStage& stage) {
        bool hasAsked = false;
        while (true) {
            const bool isOver = wasAskedToEnd != 0 || (options_.frames > 0 && frame_ >= options_.frames);
            if (isOver && !hasAsked) {
                hasAsked = true;
                if (!stage.requestEnd()) return false;
            }
            const auto start = std::chrono::steady_clock::now();
            const xr::Frame frame = stage.source().begin();
            if (frame.kind == xr::Frame::Kind::lost) return !isOver;
            if (frame.kind == xr::Frame::Kind::end) return false;
            if (frame.kind == xr::Frame::Kind::skip) continue;
            draw(stage, frame);
            stage.source().end(frame);
            const std::chrono::duration<double, std::milli> passed = std::chrono::steady_clock::now() - start;
            report_.add({}, stats_, passed.count());
            ++frame_;
        }
    }

    void draw(WalkStage& stage, const xr::Frame& frame) {
        if (!options_.isHeadless && path_) {
            // The path leads the walker; in a headset the head moves about it as it likes.
            const auto led = path_(frame.seconds);
            if (led) walkFromTracking_ = *led * inverse(firstHead(frame));
        }
        record_.addPose(frame.seconds, walkFromTracking_ * frame.trackingFromHead);
        std::array<scene::View, xr::kEyes> views;
        std::array<render::EyeOutput, xr::kEyes> outputs;
        for (std::size_t eye = 0; eye < xr::kEyes; ++eye) {
            views[eye] = {frame.eyes[eye].camera, worldFromWalk_ * walkFromTracking_ * frame.eyes[eye].worldFromEye};
            outputs[eye].image = frame.images[eye].image;
            outputs[eye].layer = frame.images[eye].layer;
        }
        stats_ = stage.renderer().draw(views, quality_, outputs);
        if (!record_.wantsPicture(frame_)) return;
        std::vector<render::EyeImage> pictures = stage.renderer().readBack();
        for (std::size_t eye = 0; eye < xr::kEyes; ++eye) {
            // Where there is a headset, what it was given counts and not what we have.
            if (outputs[eye].image != VK_NULL_HANDLE)
                pictures[eye].colour =
                    render::readOutput(stage.device(), outputs[eye], stage.source().width(), stage.source().height());
            record_.addPicture(frame_, eye, views[eye], std::move(pictures[eye]));
        }
    }

    const scene::Pose& firstHead(const xr::Frame& frame) {
        if (!firstHead_) firstHead_ = frame.trackingFromHead;
        return *firstHead_;
    }

    /// Waits for a headset; false if asked to end meanwhile.
    bool comeBack(std::optional<WalkStage>& stage) {
        while (wasAskedToEnd == 0) {
            try {
                stage.emplace(WalkStage::inHeadset(scene_));
                return true;
            } catch (const std::exception&) {
                // Not yet there. OpenXR has no event for a runtime that appears.
                std::this_thread::sleep_for(kLookAgain);
            }
        }
        return false;
    }

    json reportOf(const WalkStage& stage) const {
        return report_.summarise(stage.device(), stage.gpuScene(),
                                 {{"scene", options_.scene.string()},
                                  {"display", stage.name()},
                                  {"warp", options_.draw.warp},
                                  {"eyes", xr::kEyes},
                                  {"near_baseline", quality_.preference.nearBaseline},
                                  {"max_footprint", quality_.maxFootprint}});
    }

    const scene::Scene& scene_;
    const WalkOptions& options_;
    render::Quality quality_;
    scene::Pose worldFromWalk_, walkFromTracking_;
    xr::Headless::Path path_;
    std::optional<scene::Pose> firstHead_;
    Record record_;
    FrameReport report_;
    render::FrameStats stats_;
    int frame_ = 0;
};

} // namespace

void walkScene(const WalkOptions& options) {
    if (options.isHeadless && options.path.empty())
        throw scene::Failure("leads nowhere", std::string("--headless"), "give --path FILE as well");
    const scene::Scene scene = scene::openScene(options.scene);
    checkMemory(scene, options.draw);
    if (!options.out.empty()) {
        std::error_code error;
        std::filesystem::create_directories(options.out, error);
        if (error)
            throw scene::Failure("cannot be made (" + error.message() + ")", options.out,
                                 "check that the folder may be written");
    }
    const EndBySignal endBySignal;
    Walk(scene, options).run();
}

} // namespace app
