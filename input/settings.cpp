#include "input/settings.h"

#include "scene/errors.h"
#include "scene/json_file.h"

#include <cstdio>
#include <cstdlib>
#include <vector>

namespace input {

namespace {

using nlohmann::json;
namespace fs = std::filesystem;

/// 0.1, and not 0.100000.
std::string shortly(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", value);
    return text;
}

/// Nothing if there is no such file. Throws scene::Failure if it is broken, or holds anything but fields.
std::optional<json> readFields(const fs::path& file) {
    std::error_code error;
    const fs::file_status status = fs::status(file, error);
    if (status.type() == fs::file_type::not_found) return std::nullopt;
    if (error) throw scene::Failure("cannot be looked for (" + error.message() + ")", file, "check the path");
    if (fs::is_directory(status)) throw scene::Failure("is a folder", file, "remove it");
    json root = scene::readJsonFile(file);
    if (!root.is_object()) throw scene::Failure("holds no fields", file, "correct or remove it");
    return root;
}

/// Calls visit(name, value, least, most) for each number and visit(name, value) for each switch, so that reading and
/// writing know the same ones.
template <class S, class Visit>
void forEachSetting(S& settings, Visit&& visit) {
    auto& l = settings.locomotion;
    visit("snap_degrees", l.snapDegrees, 0, 90);
    visit("turn_degrees_per_second", l.turnDegreesPerSecond, 10, 720);
    visit("metres_per_second", l.metresPerSecond, 0.1, 50);
    visit("hurry_factor", l.hurryFactor, 1, 20);
    visit("steepest_degrees", l.steepestDegrees, 0, 89);
    visit("reach_metres", l.reachMetres, 1, 1000);
    visit("vignette_rise_seconds", l.vignetteRiseSeconds, 0, 5);
    visit("vignette_fall_seconds", l.vignetteFallSeconds, 0, 5);
    visit("eye_height_metres", settings.eyeHeightMetres, 0.1, 3);
    visit("flies", l.flies);
    visit("vignette", l.hasVignette);
    visit("floor_grid", settings.showsFloorGrid);
}

struct Reader {
    const json& from;
    const fs::path& file;

    void operator()(const char* name, double& value, double least, double most) const {
        if (!from.contains(name)) return;
        const json& given = from[name];
        if (!given.is_number() || !(given.get<double>() >= least && given.get<double>() <= most))
            throw scene::Failure(name + (" is no number from " + shortly(least)) + " to " + shortly(most), file,
                                 "correct or remove it");
        value = given.get<double>();
    }
    void operator()(const char* name, bool& value) const {
        if (!from.contains(name)) return;
        if (!from[name].is_boolean())
            throw scene::Failure(std::string(name) + " is neither true nor false", file, "correct or remove it");
        value = from[name].get<bool>();
    }
};

struct Writer {
    json& to;
    void operator()(const char* name, const double& value, double, double) const { to[name] = value; }
    void operator()(const char* name, const bool& value) const { to[name] = value; }
};

} // namespace

fs::path settingsFile() {
    const auto valueOf = [](const char* name) -> std::string {
        const char* const value = std::getenv(name);
        return value != nullptr ? value : "";
    };
    // The specification wants relative paths there to be passed over.
    if (const fs::path config = valueOf("XDG_CONFIG_HOME"); config.is_absolute())
        return config / "revisit" / "settings.json";
    if (const fs::path home = valueOf("HOME"); home.is_absolute())
        return home / ".config" / "revisit" / "settings.json";
    return {};
}

Settings readSettings(const fs::path& file) {
    Settings settings;
    if (file.empty()) return settings;
    if (const std::optional<json> root = readFields(file)) forEachSetting(settings, Reader{*root, file});
    return settings;
}

std::string textOf(const Settings& settings, const fs::path& before) {
    json root = before.empty() ? json::object() : readFields(before).value_or(json::object());
    forEachSetting(settings, Writer{root});
    return root.dump(1) + "\n";
}

std::optional<StartPose> readStart(const fs::path& file) {
    const std::optional<json> root = readFields(file);
    if (!root) return std::nullopt;
    const scene::Failure failure("says no place to start from", file, "correct or remove it");
    try {
        const auto feet = root->at("feet").get<std::vector<double>>();
        if (feet.size() != 3) throw failure;
        const Rig rig{{feet[0], feet[1], feet[2]}, root->at("heading").get<double>(), root->at("scale").get<double>()};
        if (!isUsable(rig)) throw failure;
        return StartPose{rig.origin, rig.yaw, rig.scale};
    } catch (const json::exception&) {
        throw failure;
    }
}

std::string textOf(const StartPose& start) {
    return json{
               {"feet", {start.feet.x, start.feet.y, start.feet.z}}, {"heading", start.heading}, {"scale", start.scale}}
               .dump(1) +
           "\n";
}

} // namespace input
