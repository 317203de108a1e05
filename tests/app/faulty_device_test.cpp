// Devices that fail: lost, full, or without what is needed. The programs run on one that is made faulty by a layer.

#include "tests/app/comparison.h"
#include "tests/app/made_sample.h"
#include "tests/app/program.h"
#include "tests/app/sample_scene.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <fstream>

namespace app {

namespace {

class FaultyDevice : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        const Outcome made =
            makeSample({path("capture"), "--scene", "room", "--images", "6", "--size", "96x72"}, scratch_.path());
        ASSERT_EQ(made.status, 0) << made.output;
        prepare(path("capture"), path("room.revisit"), scratch_.path(), {"--coverage"});
        nlohmann::json poses = nlohmann::json::array();
        for (int i = 0; i < 5; ++i)
            poses.push_back(
                {{"t", i * 0.25}, {"position", {0.025 * i, 1.5, 0.05 * i}}, {"orientation", {0, 0.05 * i, 0, 1}}});
        std::ofstream(path("path.json")) << nlohmann::json{{"space", "walk"}, {"poses", poses}}.dump();
    }

    static std::string path(const std::string& name) { return (scratch_.path() / name).string(); }

    /// faults: NAME=VALUE, see faulty_layer.cpp.
    static Outcome runWith(std::vector<std::string> faults, const std::vector<std::string>& command) {
        std::vector<std::string> all{"/usr/bin/env", "VK_LAYER_PATH=" REVISIT_FAULTY_LAYER,
                                     "VK_INSTANCE_LAYERS=VK_LAYER_REVISIT_faulty"};
        all.insert(all.end(), faults.begin(), faults.end());
        all.insert(all.end(), command.begin(), command.end());
        return run(all, scratch_.path());
    }

    static std::vector<std::string> walk(const std::string& out, const std::vector<std::string>& further = {}) {
        std::vector<std::string> command{kRevisit,
                                         "walk",
                                         path("room.revisit"),
                                         "--headless",
                                         "--path",
                                         path("path.json"),
                                         "--rate",
                                         "20",
                                         "--size",
                                         "80x60",
                                         "--out",
                                         path(out),
                                         "--record",
                                         path(out + ".json"),
                                         "--picture-every",
                                         "1"};
        command.insert(command.end(), further.begin(), further.end());
        return command;
    }
    static std::vector<std::string> render(const std::string& out, const std::vector<std::string>& further = {}) {
        std::vector<std::string> command{
            kRevisit,  "render", path("room.revisit"), "--path", path("path.json"), "--size", "80x60", "--out",
            path(out), "--aux"};
        command.insert(command.end(), further.begin(), further.end());
        return command;
    }

    /// What was drawn; reports tell times.
    static std::vector<std::pair<std::string, std::string>> picturesOf(const std::string& out) {
        auto files = filesOf(path(out));
        std::erase_if(files, [](const auto& file) { return file.first.ends_with(".json"); });
        return files;
    }
    struct Told {
        std::uint64_t submits = 0, mostBytes = 0;
    };
    static Told told(const std::string& file) {
        Told read;
        std::ifstream(path(file)) >> read.submits >> read.mostBytes;
        return read;
    }

    static inline const scene::ScratchFolder scratch_;
};

std::size_t linesWith(const std::string& text, const std::string& words) {
    std::size_t lines = 0;
    for (std::size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1))
        ++lines;
    return lines;
}

