// Polygons through the built program: what a walker sees of a ray-traced room, and what the world may do to a build.

#include "scene/camera_json.h"
#include "scene/capture/polygon_view.h"
#include "scene/import/polygons.h"

#include "tests/app/comparison.h"
#include "tests/app/program.h"
#include "tests/app/written_room.h"
#include "tests/scene/scratch_folder.h"
#include "tests/shared_data.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

namespace app {
namespace {

using nlohmann::json;
using scene::ScratchFolder;
using scene::writeFile;
using testing::HasSubstr;

Outcome build(const std::filesystem::path& polygons, const std::filesystem::path& output,
              const std::vector<std::string>& further, const ScratchFolder& scratch) {
    std::vector<std::string> command{kRevisit,      "build", polygons.string(), "-o", output.string(),
                                     "--face-size", "48",    "--light-rays",    "16"};
    command.insert(command.end(), further.begin(), further.end());
    return run(command, scratch.path());
}

TEST(PolygonsBuild, AWalkBeginsOnTheFloorUpright) {
    const ScratchFolder scratch;
    writeRoom(scratch / "room.obj");
    writeFile(scratch / "p.json", R"({"positions": [[-1, 1.25, 2], [-1, 1.6, -2]]})");
    const Outcome built = build(scratch / "room.obj", scratch / "s", {"--positions", scratch / "p.json"}, scratch);
    ASSERT_EQ(built.status, 0) << built.output;
    const json scene = readJson(scratch / "s/scene.json");
    const auto walk = scene.at("walk_from_world").get<std::vector<double>>();
    // From (-1, 2) one sees farthest ahead, along -Z; the floor is 1.25 m below.
    const std::vector<double> expected{1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, -2, 0, 0, 0, 1};
    ASSERT_EQ(walk.size(), expected.size());
    for (std::size_t i = 0; i < walk.size(); ++i)
        EXPECT_NEAR(walk[i], expected[i], 1e-6) << i;
    ASSERT_EQ(scene.at("images").size(), 12u);
    EXPECT_EQ(scene.at("images")[0].at("name"), "p000-front");
    EXPECT_EQ(scene.at("images")[11].at("name"), "p001-down");
    EXPECT_EQ(scene.at("polygons").at("triangles"), 20);
    EXPECT_EQ(scene.at("polygons").at("positions").size(), 2u);
    const Outcome info = run({kRevisit, "info", (scratch / "s").string()}, scratch.path());
    EXPECT_THAT(info.output, HasSubstr("20 triangles from 2 positions"));
}

TEST(PolygonsBuild, AWalkLooksWhereThereIsMostToSee) {
    const ScratchFolder scratch;
    writeRoom(scratch / "room.obj");
    writeFile(scratch / "p.json", R"({"positions": [[-1, 1.6, -3]]})");
    const Outcome built = build(scratch / "room.obj", scratch / "s", {"--positions", scratch / "p.json"}, scratch);
    ASSERT_EQ(built.status, 0) << built.output;
    const auto walk = readJson(scratch / "s/scene.json").at("walk_from_world").get<std::vector<double>>();
    EXPECT_NEAR(walk[10], -1, 1e-9) << "back along +Z, which is ahead of the walker";
    EXPECT_NEAR(walk[0], -1, 1e-9);
    EXPECT_NEAR(walk[5], 1, 1e-9);
}

TEST(PolygonsBuild, TheSameBytesOnOneThreadAndTwoAndAfterAStop) {
    const ScratchFolder scratch;
    writeRoom(scratch / "room.obj");
    const auto builtWith = [&](const std::string& name, const std::string& positions, const std::string& threads) {
        const Outcome built =
            build(scratch / "room.obj", scratch / name, {"--positions", positions, "--threads", threads}, scratch);
        EXPECT_EQ(built.status, 0) << built.output;
        return built.output;
    };
    writeFile(scratch / "one.json", R"({"positions": [[-1, 1.6, 2]]})");
    writeFile(scratch / "two.json", R"({"positions": [[-1, 1.6, 2], [-1, 1.6, -2]]})");
    builtWith("a", scratch / "two.json", "1");
    builtWith("b", scratch / "two.json", "2");
    // A build that was killed after the first position has left just what this one leaves.
    builtWith("c", scratch / "one.json", "2");
    const auto timesOf = [&] {
        std::map<std::string, std::filesystem::file_time_type> times;
        for (const auto& entry : std::filesystem::recursive_directory_iterator(scratch / "c.build"))
            if (entry.is_regular_file() && entry.path().string().find("position-") != std::string::npos)
                times[entry.path().string()] = entry.last_write_time();
        return times;
    };
    const auto before = timesOf();
    ASSERT_GE(before.size(), 6u);
    builtWith("c", scratch / "two.json", "2");
    EXPECT_EQ(filesOf(scratch / "a"), filesOf(scratch / "b"));
    EXPECT_EQ(filesOf(scratch / "a"), filesOf(scratch / "c"));
    const auto after = timesOf();
    EXPECT_EQ(after.size(), 2 * before.size());
    EXPECT_TRUE(std::includes(after.begin(), after.end(), before.begin(), before.end())) << "the first was traced anew";
}

TEST(PolygonsBuild, WrongWishesAreToldInOneLine) {
    const ScratchFolder scratch;
    writeRoom(scratch / "room.obj");
    writeFile(scratch / "solid.json", R"({"positions": [[-1, 1.6, 2], [1, 1.5, 1]]})");
    writeFile(scratch / "points.obj", "v 0 0 0\nv 1 0 0\n");
    const auto outcome = [&](const std::string& file, const std::vector<std::string>& further) {
        const Outcome built = build(scratch / file, scratch / "s", further, scratch);
        EXPECT_FALSE(std::filesystem::exists(scratch / "s"));
        return std::pair(built.status, built.output);
    };
    using testing::Pair;
    EXPECT_THAT(outcome("room.obj", {"--positions", "0"}), Pair(2, HasSubstr("no count")));
    EXPECT_THAT(outcome("room.obj", {"--positions", "-4"}), Pair(2, HasSubstr("no count")));
    EXPECT_THAT(outcome("room.obj", {"--positions", "3", "--face-size", "3"}), Pair(2, HasSubstr("--face-size")));
    EXPECT_THAT(outcome("room.obj", {}), Pair(1, HasSubstr("--positions 8")));
    EXPECT_THAT(outcome("room.obj", {"--positions", "2", "--count", "4"}), Pair(1, HasSubstr("--positions auto")));
    EXPECT_THAT(outcome("room.obj", {"--positions", "2", "--hold-out", "every:2:0"}),
                Pair(1, HasSubstr("photographs")));
    EXPECT_THAT(outcome("room.obj", {"--positions", scratch / "none.json"}), Pair(1, HasSubstr("no such file")));
    EXPECT_THAT(outcome("room.obj", {"--positions", scratch / "solid.json"}),
                Pair(1, HasSubstr("position 1 (1 1.5 1) is inside a solid")));
    EXPECT_THAT(outcome("points.obj", {"--positions", "2"}), Pair(1, HasSubstr("points.obj")));
}

TEST(PolygonsBuild, OtherPolygonsStandInTheSceneAsWhatNobodyMeasured) {
    const ScratchFolder scratch;
    writeRoom(scratch / "room.obj");
    writeFile(scratch / "at.json", R"({"positions": [[-1, 1.6, 2]]})");
    const Outcome built = build(scratch / "room.obj", scratch / "s", {"--positions", scratch / "at.json"}, scratch);
    ASSERT_EQ(built.status, 0) << built.output;
    // A board across the room, 2 m from the eye; and behind the wall, where nobody sees it.
    writeFile(scratch / "board.obj", "v -2 1 0\nv 0 1 0\nv 0 2 0\nv -2 2 0\nf 1 2 3 4\n"
                                     "v -3 0 -9\nv 3 0 -9\nv 3 3 -9\nv -3 3 -9\nf 5 6 7 8\n");
    const scene::View view{{160, 120, 120, 120, 80, 60}, {glm::dmat3(1, 0, 0, 0, -1, 0, 0, 0, -1), {-1, 1.6, 2}}};
    writeFile(scratch / "cameras.json",
              json{{"cameras", {scene::describeCamera("v", view.camera, view.worldFromEye)}}}.dump());
    const auto draw = [&](const std::string& polygons, const std::string& edgeSamples = "1") {
        return run({kRevisit, "render", (scratch / "s").string(), "--out", (scratch / "frames").string(), "--cameras",
                    (scratch / "cameras.json").string(), "--aux", "--polygons", (scratch / polygons).string(),
                    "--edge-samples", edgeSamples},
                   scratch.path());
    };
    const Outcome drawn = draw("board.obj");
    ASSERT_EQ(drawn.status, 0) << drawn.output;
    const cv::Mat1b classes = cv::imread((scratch / "frames/v-class.png").string(), cv::IMREAD_GRAYSCALE);
    const cv::Mat1f depths = cv::imread((scratch / "frames/v-depth.tiff").string(), cv::IMREAD_UNCHANGED);
    for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 160; ++x) {
            const glm::dvec3 p = view.worldFromEye * (2.0 * scene::rayThrough(view.camera, x + 0.5, y + 0.5));
            const double inside = std::min({p.x + 2, -p.x, p.y - 1, 2 - p.y});
            if (std::abs(inside) < 0.03) continue;
            const bool isBoard = classes(y, x) == 2 && std::abs(depths(y, x) - 2) < 1e-4;
            ASSERT_EQ(isBoard, inside > 0) << x << " " << y; // holes of the room are filled, too
        }
    EXPECT_EQ(readJson(scratch / "frames/report.json").at("triangles_drawn").at("median"), 4);
    const Outcome smooth = draw("board.obj", "3"); // no device has three
    EXPECT_EQ(smooth.status, 0) << smooth.output;
    EXPECT_THAT(smooth.output, HasSubstr("of a pixel, the most up to 3 that "));
    const cv::Mat1b smoothClasses = cv::imread((scratch / "frames/v-class.png").string(), cv::IMREAD_GRAYSCALE);
    EXPECT_LT(cv::countNonZero(smoothClasses != classes), 400) << "along edges alone";
    EXPECT_THAT(draw("board.obj", "9").output, HasSubstr("1 to 8"));
    const Outcome missing = draw("none.obj");
    EXPECT_EQ(missing.status, 1);
    EXPECT_THAT(missing.output, HasSubstr("none.obj: no such file"));
}

/// Looks from a place at another, as a walker does.
scene::View viewFrom(const glm::dvec3& eye, const glm::dvec3& at) {
    const glm::dvec3 forward = glm::normalize(at - eye);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 1, 0)));
    return {{320, 240, 200, 200, 160, 120}, {glm::dmat3(right, glm::cross(forward, right), forward), eye}};
}

