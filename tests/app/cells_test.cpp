// Walk cells through the built program: positions that chose themselves in a building with a corner, a walk that draws
// only what is about the walker and never jumps, and the cells shown over the pictures.

#include "scene/plan/walk_cells.h"

#include "tests/app/comparison.h"
#include "tests/app/program.h"
#include "tests/scene/scratch_folder.h"

#include <array>
#include <cmath>
#include <cstdio>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace app {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// Two corridors, 3 m wide and high, that meet at a right angle: along x from 0 to 12, along z from 0 to 9; floor at 0.
/// All is chequered, so that images taken from different places differ in detail.
void writeCorner(const std::filesystem::path& path) {
    scene::writeFile(path.parent_path() / "corner.mtl", "newmtl light\nKd 0.9 0.7 0.4\nnewmtl dark\nKd 0.1 0.2 0.5\n");
    constexpr float kSquare = 0.375f;
    std::string text = "mtllib corner.mtl\n";
    int count = 0;
    const auto wall = [&](glm::vec3 corner, glm::vec3 u, glm::vec3 v) {
        const int across = static_cast<int>(glm::length(u) / kSquare),
                  down = static_cast<int>(glm::length(v) / kSquare);
        u /= static_cast<float>(across), v /= static_cast<float>(down);
        for (int i = 0; i < across; ++i)
            for (int k = 0; k < down; ++k) {
                const glm::vec3 a = corner + static_cast<float>(i) * u + static_cast<float>(k) * v;
                text += (i + k) % 2 == 0 ? "usemtl light\n" : "usemtl dark\n";
                for (const glm::vec3& p : {a, a + u, a + u + v, a + v})
                    text += "v " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
                text += "f " + std::to_string(count + 1) + " " + std::to_string(count + 2) + " " +
                        std::to_string(count + 3) + " " + std::to_string(count + 4) + "\n";
                count += 4;
            }
    };
    const glm::vec3 up{0, 3, 0}, x{1, 0, 0}, z{0, 0, 1};
    wall({0, 0, 0}, 3.0f * z, 12.0f * x), wall({0, 0, 3}, 6.0f * z, 3.0f * x); // floor
    wall({0, 3, 0}, 12.0f * x, 3.0f * z), wall({0, 3, 3}, 3.0f * x, 6.0f * z);
    wall({0, 0, 0}, 12.0f * x, up), wall({12, 0, 0}, 3.0f * z, up), wall({12, 0, 3}, -9.0f * x, up);
    wall({3, 0, 3}, 6.0f * z, up), wall({3, 0, 9}, -3.0f * x, up), wall({0, 0, 9}, -9.0f * z, up);
    scene::writeFile(path, text);
}

/// From a to b in so many steps, ahead along x.
void writePath(const std::filesystem::path& path, const glm::dvec3& a, const glm::dvec3& b, int steps) {
    json poses = json::array();
    for (int i = 0; i <= steps; ++i) {
        const glm::dvec3 p = a + (b - a) * (static_cast<double>(i) / steps);
        poses.push_back(
            {{"t", i / 90.0}, {"position", {p.x, p.y, p.z}}, {"orientation", {0, -0.70710678, 0, 0.70710678}}});
    }
    scene::writeFile(path, json{{"space", "world"}, {"poses", poses}}.dump());
}

