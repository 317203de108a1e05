// Laser scans as a user has them: written by the simulated scanner, registered by the build, told of by info.

#include "scene/align/pair_record.h"
#include "scene/pose.h"

#include "tests/app/comparison.h"
#include "tests/app/made_sample.h"
#include "tests/app/pose_json.h"
#include "tests/app/program.h"
#include "tests/scene/import/written_e57.h"
#include "tests/scene/scratch_folder.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

namespace app {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

/// Two scans of the room that nobody said where they stood, made once.
class Scans : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        scratch_ = new scene::ScratchFolder;
        const Outcome made = makeSample({path("capture"), "--scene", "room", "--scanner", "--scans", "2", "--density",
                                         "2", "--no-colour", "--poses-unknown"},
                                        folder());
        ASSERT_EQ(made.status, 0) << made.output;
    }
    static void TearDownTestSuite() { delete scratch_; }
    static std::filesystem::path folder() { return scratch_->path(); }
    static std::string path(const std::string& name) { return (folder() / name).string(); }

    static Outcome build(const std::string& scene, const std::string& how) {
        return run({kRevisit, "build", path("capture/scans.e57"), "-o", path(scene), "--register", how}, folder());
    }
    /// Of the second scan against the first, after a build.
    static void expectRight(const std::string& scene, double degrees, double metres) {
        const json truth = readJson(path("capture/truth.json")).at("scans");
        const json found = readJson(path(scene) + "/scene.json").at("registration").at("scans");
        const auto between = [](const json& scans) {
            return inverse(poseOf(scans.at(0).at("world_from_scanner"))) * poseOf(scans.at(1).at("world_from_scanner"));
        };
        const scene::Pose off = inverse(between(truth)) * between(found);
        const glm::dmat3& r = off.rotation;
        const glm::dvec3 twist(r[1][2] - r[2][1], r[2][0] - r[0][2], r[0][1] - r[1][0]);
        EXPECT_LT(std::asin(std::min(glm::length(twist) / 2, 1.0)) * 57.29577951308232, degrees);
        EXPECT_LT(glm::length(off.translation), metres);
    }

  private:
    static inline scene::ScratchFolder* scratch_ = nullptr;
};

TEST_F(Scans, APlaneFileThatIsNotThereIsSaidAtOnce) {
    const Outcome refused = build("none.revisit", "nowhere.json");
    EXPECT_EQ(refused.status, 1);
    EXPECT_THAT(refused.output, HasSubstr("nowhere.json"));
    EXPECT_EQ(std::count(refused.output.begin(), refused.output.end(), '\n'), 1) << refused.output;
    EXPECT_FALSE(std::filesystem::exists(path("none.revisit.build"))) << "nothing was begun";
}

TEST_F(Scans, FindTheirPosesAndTellOfThem) {
    const Outcome built = build("auto.revisit", "auto");
    ASSERT_EQ(built.status, 0) << built.output;
    EXPECT_THAT(built.output, HasSubstr("register"));
    EXPECT_THAT(built.output, Not(HasSubstr("note:")));
    expectRight("auto.revisit", 0.04, 0.003);
    const Outcome told = run({kRevisit, "info", path("auto.revisit")}, folder());
    EXPECT_THAT(told.output, HasSubstr("registered 2 of 2 scans"));
    EXPECT_THAT(told.output, HasSubstr("scan1, scan2: registered; overlap"));
    // The images stand where the scans were found to stand.
    const json scene = readJson(path("auto.revisit") + "/scene.json");
    const scene::Pose second = poseOf(scene.at("registration").at("scans").at(1).at("world_from_scanner"));
    EXPECT_LT(glm::distance(poseOf(scene.at("images").back().at("world_from_camera")).translation, second.translation),
              1e-6);
    // Once found they are not looked for again, whatever else is asked.
    const Outcome again = run(
        {kRevisit, "build", path("capture/scans.e57"), "-o", path("auto.revisit"), "--register", "auto", "--no-cull"},
        folder());
    ASSERT_EQ(again.status, 0) << again.output;
    EXPECT_THAT(again.output, Not(HasSubstr("register")));
}

