// revisit plan as a user runs it: a scan of a room with a hidden corner, from a file to proposals and a picture; and
// what it says where it cannot.

#include "scene/synthetic.h"
#include "scene/synthetic_model.h"

#include "tests/app/program.h"
#include "tests/scene/scratch_folder.h"

#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

namespace app {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr double kFar[] = {5.3, 3.2}; ///< x and y at which the hidden corner begins

/// A room of 8 x 6 x 2.8 m with a wall that hides a corner; scanned from (2, 4). One cloud, column by column.
void writeScan(const std::filesystem::path& path) {
    scene::SyntheticModel model;
    model.name = "hidden corner";
    model.lightSpacing = 2;
    const int material = scene::addMaterial(model, {});
    const auto box = [&](const glm::dvec3& low, const glm::dvec3& high) {
        scene::addBox(model, {}, low, high, material);
    };
    box({-1, -1, -1}, {9, 7, 0}), box({-1, -1, 2.8}, {9, 7, 3.8});
    box({-1, -1, 0}, {0, 7, 2.8}), box({8, -1, 0}, {9, 7, 2.8});
    box({0, -1, 0}, {8, 0, 2.8}), box({0, 6, 0}, {8, 7, 2.8});
    box({5.0, 2.6, 0}, {5.2, 6, 2.8});
    const scene::SyntheticScene place(std::move(model));
    constexpr int kColumns = 480, kRows = 200;
    const scene::Scan scan =
        scene::simulateScan(place, {glm::dmat3(1), {2, 4, 1.5}}, kColumns, kRows, {.withColour = false});
    std::vector<std::string> cells(static_cast<std::size_t>(kColumns) * kRows, "0 0 0 0\n");
    for (std::size_t i = 0; i < scan.pointsInScanner.size(); ++i) {
        const glm::vec3& p = scan.pointsInScanner[i];
        char text[80];
        std::snprintf(text, sizeof text, "%.6f %.6f %.6f 0.5\n", static_cast<double>(p.x), static_cast<double>(p.y),
                      static_cast<double>(p.z));
        cells[static_cast<std::size_t>(scan.column[i]) * kRows + static_cast<std::size_t>(scan.row[i])] = text;
    }
    std::ofstream file(path);
    file << kColumns << "\n" << kRows << "\n2 4 1.5\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n2 4 1.5 1\n";
    for (const std::string& cell : cells)
        file << cell;
}

class Plan : public testing::Test {
  protected:
    std::string at(const char* name) const { return (scratch_ / name).string(); }
    Outcome revisit(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), kRevisit);
        return run(arguments, scratch_.path());
    }
    void build(const std::vector<std::string>& options) {
        writeScan(scratch_ / "scan.ptx");
        std::vector<std::string> command{"build", at("scan.ptx"), "-o", at("room.revisit")};
        command.insert(command.end(), options.begin(), options.end());
        const Outcome outcome = revisit(command);
        ASSERT_EQ(outcome.status, 0) << outcome.output;
    }
    scene::ScratchFolder scratch_;
};

