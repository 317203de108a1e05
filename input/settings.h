#pragma once
// What a walker likes, kept between walks, and where walks through a scene begin.

#include "input/locomotion.h"

#include <filesystem>
#include <optional>
#include <string>

namespace input {

struct Settings {
    LocomotionSettings locomotion;
    double eyeHeightMetres = 1.6; ///< at the desk
    bool showsFloorGrid = false;
};

/// $XDG_CONFIG_HOME/revisit/settings.json, or below ~/.config; empty if there is no home.
std::filesystem::path settingsFile();

/// The defaults if there is no such file; what it leaves out is as the defaults have it. Throws scene::Failure if it is
/// broken or a value is out of its range.
Settings readSettings(const std::filesystem::path& file);

/// The text of such a file. What stands in `before`, an earlier file, and is not known here is kept. Throws
/// scene::Failure if that file is broken: whoever wrote it would lose it.
std::string textOf(const Settings& settings, const std::filesystem::path& before);

inline constexpr const char* kStartFile = "start.json"; ///< in the scene's folder

/// {"feet": [x, y, z], "heading": radians to the left, "scale": walk metres per metre}, walk space.
struct StartPose {
    glm::dvec3 feet{0};
    double heading = 0, scale = 1;
};
/// Nothing if there is no such file. Throws scene::Failure, also for places where no
/// rig may stand.
std::optional<StartPose> readStart(const std::filesystem::path& file);
std::string textOf(const StartPose& start);

} // namespace input