class Cells : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        scratch_ = new scene::ScratchFolder;
        writeCorner(*scratch_ / "corner.obj");
        built_ = run({kRevisit, "build", (*scratch_ / "corner.obj").string(), "-o", (*scratch_ / "s").string(),
                      "--positions", "auto", "--count", "9", "--face-size", "96", "--light-rays", "16", "--no-cull"},
                     scratch_->path());
        ASSERT_EQ(built_.status, 0) << built_.output;
    }
    static void TearDownTestSuite() {
        delete scratch_;
        scratch_ = nullptr;
    }

    static json drawn(const std::string& out, const std::vector<std::string>& further) {
        std::vector<std::string> command{kRevisit,
                                         "render",
                                         (*scratch_ / "s").string(),
                                         "--out",
                                         (*scratch_ / out).string(),
                                         "--path",
                                         (*scratch_ / "path.json").string(),
                                         "--size",
                                         "160x120",
                                         "--aux"};
        command.insert(command.end(), further.begin(), further.end());
        const Outcome outcome = run(command, scratch_->path());
        EXPECT_EQ(outcome.status, 0) << outcome.output;
        return outcome.status == 0 ? readJson(*scratch_ / out / "report.json") : json();
    }
    static cv::Mat3b picture(const std::string& out, int pose, const std::string& eye = "left") {
        char name[64];
        std::snprintf(name, sizeof name, "pose-%04d-%s.png", pose, eye.c_str());
        return cv::imread((*scratch_ / out / name).string());
    }

    static inline scene::ScratchFolder* scratch_ = nullptr;
    static inline Outcome built_;
};

TEST_F(Cells, PositionsChooseThemselvesUntilBothArmsAreKnown) {
    const json polygons = readJson(*scratch_ / "s/scene.json").at("polygons");
    const auto shares = polygons.at("unknown_shares").get<std::vector<double>>();
    ASSERT_GE(shares.size(), 2u);
    EXPECT_EQ(shares.size(), polygons.at("positions").size());
    EXPECT_LE(shares.back(), 0.02);
    bool isInLong = false, isInShort = false;
    for (const json& p : polygons.at("positions")) {
        isInLong = isInLong || p[0] > 3.0;
        isInShort = isInShort || p[2] > 3.0;
    }
    EXPECT_TRUE(isInLong && isInShort);
    EXPECT_THAT(run({kRevisit, "info", (*scratch_ / "s").string()}, scratch_->path()).output,
                HasSubstr("searched for"));
}

TEST_F(Cells, OnlyWhatIsAboutTheWalkerIsDrawnAndLooksTheSame) {
    writePath(*scratch_ / "path.json", {1.5, 1.6, 1.5}, {10, 1.6, 1.4}, 6);
    const json by = drawn("by", {}), all = drawn("all", {"--walk-cells", "false"});
    EXPECT_LE(by.at("samples_drawn").at("median").get<double>(),
              0.85 * all.at("samples_drawn").at("median").get<double>());
    for (int pose = 0; pose <= 6; ++pose)
        for (const char* eye : {"left", "right"}) {
            const cv::Mat3b a = picture("by", pose, eye), b = picture("all", pose, eye);
            ASSERT_FALSE(a.empty() || b.empty());
            // Chequers of full contrast in small images: what stands a pixel beside is another colour.
            EXPECT_GE(psnr(a, b, cv::Mat1b(a.size(), std::uint8_t{1})), 20) << pose << " " << eye;
        }
}

/// Where along a line through the corridor images are half there, that are neither before nor after.
double findCrossing(const json& positions, double from, double to, double z) {
    std::vector<glm::dvec3> places;
    for (const json& p : positions)
        places.push_back({p[0].get<double>(), p[1].get<double>(), p[2].get<double>()});
    const scene::WalkCells cells(places);
    std::uint32_t cell = 0;
    std::vector<scene::PositionShare> shares;
    for (double x = from; x < to; x += 0.001) {
        cells.sharesAt({x, 1.6, z}, cell, shares);
        for (const scene::PositionShare& share : shares)
            if (std::abs(share.share - 0.5f) < 0.01f) return x;
    }
    return std::nan("");
}

