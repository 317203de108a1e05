#include "app/view_files.h"

#include "input/path.h"
#include "scene/errors.h"
#include "scene/json_file.h"

#include <cmath>
#include <unordered_set>

#include <nlohmann/json.hpp>

namespace app {

namespace {

using nlohmann::json;

constexpr int kMaxSide = 16384;

std::string fileNameOf(std::string name) {
    for (char& c : name)
        if (c == '/' || c == '\\' || static_cast<unsigned char>(c) < 32) c = '-';
    return name;
}

/// A whole number of pixels; 0, which no camera has, for any other number.
int readSide(const json& from) {
    const auto side = from.get<double>();
    return side >= 1 && side <= kMaxSide && side == std::floor(side) ? static_cast<int>(side) : 0;
}

NamedView readCamera(const json& from, const std::string& where) {
    NamedView view;
    try {
        view.name = fileNameOf(from.at("name").get<std::string>());
        view.camera = {readSide(from.at("width")),  readSide(from.at("height")), from.at("fx").get<double>(),
                       from.at("fy").get<double>(), from.at("cx").get<double>(), from.at("cy").get<double>()};
        const auto values = from.at("world_from_camera").get<std::vector<double>>();
        glm::dmat4 m(0.0);
        for (std::size_t i = 0; i < 16; ++i)
            m[static_cast<int>(i % 4)][static_cast<int>(i / 4)] = values.at(i);
        if (values.size() != 16 || !poseFromMatrix(m, 1e-3, view.worldFromCamera))
            throw scene::Failure("world_from_camera is not a rigid 4x4 pose", where,
                                 "give 16 finite numbers, row by row, without scale");
    } catch (const json::exception& e) {
        throw scene::Failure(std::string("lacks something or has it wrong (") + e.what() + ")", where,
                             "a camera has name, width, height, fx, fy, cx, cy and world_from_camera");
    } catch (const std::out_of_range&) {
        throw scene::Failure("world_from_camera has fewer than 16 numbers", where, "give a 4x4 pose, row by row");
    }
    if (view.name.empty() || !isUsable(view.camera))
        throw scene::Failure("has no name, or intrinsics that are not usable", where,
                             "correct name, width, height, fx, fy, cx, cy");
    return view;
}

} // namespace

std::vector<NamedView> readCamerasFile(const std::filesystem::path& path) {
    const json root = scene::readJsonFile(path);
    if (!root.is_object() || !root.contains("cameras") || !root["cameras"].is_array() || root["cameras"].empty())
        throw scene::Failure("lists no cameras", path, "write {\"cameras\": [...]}");
    std::vector<NamedView> views;
    std::unordered_set<std::string> names; // of the pictures' files
    for (std::size_t i = 0; i < root["cameras"].size(); ++i) {
        const std::string where = path.string() + ", camera " + std::to_string(i);
        views.push_back(readCamera(root["cameras"][i], where));
        if (!names.insert(views.back().name).second)
            throw scene::Failure("is called '" + views.back().name + "' like one before it", where,
                                 "give each camera a name of its own");
    }
    return views;
}

std::vector<NamedView> readPathFile(const std::filesystem::path& path, const scene::Pose& walkFromWorld,
                                    const scene::Camera& camera) {
    const input::RecordedPath recorded = input::readPath(path);
    const scene::Pose worldFromSpace =
        recorded.space == input::PathSpace::walk ? inverse(walkFromWorld) : scene::Pose{};
    std::vector<NamedView> views;
    for (const input::PathKey& key : recorded.keys) {
        const std::string number = std::to_string(views.size());
        views.push_back({"pose-" + std::string(number.size() < 4 ? 4 - number.size() : 0, '0') + number, camera,
                         worldFromSpace * key.spaceFromHead * scene::headFromCamera(), key.seconds});
    }
    return views;
}

std::vector<NamedView> heldOutViews(const scene::Scene& scene) {
    std::vector<NamedView> views;
    for (const scene::SceneImage& image : scene.heldOut)
        views.push_back({image.name, image.camera, image.worldFromCamera, 0});
    return views;
}

} // namespace app
