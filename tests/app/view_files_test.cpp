#include "app/view_files.h"

#include "scene/errors.h"
#include "tests/scene/scratch_folder.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace app {
namespace {

using nlohmann::json;
using scene::Failure;
using scene::failureOf;

const json kCamera{{"name", "a"},  {"width", 64},
                   {"height", 48}, {"fx", 50.5},
                   {"fy", 51},     {"cx", 32},
                   {"cy", 24},     {"world_from_camera", {0, 0, 1, 1.5, 1, 0, 0, 2.5, 0, 1, 0, 3.5, 0, 0, 0, 1}}};
const json kPose{{"t", 0.5}, {"position", {1, 1.6, -2}}, {"orientation", {0, 0, 0, 1}}};
const scene::Camera kEye{64, 48, 50, 50, 32, 24};

/// Numbers that no JSON writer of ours would write.
const char* const kNoNumbers[] = {"NaN", "nan", "Infinity", "-Infinity", "1e999", "-1e999", "0x10", "1e"};

class ViewFiles : public testing::Test {
  protected:
    std::filesystem::path file(const std::string& text) const {
        scene::writeFile(path_, text);
        return path_;
    }
    std::vector<NamedView> cameras(const json& list) const {
        return readCamerasFile(file(json{{"cameras", list}}.dump()));
    }
    std::vector<NamedView> poses(const json& list, const char* space = "world",
                                 const scene::Pose& walkFromWorld = {}) const {
        return readPathFile(file(json{{"space", space}, {"poses", list}}.dump()), walkFromWorld, kEye);
    }
    /// Every failure names the file, in one line, with a way out.
    void expectRefused(const std::string& failure, const std::string& what) const {
        EXPECT_EQ(failure.find(path_.string()), 0u) << what << ": " << failure;
        EXPECT_NE(failure.find("; "), std::string::npos) << what << ": " << failure;
        EXPECT_EQ(failure.find('\n'), std::string::npos) << what << ": " << failure;
    }
    void expectNoCameras(const std::string& text) const {
        expectRefused(failureOf<Failure>([&] { readCamerasFile(file(text)); }), text);
    }
    void expectNoPath(const std::string& text) const {
        expectRefused(failureOf<Failure>([&] { readPathFile(file(text), {}, kEye); }), text);
    }
    void expectNoCamera(const char* key, const json& value) const {
        json camera = kCamera;
        camera[key] = value;
        expectRefused(failureOf<Failure>([&] { cameras({kCamera, camera}); }), camera.dump());
    }
    void expectNoPose(const char* key, const json& value) const {
        json pose = kPose;
        pose[key] = value;
        const std::string failure = failureOf<Failure>([&] { poses({kPose, pose}); });
        expectRefused(failure, pose.dump());
        EXPECT_NE(failure.find("pose 1"), std::string::npos) << failure;
    }

    scene::ScratchFolder scratch_;
    std::filesystem::path path_ = scratch_ / "views.json";
};

/// A text with one of its numbers, written as 12345, replaced by what may be no JSON.
std::string with(const json& value, const std::string& number) {
    std::string text = value.dump();
    return text.replace(text.find("12345"), 5, number);
}

TEST_F(ViewFiles, CamerasComeAsTheyAreWritten) {
    json second = kCamera;
    second["name"] = "up/and\\away\n";
    const std::vector<NamedView> views = cameras({kCamera, second});
    ASSERT_EQ(views.size(), 2u);
    EXPECT_EQ(views[0].name, "a");
    EXPECT_EQ(views[1].name, "up-and-away-") << "a name becomes a file's";
    EXPECT_EQ(views[0].camera, (scene::Camera{64, 48, 50.5, 51, 32, 24}));
    EXPECT_EQ(views[0].worldFromCamera.translation, glm::dvec3(1.5, 2.5, 3.5));
    // Row by row: the camera's z axis is the world's x axis.
    EXPECT_EQ(views[0].worldFromCamera.rotation * glm::dvec3(0, 0, 1), glm::dvec3(1, 0, 0));
    EXPECT_EQ(views[0].worldFromCamera.rotation * glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0));
}