TEST(PolygonsBuild, TheFireplaceRoomFromBetweenItsPositions) {
    const std::filesystem::path polygons = tests::dataFolder() / "fireplace_room/fireplace.obj";
    if (!std::filesystem::exists(polygons)) GTEST_SKIP() << "because there is no " << polygons;
    const ScratchFolder scratch;
    const Outcome built = run({kRevisit, "build", polygons.string(), "-o", (scratch / "s").string(), "--positions", "3",
                               "--face-size", "128", "--light-rays", "32"},
                              scratch.path());
    ASSERT_EQ(built.status, 0) << built.output;

    const json places = readJson(scratch / "s/scene.json").at("polygons").at("positions");
    ASSERT_EQ(places.size(), 3u);
    glm::dvec3 middle(0);
    for (const json& p : places)
        middle += glm::dvec3(p[0].get<double>(), p[1].get<double>(), p[2].get<double>()) / 3.0;
    const std::vector<scene::View> views{viewFrom(middle, middle + glm::dvec3(1, -0.2, 0.3)),
                                         viewFrom(middle, middle + glm::dvec3(-0.8, -0.1, -1))};
    json cameras = json::array();
    for (std::size_t i = 0; i < views.size(); ++i)
        cameras.push_back(scene::describeCamera("v" + std::to_string(i), views[i].camera, views[i].worldFromEye));
    writeFile(scratch / "cameras.json", json{{"cameras", cameras}}.dump());
    const Outcome drawn = run({kRevisit, "render", (scratch / "s").string(), "--out", (scratch / "frames").string(),
                               "--cameras", (scratch / "cameras.json").string(), "--aux", "--warp", "mesh"},
                              scratch.path());
    ASSERT_EQ(drawn.status, 0) << drawn.output;

    const scene::PolygonScene scene = scene::readPolygons(polygons);
    const scene::PolygonTracer tracer(scene);
    scene::CaptureLight options;
    options.rays = 32;
    const scene::SurfaceLight light(tracer, options);
    for (std::size_t i = 0; i < views.size(); ++i) {
        const scene::DepthImage truth = renderPolygons(tracer, light, views[i]);
        cv::Mat3b colours(truth.camera.height, truth.camera.width);
        for (int y = 0; y < colours.rows; ++y)
            for (int x = 0; x < colours.cols; ++x) {
                const scene::Rgb8 c = truth.colour(x, y);
                colours(y, x) = {c.b, c.g, c.r};
            }
        const std::string name = (scratch / "frames").string() + "/v" + std::to_string(i);
        const cv::Mat3b frame = cv::imread(name + ".png");
        const cv::Mat1b seen(cv::imread(name + "-class.png", cv::IMREAD_GRAYSCALE) == 1);
        ASSERT_EQ(frame.size(), colours.size());
        const double decibels = psnr(frame, colours, seen);
        const double share = static_cast<double>(cv::countNonZero(seen)) / static_cast<double>(seen.total());
        std::printf("fireplace room, view %zu: %.2f dB, %.1f %% seen\n", i, decibels, 100 * share);
        EXPECT_GE(decibels, 32);
        EXPECT_GE(share, 0.85);
    }
}

} // namespace
} // namespace app
