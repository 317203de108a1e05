// Photographs with range whose poses are off by pixels: the build lays them on each other, and says so.

#include "scene/pose.h"

#include "tests/app/comparison.h"
#include "tests/app/made_sample.h"
#include "tests/app/pose_json.h"
#include "tests/app/program.h"
#include "tests/scene/scratch_folder.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace app {
namespace {

using nlohmann::json;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

constexpr int kImages = 36;
/// What comes after the poses, where only they are looked at.
const std::vector<std::string> kPosesAlone{"--no-silhouettes", "--no-fuse"};

/// A capture of the room with noise, and the same with other poses in its transforms.json, made once.
class Poses : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        scratch_ = new scene::ScratchFolder;
        const Outcome made = makeSample(
            {path("true"), "--images", std::to_string(kImages), "--size", "320x240", "--noise-mm", "2"}, folder());
        ASSERT_EQ(made.status, 0) << made.output;
        std::filesystem::copy(path("true"), path("off"), std::filesystem::copy_options::recursive);
        json transforms = readJson(path("off/transforms.json"));
        std::mt19937 generator(1);
        std::normal_distribution<double> normal;
        for (json& frame : transforms.at("frames")) {
            json& rows = frame.at("transform_matrix");
            const auto some = [&](double scale) { return scale * normal(generator); };
            const scene::Pose turn =
                scene::poseFromQuaternion(glm::dvec3(0), some(0.0025), some(0.0025), some(0.0025), 1);
            for (int column = 0; column < 3; ++column) {
                glm::dvec3 axis(0);
                for (int row = 0; row < 3; ++row)
                    axis[row] = rows.at(static_cast<std::size_t>(row)).at(static_cast<std::size_t>(column));
                axis = turn.rotation * axis;
                for (int row = 0; row < 3; ++row)
                    rows.at(static_cast<std::size_t>(row)).at(static_cast<std::size_t>(column)) = axis[row];
            }
            for (std::size_t row = 0; row < 3; ++row)
                rows.at(row).at(3) = rows.at(row).at(3).get<double>() + some(0.01);
        }
        std::ofstream(path("off/transforms.json")) << transforms.dump();
    }
    static void TearDownTestSuite() { delete scratch_; }
    static std::filesystem::path folder() { return scratch_->path(); }
    static std::string path(const std::string& name) { return (folder() / name).string(); }

    static Outcome build(const std::string& capture, const std::string& scene,
                         const std::vector<std::string>& options = {}) {
        std::vector<std::string> command{kRevisit, "build", path(capture), "-o", path(scene)};
        command.insert(command.end(), options.begin(), options.end());
        return run(command, folder());
    }
    static Outcome layPoses(const std::string& capture, const std::string& scene,
                            std::vector<std::string> options = {}) {
        options.insert(options.end(), kPosesAlone.begin(), kPosesAlone.end());
        return build(capture, scene, options);
    }
    /// Where the images of a scene stand, in the order of the capture.
    static std::vector<scene::Pose> posesOf(const std::string& scene, const char* list = "images") {
        const json images = readJson(path(scene) + "/scene.json").at(list);
        std::vector<scene::Pose> poses;
        for (const json& image : images)
            poses.push_back(poseOf(image.at("world_from_camera")));
        return poses;
    }
    /// Where a capture says that its photographs stand.
    static std::vector<scene::Pose> saidBy(const std::string& capture) {
        std::vector<scene::Pose> poses;
        const json transforms = readJson(path(capture) + "/transforms.json");
        for (const json& frame : transforms.at("frames")) {
            json rows = json::array();
            for (const json& row : frame.at("transform_matrix"))
                for (const json& value : row)
                    rows.push_back(value);
            scene::Pose pose = poseOf(rows); // y up, z back, as nerfstudio has cameras
            pose.rotation[1] = -pose.rotation[1], pose.rotation[2] = -pose.rotation[2];
            poses.push_back(pose);
        }
        return poses;
    }
    /// The middle error of how neighbours stand to each other, metres.
    static double errorOf(const std::vector<scene::Pose>& found, const std::vector<scene::Pose>& truth) {
        std::vector<double> errors;
        for (std::size_t i = 0; i + 1 < found.size(); ++i) {
            const scene::Pose is = inverse(found[i]) * found[i + 1], shouldBe = inverse(truth[i]) * truth[i + 1];
            // What is seen two metres ahead of the second.
            const glm::dvec3 ahead(0, 0, 2);
            errors.push_back(glm::distance(is * ahead, shouldBe * ahead));
        }
        std::nth_element(errors.begin(), errors.begin() + std::ssize(errors) / 2, errors.end());
        return errors[errors.size() / 2];
    }

  private:
    static inline scene::ScratchFolder* scratch_ = nullptr;
};

