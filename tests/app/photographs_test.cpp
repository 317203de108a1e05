// Photographs beside scans as a user has them: written by the simulated camera, laid on their scans by the build, told
// of by info.

#include "scene/depth_tiff.h"
#include "scene/pose.h"

#include "tests/app/comparison.h"
#include "tests/app/made_sample.h"
#include "tests/app/pose_json.h"
#include "tests/app/program.h"
#include "tests/scene/scratch_folder.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace app {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

double degreesBetween(const scene::Pose& a, const scene::Pose& b) {
    return std::acos(std::clamp(scene::cosineBetween(a.rotation, b.rotation), -1.0, 1.0)) * 57.29577951308232;
}

/// One scan of the room with six photographs, whose poses are written wrong by a degree; made once.
class Photographs : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        scratch_ = new scene::ScratchFolder;
        const Outcome made =
            makeSample({path("capture"), "--scene", "room", "--scanner", "--scans", "1", "--density", "3",
                        "--no-colour", "--photographs", "6", "--photograph-size", "320x240", "--exposure-drift", "0.3"},
                       folder());
        ASSERT_EQ(made.status, 0) << made.output;
    }
    static void TearDownTestSuite() { delete scratch_; }
    static std::filesystem::path folder() { return scratch_->path(); }
    static std::string path(const std::string& name) { return (folder() / name).string(); }
    static Outcome build(const std::string& scene, std::vector<std::string> more) {
        std::vector<std::string> command{kRevisit, "build", path("capture/scans.e57"), "-o", path(scene)};
        command.insert(command.end(), more.begin(), more.end());
        return run(command, folder());
    }

  private:
    static inline scene::ScratchFolder* scratch_ = nullptr;
};

TEST_F(Photographs, AreLaidOnTheirScanAndColourIt) {
    const Outcome built = build("room.revisit", {"--camera", path("capture/camera.json")});
    ASSERT_EQ(built.status, 0) << built.output;
    const json scene = readJson(path("room.revisit") + "/scene.json");
    const json truth = readJson(path("capture/truth.json"));
    const json& photographs = scene.at("photographs");
    ASSERT_EQ(photographs.size(), 6u);
    const scene::Pose worldFromScanner = poseOf(truth.at("scans")[0].at("written_world_from_scanner"));
    int sure = 0;
    for (std::size_t i = 0; i < photographs.size(); ++i) {
        const json& photograph = photographs[i];
        const scene::Pose right = worldFromScanner * poseOf(truth.at("photographs")[i].at("scanner_from_camera"));
        EXPECT_TRUE(photograph.at("used")) << "--register given takes the file's word where nothing better is known";
        const double error = degreesBetween(poseOf(photograph.at("world_from_camera")), right);
        if (!photograph.at("sure").get<bool>()) {
            EXPECT_NEAR(error, 1, 1e-3) << "where the file says";
            EXPECT_THAT(built.output, HasSubstr("'" + photograph.at("name").get<std::string>() + "'"));
            continue;
        }
        ++sure;
        EXPECT_LT(error, 0.15) << photograph.at("name") << ": the scan's spacing is 0.33 degrees";
        EXPECT_THAT(built.output, Not(HasSubstr("'" + photograph.at("name").get<std::string>() + "'")));
    }
    EXPECT_GE(sure, 3);
    EXPECT_THAT(built.output, Not(HasSubstr("how a lens distorts")));
    EXPECT_GE(scene.at("images").size(), 6u + 6) << "photographs and the faces of the cube";
    // They saw the band about the horizon, half of this face; the scan itself has no colours.
    const scene::DepthImage face = scene::readDepthTiff(path("room.revisit") + "/images/scan1-front.tiff");
    std::size_t samples = 0, coloured = 0;
    for (const std::uint8_t flags : face.flags.pixels())
        samples += scene::isSurface(flags), coloured += scene::isSurface(flags) && !(flags & scene::kNoColour);
    EXPECT_GT(static_cast<double>(coloured), 0.4 * static_cast<double>(samples));
    EXPECT_LT(coloured, samples);
    const Outcome told = run({kRevisit, "info", path("room.revisit")}, folder());
    EXPECT_THAT(told.output, HasSubstr("photograph scan1-photo1 of scan1: "));
    EXPECT_THAT(told.output, HasSubstr("6 of 6 photographs beside scans"));

    // Once laid they are not laid again, whatever else is asked; another camera is another result.
    const Outcome again = build("room.revisit", {"--camera", path("capture/camera.json"), "--no-cull"});
    ASSERT_EQ(again.status, 0) << again.output;
    EXPECT_THAT(again.output, Not(HasSubstr("photographs  6/6")));
}

