#pragma once
// Puts a person inside a scene: in a headset, or without any display along a path.

#include "app/draw_options.h"

#include "input/settings.h"

#include <filesystem>
#include <optional>

namespace app {

struct WalkOptions {
    std::filesystem::path scene;
    bool isHeadless = false;       ///< no runtime, no window; needs a path
    bool isAtDesk = false;         ///< a window, no runtime
    std::filesystem::path path;    ///< where the walker is led; empty: the walker goes
    std::filesystem::path record;  ///< path file that is written at the end: the head in walk space
    std::filesystem::path out;     ///< folder for report.json and pictures; empty: no files
    int pictureEvery = 0;          ///< frames from picture to picture in out; 0: none
    int frames = 0;                ///< ends after so many; 0: when the path or the walker ends
    int width = 640, height = 480; ///< headless; a headset has its own
    double framesPerSecond = 0;    ///< 0: as the headset has it; headless, along the path, 90
    /// Gives up quality where framesPerSecond is not held. Headless only when asked: what is drawn would hang on how
    /// busy the machine is.
    std::optional<bool> holdsRate;
    DrawOptions draw;
    input::Settings settings;
};

/// Throws scene::Failure.
void walkScene(const WalkOptions& options);

} // namespace app
