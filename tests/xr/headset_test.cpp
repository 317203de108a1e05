// Walks in a headset: the built program, a real OpenXR runtime, a head that the test moves.

#include "tests/app/comparison.h"
#include "tests/app/program.h"
#include "tests/scene/scratch_folder.h"
#include "tests/shared_data.h"
#include "tests/xr/monado.h"
#include "tests/xr/remote_head.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <set>
#include <thread>

#include <csignal>
#include <sys/wait.h>

namespace xr {

namespace {

namespace fs = std::filesystem;
using app::Outcome, app::readJson, app::run;

const std::string kRevisit = REVISIT_PROGRAM, kMakeSample = REVISIT_MAKE_SAMPLE;

/// Where the head is on its way, 12 seconds around: it goes sideways and ahead, and looks about.
RemotePose onTheWay(double seconds) {
    const double phase = seconds * 2 * 3.14159265358979 / 12;
    const double yaw = 0.5 * std::sin(phase), pitch = 0.2 * std::sin(2 * phase);
    const scene::Pose about =
        scene::poseFromQuaternion({0.3 * std::sin(phase), 1.5 + 0.1 * std::cos(phase), -0.3 + 0.3 * std::cos(phase)}, 0,
                                  std::sin(yaw / 2), 0, std::cos(yaw / 2)) *
        scene::poseFromQuaternion({0, 0, 0}, std::sin(pitch / 2), 0, 0, std::cos(pitch / 2));
    return remotePose(about);
}

class InHeadset : public testing::Test {
  protected:
    void SetUp() override {
        if (!isMonadoThere()) GTEST_SKIP() << "Monado is missing; ./dev test provides it";
    }

    std::string path(const std::string& name) const { return (scratch_ / name).string(); }

    void makeScene(const std::string& sample, int images, const std::string& size) {
        const Outcome made = run({kMakeSample, path("capture"), "--scene", sample, "--images", std::to_string(images),
                                  "--size", size, "--samples", "1"},
                                 scratch_.path());
        ASSERT_EQ(made.status, 0) << made.output;
        build(path("capture"));
    }
    void build(const std::string& capture) {
        const Outcome built = run({kRevisit, "build", capture, "-o", path("a.revisit")}, scratch_.path());
        ASSERT_EQ(built.status, 0) << built.output;
    }

    /// Walks so many frames in Monado with the head on its way; pictures lie in walk/.
    void walk(int frames, int pictureEvery) {
        const Monado monado(Variant::inproc, {.hertz = 90, .width = 320, .height = 240, .validation = true});
        const fs::path log = scratch_ / "walk.txt";
        const pid_t process =
            app::start(monado.around({kRevisit, "walk", path("a.revisit"), "--out", path("walk"), "--frames",
                                      std::to_string(frames), "--picture-every", std::to_string(pictureEvery)}),
                       log);
        lead(process, monado);
        const Outcome walked = app::waitFor(process, log);
        ASSERT_EQ(walked.status, 0) << walked.output;
        EXPECT_EQ(readJson(path("walk/report.json")).at("frames"), frames);
        EXPECT_EQ(monado.validationMessages(), "") << "OpenXR's validation layer";
    }

    /// Moves the head for as long as the program lives.
    static void lead(pid_t process, const Monado& monado) {
        RemoteHead head(monado.port());
        const auto start = std::chrono::steady_clock::now();
        siginfo_t ended{};
        try {
            do {
                const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
                RemoteState state;
                state.left.active = state.right.active = false; // else the walker would be shown them
                state.stageFromHead = onTheWay(passed.count());
                head.send(state);
                std::this_thread::sleep_for(std::chrono::milliseconds(3)); // a head moves no faster
                ended.si_pid = 0;
                waitid(P_PID, static_cast<id_t>(process), &ended, WEXITED | WNOHANG | WNOWAIT);
            } while (ended.si_pid == 0);
        } catch (const std::runtime_error&) {
            // The program has left, and its runtime with it: its own exit status tells how.
        }
    }

