#include "app/view_files.h"

#include "scene/errors.h"

#include <cmath>
#include <fstream>

#include <nlohmann/json.hpp>

namespace app {

namespace {

using nlohmann::json;

constexpr int kMaxSide = 16384;

json parse(const std::filesystem::path& path) {
    std::ifstream file(path);
    if (!file) throw scene::Failure("no such file", path, "check the path");
    try {
        return json::parse(file);
    } catch (const json::parse_error& e) {
        throw scene::Failure("is not valid JSON", scene::atByte(path, e.byte), "repair it there");
    } catch (const json::exception& e) { // a number that no double can hold
        throw scene::Failure(std::string("has a number that cannot be used (") + e.what() + ")", path, "correct it");
    }
}

/// A head's axes (x right, y up, z back) -> a camera's (x right, y down, z forward).
scene::Pose headFromCamera() {
    return {glm::dmat3(1, 0, 0, 0, -1, 0, 0, 0, -1), glm::dvec3(0)};
}

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

scene::Pose readHead(const json& from, const std::string& where) {
    try {
        const auto p = from.at("position").get<std::vector<double>>();
        const auto q = from.at("orientation").get<std::vector<double>>();
        bool finite = p.size() == 3 && q.size() == 4;
        for (const double v : p)
            finite = finite && std::isfinite(v);
        double length = 0;
        for (const double v : q)
            length += v * v;
        if (!finite || !(length > 1e-12) || !std::isfinite(length))
            throw scene::Failure("is not a pose", where,
                                 "give a position [x, y, z] and a quaternion [x, y, z, w] that is not zero");
        return scene::poseFromQuaternion({p[0], p[1], p[2]}, q[0], q[1], q[2], q[3]);
    } catch (const json::exception& e) {
        throw scene::Failure(std::string("lacks something or has it wrong (") + e.what() + ")", where,
                             "a pose has t, position and orientation");
    }
}

double readSeconds(const json& from, const std::string& where) {
    if (!from.is_number())
        throw scene::Failure("has a t that is no number", where, "give t in seconds, or leave it out");
    return from.get<double>();
}

} // namespace

std::vector<NamedView> readCamerasFile(const std::filesystem::path& path) {
    const json root = parse(path);
    if (!root.is_object() || !root.contains("cameras") || !root["cameras"].is_array() || root["cameras"].empty())
        throw scene::Failure("lists no cameras", path, "write {\"cameras\": [...]}");
    std::vector<NamedView> views;
    for (std::size_t i = 0; i < root["cameras"].size(); ++i)
        views.push_back(readCamera(root["cameras"][i], path.string() + ", camera " + std::to_string(i)));
    return views;
}

std::vector<NamedView> readPathFile(const std::filesystem::path& path, const scene::Pose& walkFromWorld,
                                    const scene::Camera& camera) {
    const json root = parse(path);
    if (!root.is_object() || !root.contains("poses") || !root["poses"].is_array() || root["poses"].empty())
        throw scene::Failure("lists no poses", path, "write {\"space\": \"walk\", \"poses\": [...]}");
    const std::string space =
        root.contains("space") && root["space"].is_string() ? root["space"].get<std::string>() : "";
    if (space != "walk" && space != "world")
        throw scene::Failure("does not say its space", path, "write \"space\": \"walk\" or \"world\"");
    const scene::Pose worldFromSpace = space == "walk" ? inverse(walkFromWorld) : scene::Pose{};
    std::vector<NamedView> views;
    for (std::size_t i = 0; i < root["poses"].size(); ++i) {
        const json& pose = root["poses"][i];
        const std::string where = path.string() + ", pose " + std::to_string(i);
        const scene::Pose spaceFromHead = readHead(pose, where);
        const std::string number = std::to_string(i);
        NamedView view{"pose-" + std::string(number.size() < 4 ? 4 - number.size() : 0, '0') + number, camera,
                       worldFromSpace * spaceFromHead * headFromCamera(), 0};
        if (pose.contains("t")) view.seconds = readSeconds(pose["t"], where);
        if (!views.empty() && view.seconds < views.back().seconds)
            throw scene::Failure("is earlier than the pose before it", where, "give t in seconds, in ascending order");
        views.push_back(std::move(view));
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