TEST_F(ViewFiles, CamerasOfOtherTypesAreRefused) {
    for (const char* text :
         {"", "{", "null", "[]", "7", "{}", R"({"cameras": []})", R"({"cameras": {}})", R"({"cameras": "all"})",
          R"({"cameras": [7]})", R"({"cameras": [null]})", R"({"cameras": [[]]})", R"({"poses": []})", "\xff\xfe"})
        expectNoCameras(text);
    for (const char* key : {"name", "width", "height", "fx", "fy", "cx", "cy", "world_from_camera"}) {
        json camera = kCamera;
        camera.erase(key);
        const std::string failure = failureOf<Failure>([&] { cameras({kCamera, camera}); });
        expectRefused(failure, std::string("without ") + key);
        EXPECT_NE(failure.find("camera 1"), std::string::npos) << failure;
        for (const json& bad : {json(nullptr), json::object(), json::array(), json(true)})
            if (!(std::string(key) != "name" && bad.is_boolean())) expectNoCamera(key, bad);
    }
    expectNoCamera("name", "");
    expectNoCamera("name", 7);
    for (const char* key : {"width", "height"})
        for (const json& bad : {json(0), json(-64), json(16385), json(64.5), json("64"), json(1e300), json(-1e300),
                                json((std::int64_t{1} << 32) + 64), json(std::uint64_t{1} << 63)})
            expectNoCamera(key, bad);
    for (const char* key : {"fx", "fy"})
        for (const json& bad : {json(0), json(-50), json("50")})
            expectNoCamera(key, bad);
    expectNoCamera("cx", "32");
}

TEST_F(ViewFiles, CamerasOfOneNameAreRefused) { // else the pictures of one would replace those of the other
    const std::string failure = failureOf<Failure>([&] { cameras({kCamera, kCamera}); });
    expectRefused(failure, "twice the same");
    EXPECT_NE(failure.find("camera 1"), std::string::npos) << failure;
}

TEST_F(ViewFiles, NumbersThatAreNoneAreRefused) {
    for (const char* number : kNoNumbers) {
        for (const char* key : {"width", "fx", "cx"}) {
            json camera = kCamera;
            camera[key] = 12345;
            expectNoCameras(with({{"cameras", json::array({camera})}}, number));
        }
        json camera = kCamera;
        camera["world_from_camera"][3] = 12345;
        expectNoCameras(with({{"cameras", json::array({camera})}}, number));
        for (const char* key : {"position", "orientation"}) {
            json pose = kPose;
            pose[key][0] = 12345;
            expectNoPath(with({{"space", "walk"}, {"poses", json::array({pose})}}, number));
        }
        json pose = kPose;
        pose["t"] = 12345;
        expectNoPath(with({{"space", "walk"}, {"poses", json::array({pose})}}, number));
    }
}

TEST_F(ViewFiles, PosesThatAreNotRigidAreRefused) {
    const json& good = kCamera["world_from_camera"];
    json more = good, fewer = good, scaled = good, mirrored = good, projective = good, nested = json::array();
    more.push_back(0);
    fewer.erase(15);
    for (int i = 0; i < 12; ++i)
        if (i % 4 != 3) scaled[i] = 2 * scaled[i].get<double>();
    mirrored[2] = -1;
    projective[12] = 0.5;
    for (int row = 0; row < 4; ++row)
        nested.push_back({good[4 * row], good[4 * row + 1], good[4 * row + 2], good[4 * row + 3]});
    for (const json& bad : {more, fewer, scaled, mirrored, projective, nested, json("identity")})
        expectNoCamera("world_from_camera", bad);
}