TEST_F(Photographs, ThoseThatAreHeldOutAreMeasuredBy) {
    const std::string camera = path("capture/camera.json");
    const Outcome built = build("kept.revisit", {"--camera", camera, "--hold-out", "every:3:1"});
    ASSERT_EQ(built.status, 0) << built.output;
    const json scene = readJson(path("kept.revisit") + "/scene.json");
    const auto namesOf = [](const json& list) {
        std::vector<std::string> names;
        for (const json& item : list)
            names.push_back(item.at("name"));
        return names;
    };
    const std::vector<std::string> out{"scan1-photo2", "scan1-photo5"};
    EXPECT_EQ(namesOf(scene.at("held_out")), out);
    for (const std::string& name : out) {
        EXPECT_THAT(namesOf(scene.at("images")), Not(testing::Contains(name)));
        EXPECT_THAT(namesOf(scene.at("photographs")), Not(testing::Contains(name)));
    }
    std::ofstream(path("settings.json")) << R"({"settings": [{"name": "points", "warp": "points"}]})";
    const Outcome measured = run({kRevisit, "measure", path("kept.revisit"), "--out", path("figures"), "--settings",
                                  path("settings.json"), "--frames", "2"},
                                 folder());
    ASSERT_EQ(measured.status, 0) << measured.output;
    // Of what they alone saw there is no colour; where surfaces stand the scan knows.
    const json figures = readJson(path("figures/report.json")).at("settings")[0];
    ASSERT_EQ(figures.at("pictures").size(), out.size());
    EXPECT_GT(figures.at("covered_share"), 0.95);
    EXPECT_LT(figures.at("wrongly_solid_share"), 0.03);

    std::ofstream(path("names.txt")) << "scan1-photo6\n";
    ASSERT_EQ(build("named.revisit", {"--camera", camera, "--hold-out", path("names.txt")}).status, 0);
    EXPECT_EQ(namesOf(readJson(path("named.revisit") + "/scene.json").at("held_out")),
              std::vector<std::string>{"scan1-photo6"});
    const Outcome late = build("no.revisit", {"--hold-out", "every:2:6"});
    EXPECT_EQ(late.status, 1);
    EXPECT_THAT(late.output, HasSubstr("keeps none of 6 photographs out"));
}

TEST_F(Photographs, WithALensThatNobodyKnowsAreNotBelievedAndThatIsSaid) {
    const Outcome built = build("lens.revisit", {});
    ASSERT_EQ(built.status, 0) << built.output;
    EXPECT_THAT(built.output, HasSubstr("E57 cannot say how a lens distorts"));
}

TEST_F(Photographs, OfAnotherSizeOrNoneAtAllRefuseACameraFile) {
    std::ofstream(path("other.json")) << R"({"width": 100, "height": 75, "fx": 80, "fy": 80, "cx": 50, "cy": 37})";
    const Outcome other = build("no.revisit", {"--camera", path("other.json")});
    EXPECT_EQ(other.status, 1);
    EXPECT_THAT(other.output, HasSubstr("is of pictures of 100x75, but photograph 'scan1-photo1' is 320x240"));
    const Outcome made = run({kMakeSample, path("bare"), "--scanner", "--scans", "1", "--density", "1"}, folder());
    ASSERT_EQ(made.status, 0) << made.output;
    const Outcome none = run(
        {kRevisit, "build", path("bare/scans.e57"), "-o", path("no.revisit"), "--camera", path("capture/camera.json")},
        folder());
    EXPECT_EQ(none.status, 1);
    EXPECT_THAT(none.output, HasSubstr("there are none that can be used"));
    const Outcome nothing =
        run({kRevisit, "build", path("bare/scans.e57"), "-o", path("no.revisit"), "--hold-out", "every:2"}, folder());
    EXPECT_EQ(nothing.status, 1);
    EXPECT_THAT(nothing.output, HasSubstr("keeps photographs out, and there are none"));
    EXPECT_FALSE(std::filesystem::exists(path("no.revisit")));
    const Outcome ptx =
        run({kMakeSample, path("ptx"), "--scanner", "--photographs", "2", "--scan-format", "ptx"}, folder());
    EXPECT_EQ(ptx.status, 1);
    EXPECT_THAT(ptx.output, HasSubstr("cannot hold photographs"));
    EXPECT_EQ(run({kMakeSample, path("odd"), "--scanner", "--photograph-size", "9"}, folder()).status, 2);
}

} // namespace
} // namespace app