    /// What the eyes were given against render at the same poses.
    void comparePictures(int expected) {
        const Outcome drawn = run({kRevisit, "render", path("a.revisit"), "--out", path("drawn"), "--cameras",
                                   path("walk/cameras.json"), "--eyes", "1", "--aux"},
                                  scratch_.path());
        ASSERT_EQ(drawn.status, 0) << drawn.output;
        double worst = 1000;
        std::set<std::vector<double>> places;
        const auto cameras = readJson(path("walk/cameras.json")).at("cameras");
        ASSERT_EQ(cameras.size(), static_cast<std::size_t>(expected));
        for (const auto& camera : cameras) {
            const std::string name = camera.at("name");
            const cv::Mat3b given = cv::imread(path("walk/" + name + ".png"), cv::IMREAD_COLOR),
                            truth = cv::imread(path("drawn/" + name + ".png"), cv::IMREAD_COLOR);
            ASSERT_EQ(given.size(), truth.size()) << name;
            EXPECT_GT(cv::mean(truth)[1], 15) << name << ": there is something to see";
            worst = std::min(worst, app::psnr(given, truth, cv::Mat1b(truth.size(), std::uint8_t{1})));
            places.insert(camera.at("world_from_camera").get<std::vector<double>>());
        }
        std::printf("headset: %zu pictures, the worst %.1f dB from what render draws there\n", cameras.size(), worst);
        EXPECT_GE(worst, 45);
        EXPECT_EQ(places.size(), cameras.size()) << "the head has moved, and each eye is somewhere else";
    }

    /// A point at depth z stands fx times the eyes' distance over z farther left in the right eye.
    void checkParallax() {
        const auto cameras = readJson(path("walk/cameras.json")).at("cameras");
        int compared = 0;
        double matched = 0, mirrored = 0;
        for (std::size_t i = 0; i + 1 < cameras.size(); i += 2) {
            const auto &left = cameras[i], &right = cameras[i + 1];
            ASSERT_NE(left.at("name").get<std::string>().find("-left"), std::string::npos);
            const auto l = left.at("world_from_camera").get<std::vector<double>>(),
                       r = right.at("world_from_camera").get<std::vector<double>>();
            const glm::dvec3 apart{r[3] - l[3], r[7] - l[7], r[11] - l[11]};
            const double across = apart.x * l[0] + apart.y * l[4] + apart.z * l[8]; // along the left eye's x axis
            EXPECT_NEAR(across, 0.063, 1e-4);
            const std::string leftName = left.at("name"), rightName = right.at("name");
            const cv::Mat3b a = cv::imread(path("walk/" + leftName + ".png")),
                            b = cv::imread(path("walk/" + rightName + ".png"));
            const cv::Mat1f depth = cv::imread(path("drawn/" + leftName + "-depth.tiff"), cv::IMREAD_UNCHANGED);
            // Monado's eyes look straight ahead, with fields of view that mirror each other.
            const double fx = left.at("fx"), cxLeft = left.at("cx"), cxRight = right.at("cx");
            for (int y = 0; y < a.rows; y += 3)
                for (int x = 0; x < a.cols; x += 3) {
                    const double z = static_cast<double>(depth(y, x));
                    if (!(z > 0.3) || !std::isfinite(z)) continue;
                    const double shift = fx * across / z;
                    const auto differenceAt = [&](double u) {
                        const int column = static_cast<int>(std::floor(u));
                        if (column < 0 || column >= b.cols) return 255.0;
                        return cv::norm(cv::Vec3i(a(y, x)) - cv::Vec3i(b(y, column)));
                    };
                    const double straight = x + 0.5 - cxLeft + cxRight;
                    matched += std::min(differenceAt(straight - shift), 60.0);
                    mirrored += std::min(differenceAt(straight + shift), 60.0);
                    ++compared;
                }
        }
        ASSERT_GT(compared, 10000);
        std::printf("headset: parallax as it must be differs by %.2f, the other way round by %.2f\n",
                    matched / compared, mirrored / compared);
        EXPECT_LT(matched, 0.5 * mirrored);
    }

    scene::ScratchFolder scratch_;
};

TEST_F(InHeadset, TwoThousandFramesOfTheStreetCornerAreWhatRenderDraws) {
    makeScene("corner", 24, "320x240");
    walk(2000, 100);
    if (HasFatalFailure()) return;
    comparePictures(2 * 20);
    checkParallax();
}

TEST_F(InHeadset, TwoThousandFramesOfTheLivingRoomAreWhatRenderDraws) {
    const fs::path capture = tests::dataFolder() / "rgbd_livingroom1_synth";
    if (!fs::exists(capture)) GTEST_SKIP() << capture << " is not there";
    build(capture.string());
    walk(2000, 200);
    if (HasFatalFailure()) return;
    comparePictures(2 * 10);
    checkParallax();
}

} // namespace

} // namespace xr
