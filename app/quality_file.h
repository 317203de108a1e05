#pragma once
// The knobs of render::Quality by name, each named once, in quality_file.cpp: files, the command line, reports and what
// `measure` tries all follow that table.

#include "render/quality.h"

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace app {

/// Bound of the knobs sample_pixels and far_sample_pixels, pixels.
inline constexpr double kMostSamplePixels = 64;

struct Knob {
    std::string name;                  ///< in files, reports and, with dashes, on the command line; never renamed
    std::string unit;                  ///< of its numbers; may be empty
    std::string does;                  ///< for help
    std::string values;                ///< what it takes, in words: "a whole number of 1 to 64"
    std::vector<nlohmann::json> tried; ///< what `measure` tries of it; empty where there is nothing to measure
    std::string warp;                  ///< the only one that it matters to; empty: to all
    std::vector<std::string> names;    ///< what it takes where it takes names
    std::function<nlohmann::json(const render::Quality&)> get;
    /// False, and quality as it was, if the knob does not take that value.
    std::function<bool(render::Quality&, const nlohmann::json&)> set;
};

std::span<const Knob> knobs();

/// Turns a knob. Throws scene::Failure naming `where` if there is no such knob, or it does not take that value.
void turnKnob(render::Quality& quality, const std::string& name, const nlohmann::json& value, const std::string& where);

/// All knobs by name: what readQuality takes again.
nlohmann::json toJson(const render::Quality& quality);

/// Knobs by name; those that are not named are as the preset of the name "preset" has them, or as kDefaultPreset's.
/// Throws scene::Failure naming `where`.
render::Quality qualityOf(const nlohmann::json& object, const std::string& where);

/// Settings that somebody measured (docs/performance.md): fast, balanced, best.
struct Preset {
    std::string name;
    render::Quality quality;
};
std::span<const Preset> presets();
inline constexpr const char* kDefaultPreset = "balanced";

/// What --quality says: a preset's name, or a JSON file of knobs. Throws scene::Failure.
render::Quality readQuality(const std::string& presetOrFile);

/// What a settings file lists, by name: {"settings": [{"name": "...", knobs}, ...]}. Throws scene::Failure.
std::vector<Preset> readSettings(const std::filesystem::path& file);

} // namespace app
