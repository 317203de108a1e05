#include "app/walkers_files.h"

#include "app/notes.h"
#include "input/settings.h"
#include "scene/errors.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <system_error>

namespace app {

namespace {

using nlohmann::json;

constexpr double kSamePlaceMetres = 1e-4; ///< and turns, in entries of a rotation

std::size_t countNotes(const std::filesystem::path& scene) {
    try {
        return NotesFile(scene).read().list.size();
    } catch (const scene::Failure&) {
        return 0; // whoever reads them is told
    }
}

json readOlder(const std::filesystem::path& scene) {
    std::ifstream file(scene / "scene.json");
    return json::parse(file, nullptr, false);
}

std::map<std::string, std::vector<double>> posesOf(const json& manifest) {
    std::map<std::string, std::vector<double>> poses;
    for (const json& image : manifest.at("images"))
        poses[image.at("name")] = image.at("world_from_camera").get<std::vector<double>>();
    return poses;
}

/// Of images that both have; not so if they share none.
bool standAlike(const json& before, const json& now) {
    const auto older = posesOf(before), newer = posesOf(now);
    std::size_t shared = 0;
    for (const auto& [name, pose] : newer) {
        const auto found = older.find(name);
        if (found == older.end()) continue;
        ++shared;
        if (!std::equal(pose.begin(), pose.end(), found->second.begin(), found->second.end(),
                        [](double a, double b) { return std::abs(a - b) <= kSamePlaceMetres; }))
            return false;
    }
    return shared > 0;
}

} // namespace

void carryWalkersFiles(const std::filesystem::path& from, const std::filesystem::path& to) {
    for (const std::filesystem::path& name :
         {NotesFile(from).path().filename(), std::filesystem::path(input::kStartFile)}) {
        std::error_code error;
        if (!std::filesystem::exists(from / name, error)) continue;
        std::filesystem::copy_file(from / name, to / name, error);
        if (error) throw scene::Failure("cannot be written (" + error.message() + ")", to / name, scene::kWriteRemedy);
    }
}

std::optional<std::string> remarkOnNotes(const std::filesystem::path& olderScene, json& manifest) {
    manifest["notes_from_elsewhere"] = false;
    const std::size_t notes = countNotes(olderScene);
    if (notes == 0) return std::nullopt;
    try {
        const json older = readOlder(olderScene);
        if (standAlike(older, manifest) && !older.value("notes_from_elsewhere", false)) return std::nullopt;
    } catch (const json::exception&) {
        // A scene.json that cannot be read tells of no image that stands where it stood.
    }
    manifest["notes_from_elsewhere"] = true;
    const std::string remark = "Of a scene that stood here before " + std::to_string(notes) +
                               (notes == 1 ? " note was kept, but its" : " notes were kept, but its") +
                               " images stood elsewhere, or were others: measure again what must be right.";
    manifest["provenance"]["remarks"].push_back(remark);
    return remark;
}

} // namespace app