TEST_F(Scans, WhatIsKnownOfAPairOutlivesABuildThatWasStopped) {
    ASSERT_EQ(build("kept.revisit", "auto").status, 0);
    const auto inBuild = [](const char* stage) {
        std::vector<std::filesystem::path> found;
        for (const auto& entry : std::filesystem::directory_iterator(path("kept.revisit.build")))
            if (entry.path().filename().string().starts_with(stage)) found.push_back(entry.path());
        return found;
    };
    const auto forgetTheRest = [&] {
        for (const std::filesystem::path& folder : inBuild("registration-"))
            std::filesystem::remove_all(folder);
    };
    const auto isRegistered = [&] {
        return readJson(path("kept.revisit") + "/scene.json").at("registration").at("scans")[1].at("registered");
    };
    ASSERT_EQ(inBuild("pairs-").size(), 1u);
    std::vector<std::filesystem::path> pairs;
    for (const auto& entry : std::filesystem::directory_iterator(inBuild("pairs-")[0]))
        pairs.push_back(entry.path());
    ASSERT_EQ(pairs.size(), 1u);
    // It is believed: another is put in its place.
    forgetTheRest();
    const std::vector<std::byte> apart = scene::packPair({});
    std::ofstream(pairs[0], std::ios::binary)
        .write(reinterpret_cast<const char*>(apart.data()), static_cast<std::streamsize>(apart.size()));
    ASSERT_EQ(build("kept.revisit", "auto").status, 0);
    EXPECT_FALSE(isRegistered());
    // Damaged it is found out again.
    forgetTheRest();
    std::filesystem::resize_file(pairs[0], 20);
    ASSERT_EQ(build("kept.revisit", "auto").status, 0);
    EXPECT_TRUE(isRegistered());
    EXPECT_GT(std::filesystem::file_size(pairs[0]), 20u);
}

TEST_F(Scans, PhotographsGoWithScansThatAreLeftOut) {
    const Outcome made =
        makeSample({path("elsewhere"), "--scene", "corner", "--scanner", "--scans", "1", "--density", "1.5",
                    "--no-colour", "--poses-unknown", "--photographs", "2", "--photograph-size", "160x120"},
                   folder());
    ASSERT_EQ(made.status, 0) << made.output;
    std::ofstream(path("out.txt")) << "scan1-photo1\n";
    const Outcome built = run({kRevisit, "build", path("elsewhere/scans.e57"), path("capture/scans.e57"), "-o",
                               path("two.revisit"), "--register", "auto", "--hold-out", path("out.txt")},
                              folder());
    ASSERT_EQ(built.status, 0) << built.output;
    EXPECT_THAT(built.output, HasSubstr("note: Scan 'scan1' is left out"));
    EXPECT_THAT(built.output, HasSubstr("2 photographs beside scans that are left out are left out, too; 1 of them"));
    const json scene = readJson(path("two.revisit") + "/scene.json");
    EXPECT_TRUE(scene.at("held_out").empty());
    for (const json& image : scene.at("images"))
        EXPECT_THAT(image.at("name").get<std::string>(),
                    testing::AnyOf(testing::StartsWith("scan1-2-"), testing::StartsWith("scan2-")));
}

TEST_F(Scans, StandWhereTheFileSaysUnlessAsked) {
    const Outcome built = build("given.revisit", "given");
    ASSERT_EQ(built.status, 0) << built.output;
    const json scene = readJson(path("given.revisit") + "/scene.json");
    EXPECT_TRUE(scene.at("registration").is_null());
    for (const json& image : scene.at("images"))
        EXPECT_EQ(glm::length(poseOf(image.at("world_from_camera")).translation), 0);
    EXPECT_THAT(built.output, HasSubstr("note: Scans 'scan1' and 'scan2' stand at the same place in their files"));
}