TEST_F(Plan, SaysWhereToStandAndDrawsIt) {
    build({"--coverage"});
    const Outcome outcome = revisit({"plan", at("room.revisit"), "--out", at("plan.json"), "--count", "2"});
    ASSERT_EQ(outcome.status, 0) << outcome.output;
    EXPECT_THAT(outcome.output, HasSubstr("should reveal"));
    std::ifstream file(at("plan.json"));
    const json plan = json::parse(file);
    EXPECT_EQ(plan.at("revisit"), "plan");
    EXPECT_EQ(plan.at("scene"), at("room.revisit"));
    EXPECT_EQ(plan.at("stood").size(), 1u);
    EXPECT_GT(plan.at("candidates").get<int>(), 10);
    ASSERT_GE(plan.at("positions").size(), 1u);
    ASSERT_LE(plan.at("positions").size(), 2u);
    const json& first = plan.at("positions").at(0);
    EXPECT_GT(first.at("reveals_share").get<double>(), 0.5);
    EXPECT_NEAR(first.at("reveals_m3").get<double>() / plan.at("unseen_m3").get<double>(),
                first.at("reveals_share").get<double>(), 1e-9);
    const auto x = first.at("position").at(0).get<double>(), y = first.at("position").at(1).get<double>();
    EXPECT_NEAR(first.at("position").at(2).get<double>(), 1.5, 0.1);
    EXPECT_NEAR(first.at("walk").at(1).get<double>(), 1.5, 0.1);
    EXPECT_TRUE(x > kFar[0] || y < kFar[1]) << "no place from which the corner is seen: " << x << " " << y;

    const cv::Mat picture = cv::imread(at("plan.png"));
    ASSERT_FALSE(picture.empty());
    int unseen = 0, empty = 0, next = 0, stood = 0;
    const auto isNear = [](const cv::Vec3b& pixel, int b, int g, int r) {
        return std::abs(pixel[0] - b) + std::abs(pixel[1] - g) + std::abs(pixel[2] - r) < 12;
    };
    for (int row = 0; row < picture.rows - 110; ++row) // not the legend
        for (int column = 0; column < picture.cols; ++column) {
            const cv::Vec3b& pixel = picture.at<cv::Vec3b>(row, column);
            unseen += isNear(pixel, 104, 172, 246) ? 1 : 0, empty += isNear(pixel, 236, 244, 247) ? 1 : 0;
            next += isNear(pixel, 40, 40, 205) ? 1 : 0, stood += isNear(pixel, 150, 84, 24) ? 1 : 0;
        }
    EXPECT_NEAR(unseen / static_cast<double>(unseen + empty), 0.25, 0.1) << "the corner's share of the ground";
    EXPECT_GT(next, 300);
    EXPECT_GT(stood, 100);

    // Once more it is put in the place of what it was; a picture of another hand, whose name nobody gave, is not.
    EXPECT_EQ(revisit({"plan", at("room.revisit"), "--out", at("plan.json")}).status, 0);
    EXPECT_EQ(revisit({"plan", at("room.revisit"), "--out", at("tmp.a")}).status, 0);
    EXPECT_EQ(revisit({"plan", at("room.revisit"), "--out", at("tmp.b")}).status, 0);
    EXPECT_TRUE(std::filesystem::exists(at("tmp.a.png")) && std::filesystem::exists(at("tmp.b.png")));
    std::ofstream(at("site.png")) << "of another hand";
    const Outcome refused = revisit({"plan", at("room.revisit"), "--out", at("site.json")});
    EXPECT_EQ(refused.status, 1);
    EXPECT_THAT(refused.output, HasSubstr("no plan of that name speaks of it"));
    EXPECT_EQ(std::filesystem::file_size(at("site.png")), 15u);
}

TEST_F(Plan, SaysWhatIsMissing) {
    build({});
    const Outcome none = revisit({"plan", at("room.revisit"), "--out", at("plan.json")});
    EXPECT_EQ(none.status, 1);
    EXPECT_EQ(none.output,
              "revisit: " + at("room.revisit") +
                  ": does not say what was never observed; build it again with 'revisit build --coverage'\n");
    EXPECT_FALSE(std::filesystem::exists(at("plan.json")));
    const auto failureOf = [&](const std::vector<std::string>& arguments, int status) {
        const Outcome outcome = revisit(arguments);
        EXPECT_EQ(outcome.status, status) << outcome.output;
        return outcome.output;
    };
    EXPECT_THAT(failureOf({"plan", at("nothing.revisit"), "--out", at("plan.json")}, 1), HasSubstr("nothing.revisit"));
    EXPECT_THAT(failureOf({"plan", at("room.revisit"), "--out", scratch_.path().string()}, 1),
                HasSubstr("is a folder"));
    EXPECT_THAT(failureOf({"plan", at("room.revisit"), "--out", at("none/plan.json")}, 1), HasSubstr("no such folder"))
        << "before anything is worked out: this scene could not be planned in";
    EXPECT_THAT(failureOf({"plan", at("room.revisit"), "--out", at("plan.png")}, 1), HasSubstr("plan.json"));
    EXPECT_THAT(failureOf({"plan", at("room.revisit")}, 2), HasSubstr("--out"));
    EXPECT_THAT(failureOf({"plan", at("room.revisit"), "--out", at("p.json"), "--count", "0"}, 2),
                HasSubstr("--count"));
    EXPECT_THAT(failureOf({"plan", "--help"}, 0), HasSubstr("revisit plan site.revisit --out plan.json"));
}

} // namespace
} // namespace app
