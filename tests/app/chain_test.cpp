// The whole chain, from raw scans and photographs of instruments that are a little off to pictures from places where
// none ever stood, against the same with perfect instruments; both against the truth.

#include "scene/pose.h"

#include "tests/app/comparison.h"
#include "tests/app/made_sample.h"
#include "tests/app/pose_json.h"
#include "tests/app/program.h"
#include "tests/repetitions.h"
#include "tests/scene/scratch_folder.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

namespace app {
namespace {

using nlohmann::json;

constexpr int kSeen = 1; ///< class of a pixel

class Chain : public testing::Test {
  protected:
    std::string path(const std::string& name) const { return (scratch_.path() / name).string(); }

    void must(const std::vector<std::string>& command) const {
        const Outcome outcome = run(command, scratch_.path());
        ASSERT_EQ(outcome.status, 0) << testing::PrintToString(command) << outcome.output;
    }
    void make(const std::vector<std::string>& arguments) const {
        const Outcome made = makeSample(arguments, scratch_.path());
        ASSERT_EQ(made.status, 0) << made.output;
    }

    /// The cameras of the true pictures, in the world of a scene.
    void writeCameras(const std::string& file, const scene::Pose& sceneFromTrue) const {
        const json truth = readJson(path("truth/transforms.json"));
        json cameras = json::array();
        for (const json& frame : truth.at("frames")) {
            glm::dmat4 m(1);
            for (int i = 0; i < 16; ++i)
                m[i % 4][i / 4] = frame.at("transform_matrix")
                                      .at(static_cast<std::size_t>(i / 4))
                                      .at(static_cast<std::size_t>(i % 4));
            m[1] = -m[1], m[2] = -m[2]; // y up, z back -> y down, z forward
            scene::Pose pose;
            ASSERT_TRUE(poseFromMatrix(m, 1e-6, pose));
            const glm::dmat4 placed = toMatrix(sceneFromTrue * pose);
            json rows = json::array();
            for (int i = 0; i < 16; ++i)
                rows.push_back(placed[i % 4][i / 4]);
            cameras.push_back({{"name", std::filesystem::path(frame.at("file_path").get<std::string>()).stem()},
                               {"width", truth.at("w")},
                               {"height", truth.at("h")},
                               {"fx", truth.at("fl_x")},
                               {"fy", truth.at("fl_y")},
                               {"cx", truth.at("cx")},
                               {"cy", truth.at("cy")},
                               {"world_from_camera", rows}});
        }
        std::ofstream(path(file)) << json{{"cameras", cameras}};
    }

    /// Decibels over what is seen, and how much that is; the mean over the pictures.
    Agreement compare(const std::string& scene) const {
        must({kRevisit, "render", path(scene + ".revisit"), "--out", path(scene + "-frames"), "--cameras",
              path(scene + ".json"), "--aux"});
        Agreement result;
        const json cameras = readJson(path(scene + ".json")).at("cameras");
        for (const json& camera : cameras) {
            const std::string name = camera.at("name");
            const cv::Mat3b drawn = cv::imread(path(scene + "-frames/" + name + ".png")),
                            truth = cv::imread(path("truth/images/" + name + ".png"));
            const cv::Mat seenPixels =
                cv::imread(path(scene + "-frames/" + name + "-class.png"), cv::IMREAD_UNCHANGED) == kSeen;
            const cv::Mat1b seen = seenPixels;
            result.meanPsnr += psnr(drawn, truth, seen);
            result.seenShare += static_cast<double>(cv::countNonZero(seen)) / static_cast<double>(seen.total());
            ++result.pictures;
        }
        result.meanPsnr /= result.pictures;
        result.seenShare /= result.pictures;
        return result;
    }

  private:
    scene::ScratchFolder scratch_;
};

TEST_F(Chain, FromRawScansAndPhotographsCostsNoMoreThanOneAndAHalfDecibels) {
    make({path("truth"), "--scene", "room", "--images", "6", "--size", "320x240", "--samples", "4"});
    const auto sample = [&](const std::string& name, const std::vector<std::string>& faults) {
        std::vector<std::string> command{path(name),    "--scene",
                                         "room",        "--scanner",
                                         "--scans",     "2",
                                         "--density",   tests::areLong() ? "5" : "3",
                                         "--no-colour", "--photographs",
                                         "7",           "--photograph-size",
                                         "400x300"};
        command.insert(command.end(), faults.begin(), faults.end());
        make(command);
    };
    sample("perfect", {"--range-noise-mm", "0", "--photograph-error", "0", "--exposure-drift", "0"});
    sample("raw", {"--photograph-error", "2", "--exposure-drift", "0.5", "--wrong-constants", "--poses-unknown"});
    make({path("walls"), "--scene", "room", "--scanner", "--scans", "1", "--density", "2.5", "--no-colour",
          "--both-faces", "--wrong-constants"});
    must({kRevisit, "calibrate", "scanner", path("walls/scans.e57"), "-o", path("scanner.json")});
    must({kRevisit, "build", path("perfect/scans.e57"), "-o", path("perfect.revisit"), "--camera",
          path("perfect/camera.json")});
    must({kRevisit, "build", path("raw/scans.e57"), "-o", path("raw.revisit"), "--camera", path("raw/camera.json"),
          "--scanner", path("scanner.json"), "--register", "auto", "--colour-even"});

    const json first = readJson(path("raw/truth.json")).at("scans").at(0);
    writeCameras("perfect.json", {});
    writeCameras("raw.json",
                 poseOf(first.at("written_world_from_scanner")) * inverse(poseOf(first.at("world_from_scanner"))));
    const Agreement perfect = compare("perfect"), raw = compare("raw");
    std::printf("perfect instruments %.2f dB (%.1f %% seen), raw ones %.2f dB (%.1f %%)\n", perfect.meanPsnr,
                100 * perfect.seenShare, raw.meanPsnr, 100 * raw.seenShare);
    EXPECT_LT(perfect.meanPsnr - raw.meanPsnr, 1.5);
    EXPECT_GT(raw.seenShare, perfect.seenShare - 0.02);
    const json evening = readJson(path("raw.revisit/scene.json")).at("photograph_evening");
    EXPECT_LT(evening.at("seam_after").get<double>(), evening.at("seam_before").get<double>() / 5);
}

} // namespace
} // namespace app
