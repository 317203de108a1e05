#pragma once
// What the thread with the window and the thread that walks tell each other. Neither waits for the other.

#include "input/keyboard.h"
#include "input/settings.h"
#include "render/quality.h"
#include "render/renderer.h"

#include <atomic>
#include <mutex>
#include <string>

namespace app {

/// What can be turned at the panel and acts at once.
struct Knobs {
    render::Quality quality;
    double resolutionScale = 1; ///< at the desk: pixels of a picture's side over the window's
    bool isFilmed = false;      ///< what is shown goes into a film
    int deskEyes = 1;
    bool showsCameras = false, showsCells = false;
    input::Settings settings;
};

/// What the panel says of the walk.
struct WalkFacts {
    std::string display;  ///< what the walker looks through
    bool isAtDesk = true; ///< the keys and the mouse lead, nobody wears a headset
    bool isTracked = true;
    double framesPerSecond = 0;
    render::FrameStats stats; ///< the newest
    glm::dvec3 place{0};      ///< of the head, walk space
    double speed = 0;         ///< metres a second
    double scale = 1;         ///< of the world: walk metres per metre of the wearer's room
    std::string given;        ///< up by the governor; empty: nothing
    std::string notice;       ///< the last thing that was said
};

class Desk {
  public:
    explicit Desk(const Knobs& knobs) : knobs_(knobs) {}

    // For the thread that walks.

    Knobs knobs() const;
    /// What was said since the last call; held keys go on being held.
    input::DeskSays hear();
    /// Whether a new picture would be shown.
    bool wantsPicture() const { return wantsPicture_; }
    /// Swaps: pictures comes back with memory to use again.
    void show(render::FramePictures& pictures);
    void tell(const WalkFacts& facts);
    /// The walk is over.
    void leave() { isOver_ = true; }

    // For the window's.

    void turn(const Knobs& knobs);
    void say(const input::DeskSays& says);
    /// The newest pictures, if they have not been taken yet.
    bool take(render::FramePictures& pictures);
    WalkFacts facts() const;
    void askForPicture() { wantsPicture_ = true; }
    bool isOver() const { return isOver_; }

  private:
    mutable std::mutex mutex_;
    Knobs knobs_;
    input::DeskSays says_; ///< not heard yet
    input::DeskSays now_;  ///< said last
    render::FramePictures pictures_;
    WalkFacts facts_;
    bool hasPictures_ = false;
    std::atomic<bool> wantsPicture_ = true, isOver_ = false;
};

} // namespace app