TEST_F(Scans, OneWithoutPointsIsTold) {
    std::ofstream empty(path("empty.ptx"));
    empty << "2\n2\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n5 5 5 1\n";
    for (int i = 0; i < 4; ++i)
        empty << "0 0 0 0.5\n";
    empty.close();
    const Outcome built =
        run({kRevisit, "build", path("capture/scans.e57"), path("empty.ptx"), "-o", path("some.revisit"), "--coverage"},
            folder());
    ASSERT_EQ(built.status, 0) << built.output;
    EXPECT_THAT(built.output, HasSubstr("note: Scan 'empty' holds no point with range"));
    EXPECT_THAT(built.output, Not(HasSubstr("rays of scan 'empty'")));
}

TEST_F(Scans, OneWithMorePointsThanCanBeReadIsRefusedAtOnce) {
    const auto claim = [](std::string xml) {
        const std::size_t count = xml.find("recordCount=\"") + 13;
        return xml.replace(count, xml.find('"', count) - count, std::to_string(std::int64_t{1} << 31));
    };
    scene::writeBytes(path("vast.e57"), scene::withXml(scene::readBytes(path("capture/scans.e57")), claim));
    const Outcome refused = run({kRevisit, "build", path("vast.e57"), "-o", path("vast.revisit")}, folder());
    EXPECT_EQ(refused.status, 1) << refused.output;
    EXPECT_THAT(refused.output, HasSubstr("vast.e57: scan 'scan1' has 2147483648 points, and of one scan no more"));
    EXPECT_THAT(refused.output, HasSubstr("; export each setup by itself, or thinned"));
    EXPECT_FALSE(std::filesystem::exists(path("vast.revisit.build"))) << "nothing was begun";
}

TEST_F(Scans, ThoseThatContradictEachOtherAreTold) {
    const Outcome made = makeSample({path("off"), "--scene", "room", "--scanner", "--scans", "2", "--density", "2",
                                     "--no-colour", "--pose-error", "5,0.3"},
                                    folder());
    ASSERT_EQ(made.status, 0) << made.output;
    const Outcome built = run({kRevisit, "build", path("off/scans.e57"), "-o", path("off.revisit")}, folder());
    ASSERT_EQ(built.status, 0) << built.output;
    EXPECT_THAT(built.output, HasSubstr("note: Scans contradict each other: "));
    EXPECT_THAT(built.output, HasSubstr("--register auto finds others"));
    const Outcome told = run({kRevisit, "info", path("off.revisit")}, folder());
    EXPECT_THAT(told.output, HasSubstr("contradict each other"));
}

TEST_F(Scans, OfPosesThatAreALittleOffItIsSaidHowFarSurfacesAreApart) {
    const Outcome made = run({kMakeSample, path("near"), "--scene", "corner", "--scanner", "--scans", "2", "--density",
                              "2", "--no-colour", "--pose-error", "0,0.05"},
                             folder());
    ASSERT_EQ(made.status, 0) << made.output;
    const Outcome built = run({kRevisit, "build", path("near/scans.e57"), "-o", path("near.revisit")}, folder());
    ASSERT_EQ(built.status, 0) << built.output;
    EXPECT_THAT(built.output,
                HasSubstr("note: Where scans 'scan1' and 'scan2' show the same surfaces they have them "));
    const json agreement = readJson(path("near.revisit/scene.json")).at("scan_agreement");
    const double apart = agreement.at("pairs").at(0).at("apart_m");
    EXPECT_GT(apart, 0.03);
    EXPECT_LT(apart, 0.2);
    EXPECT_THAT(run({kRevisit, "info", path("near.revisit")}, folder()).output,
                HasSubstr("farthest apart scan1 and scan2: "));
}