TEST_F(Poses, ThoseThatAreOffAreAdjusted) {
    const Outcome built = build("off", "found.revisit");
    ASSERT_EQ(built.status, 0) << built.output;
    EXPECT_THAT(built.output, HasSubstr("poses"));
    const double before = errorOf(saidBy("off"), saidBy("true"));
    EXPECT_GT(before, 0.015);
    EXPECT_LT(errorOf(posesOf("found.revisit"), saidBy("true")), 0.1 * before);
    EXPECT_TRUE(readJson(path("found.revisit") + "/scene.json").at("contradictions").empty()) << built.output;
    const Outcome told = run({kRevisit, "info", path("found.revisit")}, folder());
    EXPECT_THAT(told.output, HasSubstr("poses      of 36 of 36 photographs adjusted, in the mean by "));
}

TEST_F(Poses, ThoseThatAreRightOrGivenForGoodStayAsTheyAre) {
    const auto expectAsSaid = [](const std::string& scene, const std::string& capture) {
        const std::vector<scene::Pose> stand = posesOf(scene), said = saidBy(capture);
        ASSERT_EQ(stand.size(), said.size());
        for (std::size_t i = 0; i < said.size(); ++i) {
            EXPECT_LT(glm::distance(stand[i].translation, said[i].translation), 1e-9);
            EXPECT_GT(scene::cosineBetween(stand[i].rotation, said[i].rotation), 1 - 1e-12);
        }
    };
    ASSERT_EQ(layPoses("true", "right.revisit").status, 0);
    expectAsSaid("right.revisit", "true");
    const Outcome told = run({kRevisit, "info", path("right.revisit")}, folder());
    EXPECT_THAT(told.output, ContainsRegex("poses      as given.*: surfaces lie on each other to 0\\.0[0-9]*[1-9]"));
    const Outcome given = layPoses("off", "given.revisit", {"--register", "given"});
    EXPECT_THAT(given.output, Not(HasSubstr("poses")));
    expectAsSaid("given.revisit", "off");
    EXPECT_TRUE(readJson(path("given.revisit") + "/scene.json").at("poses").is_null());
}

TEST_F(Poses, WhatIsHeldOutIsFollowedAndChangesNothing) {
    ASSERT_EQ(layPoses("off", "held.revisit", {"--hold-out", "every:12:5"}).status, 0);
    const std::vector<scene::Pose> kept = posesOf("held.revisit"), out = posesOf("held.revisit", "held_out");
    const std::vector<scene::Pose> truth = saidBy("true");
    ASSERT_EQ(out.size(), 3u);
    for (std::size_t i = 0; i < out.size(); ++i) {
        // Held out are 5, 17 and 29: of the others 4, 15 and 26 come right before them.
        const scene::Pose is = inverse(kept[11 * i + 4]) * out[i],
                          shouldBe = inverse(truth[12 * i + 4]) * truth[12 * i + 5];
        const glm::dvec3 ahead(0, 0, 2);
        EXPECT_LT(glm::distance(is * ahead, shouldBe * ahead), 0.008) << i;
    }
    // Without those pictures the rest stand where they stood, to the last digit.
    json transforms = readJson(path("off/transforms.json"));
    json& frames = transforms.at("frames");
    for (const std::size_t gone : {std::size_t{29}, std::size_t{17}, std::size_t{5}})
        frames.erase(gone);
    std::filesystem::copy(path("off"), path("fewer"), std::filesystem::copy_options::recursive);
    std::ofstream(path("fewer/transforms.json")) << transforms.dump();
    ASSERT_EQ(layPoses("fewer", "fewer.revisit").status, 0);
    EXPECT_TRUE(readJson(path("held.revisit") + "/scene.json").at("images") ==
                readJson(path("fewer.revisit") + "/scene.json").at("images"));
}

