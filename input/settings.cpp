#include "input/settings.h"

#include "scene/errors.h"
#include "scene/json_file.h"

#include <cmath>
#include <cstdlib>
#include <vector>

namespace input {

namespace {

using nlohmann::json;
namespace fs = std::filesystem;

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
            throw scene::Failure(std::string(name) + " is no number from " + std::to_string(least) + " to " +
                                     std::to_string(most),
                                 file, "correct or remove it");
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
    if (file.empty() || !fs::exists(file)) return settings;
    const json root = scene::readJsonFile(file);
    if (!root.is_object()) throw scene::Failure("holds no settings", file, "correct or remove it");
    forEachSetting(settings, Reader{root, file});
    return settings;
}

std::string textOf(const Settings& settings, const fs::path& before) {
    json root = json::object();
    if (fs::exists(before)) root = scene::readJsonFile(before);
    forEachSetting(settings, Writer{root});
    return root.dump(1) + "\n";
}

std::optional<StartPose> readStart(const fs::path& file) {
    if (!fs::exists(file)) return std::nullopt;
    const json root = scene::readJsonFile(file);
    try {
        const auto feet = root.at("feet").get<std::vector<double>>();
        StartPose start;
        start.heading = root.at("heading").get<double>();
        start.scale = root.at("scale").get<double>();
        if (feet.size() != 3 || !std::isfinite(feet[0] + feet[1] + feet[2] + start.heading + start.scale) ||
            !(start.scale > 0))
            throw scene::Failure("says no place to start from", file, "correct or remove it");
        start.feet = {feet[0], feet[1], feet[2]};
        return start;
    } catch (const json::exception&) {
        throw scene::Failure("says no place to start from", file, "correct or remove it");
    }
}

std::string textOf(const StartPose& start) {
    return json{
               {"feet", {start.feet.x, start.feet.y, start.feet.z}}, {"heading", start.heading}, {"scale", start.scale}}
               .dump(1) +
           "\n";
}

} // namespace input
