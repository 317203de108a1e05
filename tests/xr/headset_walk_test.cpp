// A walk in a headset while the head moves: what the runtime was given is what `revisit render` draws from there, and
// what one eye sees lies against the other's as geometry wants it.

#include "tests/app/comparison.h"
#include "tests/app/sample_scene.h"
#include "tests/app/walker.h"
#include "tests/repetitions.h"
#include "tests/shared_data.h"
#include "tests/xr/monado.h"
#include "tests/xr/remote_head.h"

#include "render/quality.h"
#include "scene/scene_file.h"
#include "scene/warp.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <thread>

#include <poll.h>

namespace xr {

namespace {

using app::readJson;
using nlohmann::json;

constexpr double kEyesApartMetres = 0.063; ///< as Monado's remote head has them
const int kFrames = tests::areLong() ? 2000 : 1000;
constexpr int kPictureEvery = 100;

/// About the place where a walk begins: to and fro, up and down, looking around.
RemotePose onTheWay(double seconds) {
    const double yaw = 0.4 * std::sin(0.9 * seconds), pitch = 0.15 * std::sin(1.7 * seconds);
    const glm::dvec3 p{0.4 * std::sin(0.7 * seconds), 1.6 + 0.2 * std::sin(1.1 * seconds),
                       -0.5 * std::sin(0.5 * seconds)};
    const double cy = std::cos(yaw / 2), sy = std::sin(yaw / 2), cp = std::cos(pitch / 2), sp = std::sin(pitch / 2);
    const glm::dvec4 q{cy * sp, sy * cp, -sy * sp, cy * cp};
    return {{static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z), static_cast<float>(q.w)},
            {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)}};
}

/// Moves the head for as long as it lives.
class MovingHead {
  public:
    explicit MovingHead(std::uint16_t port) : thread_([this, port] { move(port); }) {}
    ~MovingHead() {
        isOver_ = true;
        thread_.join();
    }

  private:
    void move(std::uint16_t port) {
        constexpr int kStepMilliseconds = 4;
        try {
            RemoteHead head(port);
            const auto start = std::chrono::steady_clock::now();
            while (!isOver_) {
                const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
                RemoteState state{.stageFromHead = onTheWay(passed.count())};
                state.left.active = state.right.active = false; // else the walker would be shown them
                head.send(state);
                poll(nullptr, 0, kStepMilliseconds);
            }
        } catch (const std::runtime_error&) {
            // The program is over, and its runtime with it.
        }
    }

    std::atomic<bool> isOver_ = false;
    std::thread thread_;
};

scene::View viewOf(const json& camera) {
    scene::View view;
    view.camera = {camera.at("width"), camera.at("height"), camera.at("fx"),
                   camera.at("fy"),    camera.at("cx"),     camera.at("cy")};
    const json& m = camera.at("world_from_camera");
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
            view.worldFromEye.rotation[column][row] = m.at(static_cast<std::size_t>(4 * row + column));
        view.worldFromEye.translation[row] = m.at(static_cast<std::size_t>(4 * row + 3));
    }
    return view;
}

double psnrOfWhole(const cv::Mat3b& a, const cv::Mat3b& b) {
    return app::psnr(a, b, cv::Mat1b(a.size(), std::uint8_t{1}));
}

/// As the processor's warp of points has it, without what is done to a picture besides.
std::vector<std::string> bare(std::vector<std::string> command) {
    for (const char* knob : {"--hole-radius", "0", "--footprint-scale", "1", "--sample-pixels", "0", "--squares-near",
                             "false", "--interpolate-samples", "false"})
        command.emplace_back(knob);
    return command;
}

/// One picture of a walk, and the same drawn by `revisit render`.
struct Drawn {
    scene::View view;
    cv::Mat3b inHeadset, byRender;
    cv::Mat1f depth; ///< metres along z, by render
};

class HeadsetWalk : public testing::Test {
  protected:
    void SetUp() override {
        if (!isMonadoThere()) GTEST_SKIP() << "Monado is missing";
    }