TEST_F(ViewFiles, HeadsStandInTheirSpace) {
    // Walk space is the world turned by a quarter about x, and moved.
    const scene::Pose walkFromWorld{glm::dmat3(1, 0, 0, 0, 0, -1, 0, 1, 0), glm::dvec3(10, 20, 30)};
    const double half = std::sqrt(0.5);
    const json turned{{"t", 1}, {"position", {1, 2, 3}}, {"orientation", {0, half, 0, half}}}; // to the left
    for (const bool inWalk : {true, false}) {
        const std::vector<NamedView> views = poses({kPose, turned}, inWalk ? "walk" : "world", walkFromWorld);
        ASSERT_EQ(views.size(), 2u);
        EXPECT_EQ(views[0].name, "pose-0000");
        EXPECT_EQ(views[1].name, "pose-0001");
        EXPECT_EQ(views[0].seconds, 0.5);
        EXPECT_EQ(views[1].camera, kEye);
        const scene::Pose spaceFromCamera =
            inWalk ? walkFromWorld * views[1].worldFromCamera : views[1].worldFromCamera;
        const auto expectNear = [](const glm::dvec3& a, const glm::dvec3& b) {
            EXPECT_LT(glm::distance(a, b), 1e-12) << a.x << " " << a.y << " " << a.z;
        };
        expectNear(spaceFromCamera.translation, {1, 2, 3});
        expectNear(spaceFromCamera.rotation * glm::dvec3(0, 0, 1), {-1, 0, 0}); // ahead was -Z
        expectNear(spaceFromCamera.rotation * glm::dvec3(0, 1, 0), {0, -1, 0}); // down stays down
        expectNear(spaceFromCamera.rotation * glm::dvec3(1, 0, 0), {0, 0, -1}); // what was right is ahead
    }
}

TEST_F(ViewFiles, QuaternionsOfAnyLengthButNone) {
    const scene::Pose wanted = poses(json::array({kPose}))[0].worldFromCamera;
    for (const double length : {1e-5, 0.5, 2.0, -1.0, 1e150}) {
        json pose = kPose;
        pose["orientation"] = {0, 0, 0, length};
        const scene::Pose pose2 = poses(json::array({pose}))[0].worldFromCamera;
        for (int column = 0; column < 3; ++column)
            EXPECT_LT(glm::distance(pose2.rotation[column], wanted.rotation[column]), 1e-12) << length;
    }
    expectNoPose("orientation", {0, 0, 0, 0});
    expectNoPose("orientation", {1e-300, 0, 0, 0});
}

TEST_F(ViewFiles, PathsOfOtherTypesAreRefused) {
    for (const char* text : {"", "{", "null", "[]", "{}", R"({"space": "walk"})", R"({"space": "walk", "poses": []})",
                             R"({"space": "walk", "poses": 7})", R"({"space": "walk", "poses": [7]})",
                             R"({"space": "walk", "poses": [null]})", R"({"cameras": []})"})
        expectNoPath(text);
    expectNoPath(json{{"poses", json::array({kPose})}}.dump());
    for (const json& bad : {json("room"), json("Walk"), json(""), json(7), json(nullptr), json::array({"walk"})})
        expectNoPath(json{{"space", bad}, {"poses", json::array({kPose})}}.dump());
    for (const char* key : {"position", "orientation"}) {
        json pose = kPose;
        pose.erase(key);
        expectRefused(failureOf<Failure>([&] { poses(json::array({pose})); }), std::string("without ") + key);
        for (const json& bad : {json(nullptr), json(7), json("here"), json::object(), json::array({1, 2}),
                                json::array({1, 2, 3, 4, 5}), json::array({"1", "2", "3", "4"})})
            expectNoPose(key, bad);
    }
    expectRefused(failureOf<Failure>([&] { readPathFile(scratch_ / "views.json.no", {}, kEye); }), "no file");
    expectRefused(failureOf<Failure>([&] { readCamerasFile(scratch_ / "views.json.no"); }), "no file");
}

TEST_F(ViewFiles, TimeGoesOn) {
    json first = kPose, second = kPose;
    first.erase("t");
    EXPECT_EQ(poses(json::array({first}))[0].seconds, 0) << "a single place needs no time";
    second["t"] = 0.5;
    EXPECT_EQ(poses({kPose, second})[1].seconds, 0.5) << "two poses may share an instant";
    for (const json& bad : {json(0.4), json(-1), json("1"), json(nullptr), json(true)})
        expectNoPose("t", bad);
}

} // namespace
} // namespace app