TEST_F(FaultyDevice, ALostOneIsMadeAnewAndTheSameFramesAreDrawn) {
    for (const bool walks : {true, false}) {
        const auto commandTo = [&](const std::string& out) { return walks ? walk(out) : render(out); };
        const Outcome sound = runWith({"REVISIT_FAULT_TELL=" + path("told")}, commandTo("sound"));
        ASSERT_EQ(sound.status, 0) << sound.output;
        const Told submits = told("told");
        ASSERT_GT(submits.submits, 4u);
        const auto expected = picturesOf("sound");
        ASSERT_GE(expected.size(), 6u);
        const std::string recorded = walks ? scene::bytesOfFile(path("sound.json")) : "";
        // In the first frame, in the middle, in the last one: each is one submit.
        for (const std::uint64_t at :
             {std::uint64_t{1}, submits.submits / 2, submits.submits / 2 + 1, submits.submits - 1, submits.submits}) {
            std::filesystem::remove_all(path("lost"));
            const Outcome lost = runWith({"REVISIT_FAULT_LOSE=" + std::to_string(at)}, commandTo("lost"));
            ASSERT_EQ(lost.status, 0) << lost.output;
            EXPECT_EQ(linesWith(lost.output, "the device was lost, and is made anew"), 1u) << lost.output;
            EXPECT_TRUE(picturesOf("lost") == expected) << "lost at submit " << at;
            if (walks) {
                EXPECT_EQ(scene::bytesOfFile(path("lost.json")), recorded) << "the same way, each place once";
            }
        }
        std::filesystem::remove_all(path("sound"));
    }
}

TEST_F(FaultyDevice, OneThatIsLostAgainAtOnceIsTheEnd) {
    for (const bool walks : {true, false}) {
        const Outcome lost = runWith({"REVISIT_FAULT_LOSE=3,4,5,6,7,8"}, walks ? walk("twice") : render("twice"));
        EXPECT_EQ(lost.status, 1) << lost.output;
        EXPECT_EQ(linesWith(lost.output, "the device was lost, and is made anew"), 1u) << lost.output;
        EXPECT_EQ(linesWith(lost.output, "the device was lost again"), 1u) << lost.output;
        const std::string last = lost.output.substr(lost.output.find("the device was lost again"));
        EXPECT_EQ(std::count(last.begin(), last.end(), '\n'), 1) << "and nothing after it:\n" << lost.output;
    }
}

TEST_F(FaultyDevice, OfAFullOneLessIsAsked) {
    for (const bool walks : {true, false}) {
        const auto draw = [&](const std::vector<std::string>& faults, const std::string& out,
                              const std::vector<std::string>& further) {
            std::filesystem::remove_all(path(out));
            return runWith(faults, walks ? walk(out, further) : render(out, further));
        };
        const std::string tell = "REVISIT_FAULT_TELL=" + path("told");
        ASSERT_EQ(draw({tell}, "wide", {"--warp", "points", "--resolution-scale", "2"}).status, 0);
        const std::uint64_t scaled = told("told").mostBytes;
        ASSERT_EQ(draw({tell}, "own", {"--warp", "points", "--resolution-scale", "1"}).status, 0);
        const std::uint64_t own = told("told").mostBytes;
        ASSERT_LT(own, scaled);

        const Outcome stepped = draw({"REVISIT_FAULT_MEMORY=" + std::to_string(scaled - 1)}, "stepped",
                                     {"--warp", "points", "--resolution-scale", "2"});
        EXPECT_EQ(stepped.status, 0) << stepped.output;
        EXPECT_EQ(linesWith(stepped.output, "no memory for another resolution"), 1u) << stepped.output;
        EXPECT_TRUE(picturesOf("stepped") == picturesOf("own"));

        ASSERT_EQ(draw({tell}, "blended", {"--warp", "blended"}).status, 0);
        const Outcome unblended = draw({"REVISIT_FAULT_MEMORY=" + std::to_string(told("told").mostBytes - 1)},
                                       "unblended", {"--warp", "blended"});
        EXPECT_EQ(unblended.status, 0) << unblended.output;
        EXPECT_EQ(linesWith(unblended.output, "no memory to blend"), 1u) << unblended.output;
        EXPECT_EQ(picturesOf("unblended").size(), picturesOf("blended").size());
        EXPECT_FALSE(picturesOf("unblended") == picturesOf("blended"));

        const std::vector<std::string> plainly{"--warp", "points", "--resolution-scale", "1"};
        const Outcome coarser = draw({"REVISIT_FAULT_MEMORY=" + std::to_string(own - 1)}, "coarser", plainly);
        EXPECT_EQ(coarser.status, 0) << coarser.output;
        EXPECT_EQ(linesWith(coarser.output, "what nobody saw is told by cells of"), 1u) << coarser.output;
        EXPECT_EQ(linesWith(coarser.output, "emptiness"), 0u) << coarser.output;

        std::vector<std::string> coarsest = plainly;
        coarsest.insert(coarsest.end(), {"--coverage-cell", "100"});
        ASSERT_EQ(draw({tell}, "coarsest", coarsest).status, 0);
        const Outcome emptied =
            draw({"REVISIT_FAULT_MEMORY=" + std::to_string(told("told").mostBytes - 1)}, "emptied", plainly);
        EXPECT_EQ(emptied.status, 0) << emptied.output;
        EXPECT_EQ(linesWith(emptied.output, "what nobody saw is shown as emptiness"), 1u) << emptied.output;

        const Outcome small = draw({"REVISIT_FAULT_MEMORY=10000"}, "small", {});
        EXPECT_EQ(small.status, 1);
        EXPECT_EQ(linesWith(small.output, "out of device memory"), 1u) << small.output;
    }
}