    /// Walks, draws the kept pictures again; left and right by turns.
    std::vector<Drawn> walkAndDraw(const std::string& scene, const MonadoOptions& options) {
        const Monado monado(Variant::inproc, options);
        const std::string out = (scratch_ / "out").string(), frames = (scratch_ / "frames").string();
        {
            app::Walker walker(
                monado.around(bare({REVISIT_PROGRAM, "walk", scene, "--out", out, "--picture-every",
                                    std::to_string(kPictureEvery), "--frames", std::to_string(kFrames)})),
                scratch_.path());
            const MovingHead head(monado.port());
            const app::Outcome walked = walker.waitForEnd();
            EXPECT_EQ(walked.status, 0) << walked.output;
            EXPECT_EQ(monado.validationMessages(), "");
        }
        const json report = readJson(out + "/report.json");
        EXPECT_EQ(report.at("frames"), kFrames);
        EXPECT_GT(report.at("display_refreshes_missed"), 0) << "pictures are kept, which holds frames up";
        const app::Outcome drawn = app::run(bare({REVISIT_PROGRAM, "render", scene, "--out", frames, "--cameras",
                                                  out + "/cameras.json", "--eyes", "1", "--aux"}),
                                            scratch_.path());
        EXPECT_EQ(drawn.status, 0) << drawn.output;
        const json cameras = readJson(out + "/cameras.json").at("cameras");
        EXPECT_EQ(cameras.size(), static_cast<std::size_t>(2 * kFrames / kPictureEvery));
        std::vector<Drawn> pictures;
        for (const json& camera : cameras) {
            const std::string name = camera.at("name");
            pictures.push_back({viewOf(camera), cv::imread(out + "/" + name + ".png", cv::IMREAD_COLOR),
                                cv::imread(frames + "/" + name + ".png", cv::IMREAD_COLOR),
                                cv::imread(frames + "/" + name + "-depth.tiff", cv::IMREAD_UNCHANGED)});
        }
        return pictures;
    }

    /// A file of names that leaves every so-many-th image of a folder: preparing all costs more than walking.
    std::filesystem::path allButEvery(std::size_t count, const std::filesystem::path& images) const {
        std::vector<std::string> names;
        for (const auto& entry : std::filesystem::directory_iterator(images))
            names.push_back(entry.path().stem().string());
        std::sort(names.begin(), names.end());
        std::string text;
        for (std::size_t i = 0; i < names.size(); ++i)
            if (i % count != 0) text += names[i] + "\n";
        scene::writeFile(scratch_ / "held-out.txt", text);
        return scratch_ / "held-out.txt";
    }

    scene::ScratchFolder scratch_;
};

void expectWhatRenderDraws(const std::vector<Drawn>& pictures) {
    double shares = 0;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        const Drawn& picture = pictures[i];
        ASSERT_FALSE(picture.inHeadset.empty() || picture.byRender.empty()) << i;
        ASSERT_EQ(picture.inHeadset.size(), picture.byRender.size());
        EXPECT_GE(psnrOfWhole(picture.inHeadset, picture.byRender), 45) << "picture " << i;
        // The head goes by the clock: one picture in forty may show a little less than a quarter of the room.
        const double share = cv::countNonZero(picture.depth) / static_cast<double>(picture.depth.total());
        EXPECT_GT(share, 0.125) << "picture " << i;
        shares += share;
    }
    EXPECT_GT(shares, 0.25 * static_cast<double>(pictures.size()));
}

void expectThatTheHeadMoved(const std::vector<Drawn>& pictures) {
    int moved = 0;
    for (std::size_t i = 2; i < pictures.size(); ++i) {
        const double metres =
            glm::length(pictures[i].view.worldFromEye.translation - pictures[i - 2].view.worldFromEye.translation);
        if (metres > 0.01 && psnrOfWhole(pictures[i].inHeadset, pictures[i - 2].inHeadset) < 35) ++moved;
    }
    EXPECT_GE(moved, static_cast<int>(pictures.size()) * 2 / 3) << "of " << pictures.size() << " pictures";
}