TEST_F(Poses, APhotographOfAnotherPlaceIsNamedAndLeftWhereItWas) {
    std::filesystem::copy(path("off"), path("strange"), std::filesystem::copy_options::recursive);
    json transforms = readJson(path("strange/transforms.json"));
    json& frames = transforms.at("frames");
    frames.at(5).at("transform_matrix") = frames.at(17).at("transform_matrix");
    std::ofstream(path("strange/transforms.json")) << transforms.dump();
    const Outcome built = layPoses("strange", "strange.revisit");
    ASSERT_EQ(built.status, 0) << built.output;
    EXPECT_THAT(built.output, HasSubstr("stands where it was said to stand: the others do not say where it belongs."));
    const json images = readJson(path("strange.revisit") + "/scene.json").at("poses").at("images");
    for (std::size_t i = 0; i < images.size(); ++i)
        EXPECT_EQ(images.at(i).at("place"), i == 5 ? "strayed" : "adjusted") << i;
    EXPECT_THAT(built.output, HasSubstr("note: The others contradict '00005': of what is said"));
    const json contradictions = readJson(path("strange.revisit") + "/scene.json").at("contradictions");
    ASSERT_EQ(contradictions.size(), 1u) << contradictions;
    EXPECT_EQ(contradictions.at(0).at("image"), "00005");
    EXPECT_GT(contradictions.at(0).at("share"), 0.3);
}

TEST_F(Poses, APhotographOfWhatNoOtherShowsIsNamed) {
    std::filesystem::copy(path("true"), path("beyond"), std::filesystem::copy_options::recursive);
    json transforms = readJson(path("beyond/transforms.json"));
    json& x = transforms.at("frames").at(9).at("transform_matrix").at(0).at(3);
    x = x.get<double>() + 50;
    std::ofstream(path("beyond/transforms.json")) << transforms.dump();
    const Outcome built = layPoses("beyond", "beyond.revisit", {"--register", "given"});
    ASSERT_EQ(built.status, 0) << built.output;
    EXPECT_THAT(built.output,
                HasSubstr("note: No other photograph of the scene shows, even roughly, what '00009' shows: "));
    EXPECT_THAT(built.output, Not(HasSubstr("contradict")));
}

TEST_F(Poses, TooManyForTheMemoryStayWhereTheyAre) {
    const Outcome built = layPoses("off", "small.revisit", {"--memory", "5M"});
    ASSERT_EQ(built.status, 0) << built.output;
    EXPECT_THAT(built.output, HasSubstr("36 are too many to be laid on each other within --memory"));
}

TEST_F(Poses, ThatPicturesAreCoarserForLackOfMemoryIsSaid) {
    const Outcome built = layPoses("off", "coarse.revisit", {"--memory", "16M"});
    ASSERT_EQ(built.status, 0) << built.output;
    EXPECT_THAT(built.output, HasSubstr("by pictures 160 pixels across instead of 320"));
    const json poses = readJson(path("coarse.revisit") + "/scene.json").at("poses");
    EXPECT_GT(poses.at("adjusted"), kImages / 2);
}

} // namespace
} // namespace app