TEST_F(FaultyDevice, UnseenSpaceIsToldAsFinelyAsThereIsRoomFor) {
    const auto coverageOf = [&](const std::string& out, const std::vector<std::string>& further, std::string& says) {
        const Outcome drawn = runWith({}, render(out, further));
        EXPECT_EQ(drawn.status, 0) << drawn.output;
        says = drawn.output;
        return nlohmann::json::parse(std::ifstream(path(out + "/report.json"))).at("coverage");
    };
    std::string says;
    const nlohmann::json built = coverageOf("built", {}, says);
    EXPECT_GT(built.at("levels"), 4);
    EXPECT_LT(built.at("finest_m"), 0.01);
    EXPECT_EQ(linesWith(says, "told by cells"), 0u) << says;
    const nlohmann::json wished = coverageOf("wished", {"--coverage-cell", "0.02"}, says);
    EXPECT_GE(wished.at("finest_m"), 0.02);
    EXPECT_LT(wished.at("finest_m"), 0.08) << "and no coarser than need be";
    EXPECT_LT(wished.at("bytes"), built.at("bytes"));
    EXPECT_EQ(linesWith(says, "told by cells"), 0u) << "it was asked for:\n" << says;
    const nlohmann::json little = coverageOf("little", {"--memory", "8M"}, says);
    EXPECT_EQ(little.at("levels"), 4);
    EXPECT_EQ(linesWith(says, "told by cells of"), 1u) << says;
    EXPECT_EQ(linesWith(says, "(it may take a quarter of --memory)"), 1u) << says;
    EXPECT_TRUE(coverageOf("hidden", {"--hide-unseen"}, says).is_null());
    const auto share = [&](const std::string& out) {
        std::size_t unseen = 0, all = 0;
        for (const auto& [name, bytes] : picturesOf(out)) {
            if (!name.ends_with("-class.png")) continue;
            const cv::Mat classes = cv::imread(path(out + "/" + name), cv::IMREAD_UNCHANGED);
            unseen += static_cast<std::size_t>(cv::countNonZero(classes == 3)), all += classes.total();
        }
        return static_cast<double>(unseen) / static_cast<double>(all);
    };
    EXPECT_GT(share("built"), 0.02);
    EXPECT_NEAR(share("wished") / share("built"), 1, 0.1);
    EXPECT_EQ(share("hidden"), 0);
}

TEST_F(FaultyDevice, WhatOneLacksIsSaid) {
    const Outcome drawn = runWith({"REVISIT_FAULT_LACKS=1"}, render("lacking"));
    EXPECT_EQ(drawn.status, 1);
    EXPECT_EQ(linesWith(drawn.output, "lacks shaderBufferInt64Atomics"), 1u) << drawn.output;
}

} // namespace

} // namespace app
