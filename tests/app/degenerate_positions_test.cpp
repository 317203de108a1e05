// Positions that lie as no triangulation likes them: each set is built, its cells are what they must be, and one walks
// through them without a display, seeing surface everywhere.

#include "tests/app/comparison.h"
#include "tests/app/program.h"
#include "tests/app/written_room.h"
#include "tests/scene/scratch_folder.h"

#include "scene/plan/walk_cells.h"

#include <cmath>
#include <numbers>
#include <span>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

namespace app {
namespace {

using nlohmann::json;

using Places = std::vector<glm::dvec3>;

/// Of all pixels of all pictures, those with surface. The room has no ceiling: one looks level.
double seenShare(const std::filesystem::path& folder) {
    double seen = 0, all = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        if (!entry.path().filename().string().ends_with("-class.png")) continue;
        const cv::Mat1b classes = cv::imread(entry.path().string(), cv::IMREAD_GRAYSCALE);
        seen += cv::countNonZero(classes), all += static_cast<double>(classes.total());
    }
    return all > 0 ? seen / all : 0;
}

/// Builds the room from these positions, walks along it (middle of the floor given), and looks at what was seen.
void buildAndWalk(const Places& places, int dimension, const glm::dvec3& middle = glm::dvec3(0)) {
    // From one place alone the pillar hides a part of the room.
    const double leastShare = dimension == 0 ? 0.85 : 0.9;
    const scene::ScratchFolder scratch;
    writeRoom(scratch / "room.obj", middle);
    json positions = json::array(), poses = json::array();
    for (const glm::dvec3& p : places)
        positions.push_back({p.x + middle.x, p.y + middle.y, p.z + middle.z});
    scene::writeFile(scratch / "positions.json", json{{"positions", positions}}.dump());
    // Through the positions and past them, looking ahead.
    for (int i = 0; i <= 4; ++i)
        poses.push_back({{"t", 0.25 * i},
                         {"position", {middle.x - 2 + 0.5 * i, middle.y + 1.5, middle.z + 3 - 1.2 * i}},
                         {"orientation", {0, 0, 0, 1}}});
    scene::writeFile(scratch / "path.json", json{{"space", "world"}, {"poses", poses}}.dump());
    const Outcome built =
        run({kRevisit, "build", (scratch / "room.obj").string(), "-o", (scratch / "s").string(), "--positions",
             (scratch / "positions.json").string(), "--no-cull", "--face-size", "24", "--light-rays", "1"},
            scratch.path());
    ASSERT_EQ(built.status, 0) << built.output;
    EXPECT_EQ(readJson(scratch / "s/scene.json").at("polygons").at("positions").size(), places.size());
    EXPECT_EQ(scene::WalkCells(places).dimension(), dimension);
    const Outcome walked = run({kRevisit, "walk", (scratch / "s").string(), "--headless", "--path",
                                (scratch / "path.json").string(), "--rate", "10", "--out", (scratch / "w").string()},
                               scratch.path());
    EXPECT_EQ(walked.status, 0) << walked.output;
    const Outcome drawn = run({kRevisit, "render", (scratch / "s").string(), "--path", (scratch / "path.json").string(),
                               "--out", (scratch / "frames").string(), "--aux", "--warp", "mesh", "--size", "160x60"},
                              scratch.path());
    ASSERT_EQ(drawn.status, 0) << drawn.output;
    const double share = seenShare(scratch / "frames");
    std::printf("%.2f %% seen\n", 100 * share);
    EXPECT_GE(share, leastShare);
}

constexpr int kMany = 50;

TEST(DegeneratePositions, One) {
    buildAndWalk({{-1, 1.6, 2}}, 0);
}

TEST(DegeneratePositions, Two) {
    buildAndWalk({{-1, 1.6, 2}, {-0.5, 1.6, -1}}, 1);
}

TEST(DegeneratePositions, Three) {
    buildAndWalk({{-1, 1.6, 2}, {-0.5, 1.6, -1}, {-2, 1.5, 0}}, 2);
}

TEST(DegeneratePositions, FiftyInALine) {
    Places places;
    for (int i = 0; i < kMany; ++i)
        places.emplace_back(-2 + 0.025 * i, 1.5, 3 - 0.1 * i);
    buildAndWalk(places, 1);
}

TEST(DegeneratePositions, FiftyInAPlane) {
    Places places;
    for (int i = 0; i < kMany; ++i)
        places.emplace_back(-2.5 + 0.25 * (i % 10), 1.6, -2 + 0.5 * (i / 10.0));
    buildAndWalk(places, 2);
}

TEST(DegeneratePositions, FiftyOnASphere) {
    Places places;
    for (int i = 0; i < kMany; ++i) {
        const double y = 1 - 2 * (i + 0.5) / kMany, turn = i * std::numbers::pi * (3 - std::sqrt(5.0));
        const double r = std::sqrt(1 - y * y);
        places.push_back(glm::dvec3(-1.2, 1.5, 0) + glm::dvec3(r * std::cos(turn), y, r * std::sin(turn)));
    }
    buildAndWalk(places, 3);
}

TEST(DegeneratePositions, AllTheSame) {
    buildAndWalk(Places(kMany, glm::dvec3(-1, 1.6, 2)), 0);
}

TEST(DegeneratePositions, AThousandKilometresAway) {
    buildAndWalk({{-1, 1.6, 2}, {-0.5, 1.6, -1}, {-2, 1.5, 0}, {-1.5, 2.2, 0.5}}, 3, glm::dvec3(1e6, 0, -1e6));
}

} // namespace
} // namespace app
