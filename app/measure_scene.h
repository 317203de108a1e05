#pragma once
// Draws a scene with many settings, times them, and compares their pictures with photographs that were kept out.

#include "app/draw_options.h"

#include <filesystem>
#include <string>
#include <vector>

namespace app {

struct MeasureOptions {
    std::filesystem::path scene, out;
    std::filesystem::path cameras;  ///< with their pictures beside; empty: the held-out ones
    std::filesystem::path path;     ///< that is timed; empty: one from camera to camera
    std::filesystem::path settings; ///< what to measure (readSettings); empty: a sweep
    std::vector<std::string> sweep; ///< knobs that the sweep turns, one at a time; empty: all of them
    int width = 640, height = 480;  ///< of an eye along the path
    int frames = 60;                ///< along the path
    DrawOptions draw;               ///< where the sweep starts from
};

/// Settings by name, each different from the others: the presets, the start, and the start with one knob turned
/// that matters to its warp.
/// Throws scene::Failure if a knob's name is not one.
std::vector<Preset> sweepFrom(const render::Quality& start, const std::vector<std::string>& knobNames);

/// Writes report.json, table.md and the worst pictures into `out`, and prints the table. Throws scene::Failure.
void measureScene(const MeasureOptions& options);

} // namespace app