/// The mean over the picture, and the share of pixels that differ visibly from those before.
TEST_F(Cells, NothingJumpsInStepsOfAMillimetre) {
    constexpr int kSteps = 160;
    const json positions = readJson(*scratch_ / "s/scene.json").at("polygons").at("positions");
    const double crossing = findCrossing(positions, 1, 11, 1.5);
    ASSERT_TRUE(std::isfinite(crossing)) << "no image comes or goes along the corridor";
    writePath(*scratch_ / "path.json", {crossing - 0.08, 1.6, 1.5}, {crossing + 0.08, 1.6, 1.5}, kSteps);
    drawn("slowly", {"--eyes", "1", "--warp", "points"});
    drawn("slowly-all", {"--eyes", "1", "--warp", "points", "--walk-cells", "false"});
    const auto nameOf = [](const std::string& out, int pose) {
        char name[64];
        std::snprintf(name, sizeof name, "pose-%04d.png", pose);
        return (*scratch_ / out / name).string();
    };
    const auto jumpsOf = [&](const std::string& out) {
        double mean = 0, changed = 0;
        cv::Mat3b before;
        for (int pose = 0; pose <= kSteps; ++pose) {
            const cv::Mat3b now = cv::imread(nameOf(out, pose));
            EXPECT_FALSE(now.empty());
            if (!before.empty()) {
                mean = std::max(mean, cv::norm(cv::mean(now) - cv::mean(before), cv::NORM_INF));
                cv::Mat difference;
                cv::absdiff(now, before, difference);
                std::vector<cv::Mat> channels;
                cv::split(difference, channels);
                const cv::Mat most = cv::max(cv::max(channels[0], channels[1]), channels[2]);
                changed = std::max(changed, cv::countNonZero(most > 24) / static_cast<double>(most.total()));
            }
            before = now;
        }
        return std::array{mean, changed};
    };
    const auto by = jumpsOf("slowly"), all = jumpsOf("slowly-all");
    std::printf(
        "in steps of 1 mm: mean colour changes by %.3f at most (all images: %.3f), %.4f of the pixels by more than 24 "
        "(%.4f)\n",
        by[0], all[0], by[1], all[1]);
    // What the warp itself changes, and of the images that come and go kShareSlope / spacing a metre: under a
    // hundredth.
    EXPECT_LE(by[0], all[0] + 0.5);
    EXPECT_LE(by[1], all[1] + 0.02);
}

TEST_F(Cells, AreShownOverThePictures) {
    writePath(*scratch_ / "path.json", {1.5, 1.6, 1.5}, {2.5, 1.6, 1.5}, 1);
    drawn("plain", {});
    drawn("shown", {"--overlay", "cells"});
    for (const char* eye : {"left", "right"})
        EXPECT_GT(cv::norm(picture("plain", 0, eye), picture("shown", 0, eye), cv::NORM_L1), 10'000);
    for (const char* what : {"depth.tiff", "class.png"})
        EXPECT_EQ(scene::bytesOfFile(*scratch_ / "plain" / (std::string("pose-0000-left-") + what)),
                  scene::bytesOfFile(*scratch_ / "shown" / (std::string("pose-0000-left-") + what)))
            << "nobody measured the lines";
}

TEST_F(Cells, WhereThereAreNoneOneLineSaysSo) {
    const std::string scene = (*scratch_ / "culled").string();
    const Outcome built = run({kRevisit, "build", (*scratch_ / "corner.obj").string(), "-o", scene, "--positions", "2",
                               "--face-size", "32", "--light-rays", "4"},
                              scratch_->path());
    ASSERT_EQ(built.status, 0) << built.output;
    writePath(*scratch_ / "path.json", {1.5, 1.6, 1.5}, {2.5, 1.6, 1.5}, 1);
    const Outcome outcome = run({kRevisit, "render", scene, "--out", (*scratch_ / "none").string(), "--path",
                                 (*scratch_ / "path.json").string(), "--overlay", "cells"},
                                scratch_->path());
    EXPECT_EQ(outcome.status, 1);
    EXPECT_THAT(outcome.output, HasSubstr("no walk cells"));
    EXPECT_EQ(run({kRevisit, "render", scene, "--out", "x", "--overlay", "clouds"}, scratch_->path()).status, 2);
}

} // namespace
} // namespace app