TEST_F(Scans, TakeAPersonsWordForThePlanesTheyShare) {
    // Places of the room on its ceiling and two walls, as either scanner has them.
    const json truth = readJson(path("capture/truth.json")).at("scans");
    json planes = json::array();
    const auto inScanner = [&](std::size_t scan, const glm::dvec3& p) {
        const glm::dvec3 q = inverse(poseOf(truth.at(scan).at("world_from_scanner"))) * p;
        return json{q.x, q.y, q.z};
    };
    for (const glm::dvec3& p : {glm::dvec3(2.6, 2.0, 2.7), glm::dvec3(5.2, 2.0, 2.2), glm::dvec3(2.0, 0.0, 2.4)})
        planes.push_back({{"a", inScanner(0, p)}, {"b", inScanner(1, p)}});
    const auto write = [&](const json& matches) {
        std::ofstream(path("matches.json")) << json{{"matches", matches}};
        return path("matches.json");
    };
    const Outcome built = build("matched.revisit", write({{{"a", "scan1"}, {"b", "scan2"}, {"planes", planes}}}));
    ASSERT_EQ(built.status, 0) << built.output;
    expectRight("matched.revisit", 0.04, 0.003);

    // What cannot be is not made true by anybody's word: here the walls are taken for the ceiling.
    json wrong = planes;
    std::swap(wrong[0]["b"], wrong[1]["b"]);
    const Outcome odd = build("odd.revisit", write({{{"a", "scan1"}, {"b", "scan2"}, {"planes", wrong}}}));
    ASSERT_EQ(odd.status, 0) << odd.output;
    EXPECT_THAT(odd.output, HasSubstr("note: Scan 'scan2' is left out, since nothing says where it stands"));
    const json scene = readJson(path("odd.revisit") + "/scene.json");
    EXPECT_FALSE(scene.at("registration").at("scans")[1].at("registered"));
    EXPECT_TRUE(scene.at("registration").at("scans")[1].at("left_out"));
    for (const json& image : scene.at("images"))
        EXPECT_THAT(image.at("name").get<std::string>(), testing::StartsWith("scan1"));
    EXPECT_THAT(run({kRevisit, "info", path("odd.revisit")}, folder()).output,
                HasSubstr("1 left out, since nothing says where they stand"));

    const Outcome unknown = build("no.revisit", write({{{"a", "scan1"}, {"b", "scan9"}, {"planes", planes}}}));
    EXPECT_EQ(unknown.status, 1);
    EXPECT_THAT(unknown.output, HasSubstr("a scan 'scan9' that the capture has not"));
    EXPECT_THAT(unknown.output, HasSubstr("choose from scan1, scan2"));
    planes.erase(2);
    const Outcome few = build("no.revisit", write({{{"a", "scan1"}, {"b", "scan2"}, {"planes", planes}}}));
    EXPECT_EQ(few.status, 1);
    EXPECT_THAT(few.output, HasSubstr("has too few planes"));
    planes.push_back({{"a", {0, 0, 0.2}}, {"b", {0, 0, 0.2}}});
    const Outcome air = build("no.revisit", write({{{"a", "scan1"}, {"b", "scan2"}, {"planes", planes}}}));
    EXPECT_EQ(air.status, 1);
    EXPECT_THAT(air.output, HasSubstr("0 0 0.2 is on a plane of scan 'scan1', and none is there"));
    const Outcome form = build("no.revisit", write({{{"a", 1}}}));
    EXPECT_EQ(form.status, 1);
    EXPECT_THAT(form.output, HasSubstr("is no file of matches"));
    EXPECT_FALSE(std::filesystem::exists(path("no.revisit")));
}

