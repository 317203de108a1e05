// The knobs by name: what is written is read again, and what cannot be is refused in one line.

#include "app/draw_options.h"
#include "app/quality_file.h"
#include "scene/errors.h"
#include "tests/scene/scratch_folder.h"

#include <gtest/gtest.h>

#include <fstream>
#include <set>

namespace app {
namespace {

using nlohmann::json;

std::string failureOf(const std::function<void()>& work) {
    try {
        work();
    } catch (const scene::Failure& failure) {
        return failure.what();
    }
    return "";
}

TEST(QualityFile, EveryKnobIsToldApartAndComesBack) {
    std::set<std::string> names;
    for (const Knob& knob : knobs()) {
        EXPECT_TRUE(names.insert(knob.name).second) << knob.name << " stands twice";
        EXPECT_FALSE(knob.does.empty() || knob.values.empty()) << knob.name;
        // A tint is for eyes: there is nothing to measure.
        EXPECT_EQ(knob.tried.empty(), knob.name == "mark_unmeasured") << knob.name;
        for (const json& value : knob.tried.empty() ? std::vector<json>{true, false} : knob.tried) {
            render::Quality quality = presets().front().quality;
            const json before = toJson(quality);
            ASSERT_TRUE(knob.set(quality, value)) << knob.name << " " << value;
            EXPECT_EQ(knob.get(quality), value) << knob.name << " must be read as it was written";
            // Nothing else may turn with it.
            json after = toJson(quality);
            after[knob.name] = before[knob.name];
            EXPECT_EQ(after, before) << knob.name;
            EXPECT_EQ(toJson(qualityOf(toJson(quality), "here")), toJson(quality));
        }
    }
}

TEST(QualityFile, KnobsRefuseWhatTheyCannotBe) {
    for (const Knob& knob : knobs())
        for (const json& value : {json(-1e9), json(1e9), json(nullptr), json("no such name"), json::array({1})}) {
            render::Quality quality = presets().front().quality;
            const json before = toJson(quality);
            EXPECT_FALSE(knob.set(quality, value)) << knob.name << " took " << value;
            EXPECT_EQ(toJson(quality), before);
        }
    render::Quality quality;
    EXPECT_EQ(failureOf([&] { turnKnob(quality, "max_footprint", 2.5, "q.json"); }),
              "q.json: has max_footprint = 2.5; give a whole number of 1 to 64 pixels");
    EXPECT_NE(failureOf([&] { turnKnob(quality, "max_footprnt", 2, "q.json"); }).find("max_footprint"),
              std::string::npos)
        << "those that there are must be listed";
}

TEST(QualityFile, AFileStartsFromAPreset) {
    const render::Quality best = readQuality("best");
    const render::Quality turned = qualityOf({{"preset", "best"}, {"resolution_scale", 0.5}}, "here");
    EXPECT_EQ(turned.warp, best.warp);
    EXPECT_EQ(turned.resolutionScale, 0.5);
    EXPECT_EQ(toJson(qualityOf(json::object(), "here")), toJson(readQuality(kDefaultPreset)));
    EXPECT_NE(failureOf([] {
                  qualityOf({{"preset", "bset"}}, "here");
              }).find("fast, balanced, best"),
              std::string::npos);
    EXPECT_NE(failureOf([] { qualityOf(json::array(), "here"); }), "");
}

TEST(QualityFile, TheCommandLineWins) {
    const scene::ScratchFolder scratch;
    const std::string file = (scratch / "q.json").string();
    std::ofstream(file) << R"({"warp": "mesh", "resolution_scale": 0.5})";
    DrawOptions options;
    options.quality = file;
    options.turned = {{"resolution_scale", 2}, {"resolution_scale", 1.5}};
    const render::Quality quality = qualityOf(options);
    EXPECT_EQ(quality.warp, render::Warp::mesh);
    EXPECT_EQ(quality.resolutionScale, 1.5);
    EXPECT_NE(failureOf([] { readQuality("/no/such/file.json"); }).find("neither a preset nor a file"),
              std::string::npos);
}

TEST(QualityFile, SettingsHaveNames) {
    const scene::ScratchFolder scratch;
    const auto read = [&](const std::string& text) {
        std::ofstream(scratch / "s.json") << text;
        return readSettings(scratch / "s.json");
    };
    const std::vector<Preset> settings =
        read(R"({"settings": [{"name": "a", "warp": "mesh"}, {"name": "b", "preset": "fast"}]})");
    ASSERT_EQ(settings.size(), 2u);
    EXPECT_EQ(settings[0].quality.warp, render::Warp::mesh);
    EXPECT_EQ(toJson(settings[1].quality), toJson(readQuality("fast")));
    for (const char* bad : {"[]", R"({"settings": []})", R"({"settings": [{"warp": "mesh"}]})",
                            R"({"settings": [{"name": "a"}, {"name": "a"}]})",
                            R"({"settings": [{"name": "a", "x": 1}]})", R"({"settings": [3]})"})
        EXPECT_NE(failureOf([&] { read(bad); }).find("s.json"), std::string::npos) << bad;
}

} // namespace
} // namespace app