/// A sample at depth z stands fx b / z pixels farther left in the right eye: of all multiples of that shift, the one
/// with factor 1 makes the eyes' pictures alike.
void expectTheRightParallax(const std::vector<Drawn>& pictures) {
    constexpr int kSteps = 8; ///< of a quarter, to each side of nothing
    std::array<double, 2 * kSteps + 1> difference{};
    std::size_t samples = 0;
    double pixels = 0;
    for (std::size_t i = 0; i + 1 < pictures.size(); i += 2) {
        const Drawn &left = pictures[i], &right = pictures[i + 1];
        const scene::Pose leftFromRight = inverse(left.view.worldFromEye) * right.view.worldFromEye;
        EXPECT_LE(glm::length(leftFromRight.translation - glm::dvec3(kEyesApartMetres, 0, 0)), 1e-5);
        // Of eyes that see to different sides, the same direction stands at other pixels.
        const double offset = right.view.camera.cx - left.view.camera.cx, fx = left.view.camera.fx;
        for (int y = 0; y < left.depth.rows; ++y)
            for (int x = 0; x < left.depth.cols; ++x) {
                const double z = static_cast<double>(left.depth(y, x));
                if (!(z > 0) || !std::isfinite(z)) continue;
                const double shift = fx * kEyesApartMetres / z;
                if (shift < 1 || x + offset < 2 * shift + 1 || x + offset > left.depth.cols - 2 * shift - 2) continue;
                ++samples;
                pixels += shift;
                for (int step = -kSteps; step <= kSteps; ++step) {
                    const double at = x + offset - 0.25 * step * shift;
                    const int u = static_cast<int>(std::floor(at));
                    for (int c = 0; c < 3; ++c) {
                        const double seen =
                            right.inHeadset(y, u)[c] * (1 - (at - u)) + right.inHeadset(y, u + 1)[c] * (at - u);
                        difference[static_cast<std::size_t>(step + kSteps)] += std::abs(seen - left.inHeadset(y, x)[c]);
                    }
                }
            }
    }
    ASSERT_GT(samples, 5000u);
    const auto best = std::min_element(difference.begin(), difference.end()) - difference.begin() - kSteps;
    std::printf(
        "parallax: %zu samples, %.2f pixels on average, best at %.2f of it; difference %.2f, without parallax %.2f\n",
        samples, pixels / static_cast<double>(samples), 0.25 * static_cast<double>(best),
        difference[kSteps + 4] / static_cast<double>(3 * samples),
        difference[kSteps] / static_cast<double>(3 * samples));
    EXPECT_EQ(best, 4) << "quarters of the shift that geometry wants";
}

/// The right eye by the processor, 63 mm beside the left one.
void expectTheProcessorsWarp(const std::vector<Drawn>& pictures, const std::string& scenePath) {
    const scene::Scene scene = scene::openScene(scenePath);
    for (const std::size_t i : {std::size_t{0}, pictures.size() / 4 * 2}) {
        scene::View eye = pictures[i].view;
        eye.camera = pictures[i + 1].view.camera;
        eye.worldFromEye.translation += kEyesApartMetres * eye.worldFromEye.rotation[0];
        scene::ZBuffer zBuffer(eye.camera.width, eye.camera.height, 0);
        scene::WarpOptions options;
        options.maxFootprint = render::Quality{}.maxFootprint;
        scene::warpPoints(scene.blocks, eye, options, zBuffer);
        const scene::EyeImage oracle = scene::resolve(zBuffer);
        cv::Mat3b truth(eye.camera.height, eye.camera.width);
        for (int y = 0; y < truth.rows; ++y)
            for (int x = 0; x < truth.cols; ++x) {
                const scene::Rgb8 c = oracle.colour(x, y);
                truth(y, x) = {c.b, c.g, c.r};
            }
        const double right = psnrOfWhole(pictures[i + 1].inHeadset, truth),
                     left = psnrOfWhole(pictures[i].inHeadset, truth);
        std::printf("the processor's right eye: %.1f dB against the headset's right, %.1f dB against its left\n", right,
                    left);
        EXPECT_GE(right, 40);
        EXPECT_LT(left, right - 10);
    }
}

TEST_F(HeadsetWalk, TheStreetCornerIsDrawnForEachEyeWhileTheHeadMoves) {
    const app::SampleScene corner("corner", 12, "240x180");
    const auto pictures = walkAndDraw(corner.scene(), {.hertz = 200, .width = 240, .height = 180, .validation = true});
    ASSERT_FALSE(HasFailure());
    expectWhatRenderDraws(pictures);
    expectThatTheHeadMoved(pictures);
    expectTheRightParallax(pictures);
    expectTheProcessorsWarp(pictures, corner.scene());
}

TEST_F(HeadsetWalk, TheLivingRoomIsDrawnForEachEyeWhileTheHeadMoves) {
    const std::filesystem::path capture = tests::dataFolder() / "rgbd_livingroom1_synth";
    if (!std::filesystem::exists(capture)) GTEST_SKIP() << "because there is no " << capture;
    const std::string room = (scratch_ / "room.revisit").string();
    // So many that wherever the head is, which goes by the clock, enough of the room is before it.
    // How exact the scene is does not matter here, nor from how many sides each surface is kept: once is enough.
    app::prepare(capture.string(), room, scratch_.path(),
                 {"--hold-out", allButEvery(10, capture / "image").string(), "--register", "given", "--no-silhouettes",
                  "--cull-baseline", "0"});
    const auto pictures = walkAndDraw(room, {.hertz = 200, .width = 192, .height = 144, .validation = true});
    ASSERT_FALSE(HasFailure());
    expectWhatRenderDraws(pictures);
    expectThatTheHeadMoved(pictures);
    expectTheRightParallax(pictures);
    expectTheProcessorsWarp(pictures, room);
}

} // namespace

} // namespace xr
