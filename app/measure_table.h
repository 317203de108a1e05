#pragma once
// What `measure` found, as a table to read and as JSON.

#include "app/picture_error.h"

#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace app {

struct MeasuredPicture {
    std::string name; ///< of the camera
    PictureError error;
};

/// One setting's figures.
struct MeasuredSetting {
    std::string name;
    nlohmann::json quality; ///< all its knobs
    nlohmann::json times{}; ///< as FrameReport::summarise has them: frame_ms, cpu_ms, gpu_ms, samples_drawn, ...
    double medianMilliseconds = 0, p99Milliseconds = 0;       ///< a frame, drawn until it was finished
    double processorMilliseconds = 0, deviceMilliseconds = 0; ///< medians of the frame's parts
    std::vector<MeasuredPicture> pictures{};
};

/// The mean over a setting's pictures; what is not a number in one has no share.
PictureError meanOf(std::span<const MeasuredPicture> pictures);

struct Trade {
    double milliseconds = 0, decibels = 0;
};

/// Which trades no other beats: none is at least as fast and at least as good, and better in one of both. Two that are
/// the same are both in.
std::vector<bool> paretoFront(std::span<const Trade> trades);

/// Markdown, one line a setting in the order given; `*` where it is on the front of milliseconds against PSNR.
/// ladderStart: from this setting on they are the governor's rungs, told in a second table with what each costs in
/// decibels and saves in milliseconds.
std::string tableOf(std::span<const MeasuredSetting> settings, std::size_t ladderStart);

/// As the table: an array of settings.
nlohmann::json toJson(std::span<const MeasuredSetting> settings);

} // namespace app