/// A scanner 1.6 m above a field, as PTX; what is farther off than 30 m gives no range, nor does the sky.
void writeField(const std::string& path, int columns, int rows) {
    std::ofstream file(path);
    file << columns << "\n" << rows << "\n0 0 1.6\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 1.6 1\n";
    for (int column = 0; column < columns; ++column)
        for (int row = 0; row < rows; ++row) {
            const double azimuth = -(column + 0.5) / columns * 6.283185307179586;
            const double elevation = (-60 + 150 * (row + 0.5) / rows) / 57.29577951308232;
            const double range = elevation < 0 ? -1.6 / std::sin(elevation) : 1e9;
            if (range < 30)
                file << range * std::cos(elevation) * std::cos(azimuth) << " "
                     << range * std::cos(elevation) * std::sin(azimuth) << " " << range * std::sin(elevation)
                     << " 0.5 90 120 60\n";
            else
                file << "0 0 0 0.5 0 0 0\n";
        }
}

TEST_F(Scans, UnderTheOpenSkyWhatIsAboveIsOpenIfSomebodySaysSo) {
    writeField(path("field.ptx"), 180, 75);
    std::ofstream(path("up.json")) << R"({"space": "walk", "poses":
        [{"t": 0, "position": [0.5, 1.7, 0.5], "orientation": [0.4, 0, 0, 0.917]}]})";
    /// The share of an eye's pixels, 47 degrees above the horizon, that show neither surface nor the unseen.
    const auto openOf = [&](const std::vector<std::string>& further, const std::string& note) {
        std::vector<std::string> command{kRevisit,    "build", path("field.ptx"), "-o", path("field.revisit"),
                                         "--coverage"};
        command.insert(command.end(), further.begin(), further.end());
        const Outcome built = run(command, folder());
        EXPECT_EQ(built.status, 0) << built.output;
        EXPECT_THAT(built.output, HasSubstr(note));
        const Outcome drawn = run({kRevisit, "render", path("field.revisit"), "--out", path("sky"), "--path",
                                   path("up.json"), "--size", "160x120", "--eyes", "1", "--aux"},
                                  folder());
        EXPECT_EQ(drawn.status, 0) << drawn.output;
        const cv::Mat1b classes = cv::imread(path("sky/pose-0000-class.png"), cv::IMREAD_UNCHANGED);
        return cv::countNonZero(classes == 0) / static_cast<double>(std::max<std::size_t>(classes.total(), 1));
    };
    EXPECT_LT(openOf({}, "--open-sky opens what is above the horizon"), 0.01);
    EXPECT_GT(openOf({"--open-sky"}, "are taken for open sky"), 0.99);
    // The face that looks up has no point, and is there all the same.
    const json images = readJson(path("field.revisit") + "/scene.json").at("images");
    EXPECT_TRUE(std::any_of(images.begin(), images.end(), [](const json& of) { return of.at("name") == "field-up"; }));

    const Outcome alone =
        run({kRevisit, "build", path("field.ptx"), "-o", path("none.revisit"), "--open-sky"}, folder());
    EXPECT_EQ(alone.status, 1);
    EXPECT_THAT(alone.output, HasSubstr("give --coverage and laser scans"));
}

TEST_F(Scans, MakeSampleRefusesWhatItCannotDo) {
    const Outcome many = run({kMakeSample, path("many"), "--scanner", "--scans", "40"}, folder());
    EXPECT_EQ(many.status, 1);
    EXPECT_THAT(many.output, HasSubstr("has places for 4 scans alone"));
    const Outcome error = run({kMakeSample, path("many"), "--scanner", "--pose-error", "3"}, folder());
    EXPECT_EQ(error.status, 2);
    EXPECT_THAT(error.output, HasSubstr("not DEGREES,METRES: 3"));
    for (const std::vector<std::string>& wrong : {std::vector<std::string>{"--scanner", "--range-noise-mm", "abc"},
                                                  {"--scanner", "--range-noise-mm", "-5"},
                                                  {"--scans", "2"}}) {
        std::vector<std::string> command{kMakeSample, path("many")};
        command.insert(command.end(), wrong.begin(), wrong.end());
        EXPECT_EQ(run(command, folder()).status, 2) << wrong.back();
    }
}

} // namespace
} // namespace app
