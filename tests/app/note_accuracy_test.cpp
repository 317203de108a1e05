// How exactly notes are known, by what scene.json says of set-ups.

#include "app/note_accuracy.h"

#include "tests/scene/known_scenes.h"
#include "tests/scene/tiled.h"

#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace app {
namespace {

using nlohmann::json;

constexpr double kFocal = 300, kOfSpacing = 2 / kFocal / 3.4641016;

/// Walls 2 m before cameras 10 m apart, all of one plane without noise.
class KnownTo : public testing::Test {
  protected:
    void lookFrom(const std::vector<std::string>& names, const std::vector<double>& x) {
        std::vector<scene::DepthImage> images;
        for (std::size_t i = 0; i < names.size(); ++i) {
            scene::Pose pose;
            pose.translation.x = x[i];
            images.push_back(
                scene::imageOf({120, 90, kFocal, kFocal, 60, 45}, pose, [](double, double) { return 0.5; }));
            scene_.images.push_back({names[i], images.back().camera, pose});
        }
        tiled_.emplace(std::move(images));
        scene_.blocks = tiled_->blocks;
    }
    NoteAccuracy with(const json& manifest) {
        scene_.manifest = manifest.dump();
        return NoteAccuracy(scene_);
    }
    static json scan(const char* name, const char* group, double deviation) {
        return {{"name", name}, {"registered", true}, {"group", group}, {"deviation_m", deviation}};
    }

    scene::Scene scene_;
    std::optional<scene::Tiled> tiled_;
};

TEST_F(KnownTo, PlacesToTheSpacingOfTheirSamples) {
    lookFrom({"a-front"}, {0});
    const NoteAccuracy accuracy = with(json::object());
    EXPECT_NEAR(accuracy.ofPlace({0, 0, 2}).value(), kOfSpacing, 1e-4);
    EXPECT_FALSE(accuracy.ofPlace({0, 0, 1}));
    EXPECT_NEAR(accuracy.ofDistance({-0.1, 0, 2}, {0.1, 0, 2}).value(), std::sqrt(2.0) * kOfSpacing, 1e-4);
    EXPECT_FALSE(accuracy.ofDistance({-0.1, 0, 2}, {0.1, 0, 1}));
}

TEST_F(KnownTo, DistancesBetweenScansToHowFarThoseAreApart) {
    lookFrom({"a-front", "b-left-2", "c-up", "d-up"}, {0, 10, 20, 30});
    const glm::dvec3 inA(0, 0, 2), inB(10, 0, 2), inC(20, 0, 2), inD(30, 0, 2);
    const double ends = 2 * kOfSpacing * kOfSpacing;
    const NoteAccuracy accuracy =
        with({{"scan_agreement", {{"pairs", {{{"a", "b"}, {"b", "a"}, {"apart_m", 0.02}}}}}},
              {"registration",
               {{"scans", {scan("a", "a", 0), scan("b", "a", 0.01), scan("c", "a", 0.03), scan("d", "d", 0)}}}}});
    EXPECT_NEAR(accuracy.ofDistance(inA, inB).value(), std::sqrt(ends + std::pow(1.4826 * 0.02, 2)), 1e-4);
    EXPECT_NEAR(accuracy.ofDistance(inB, inC).value(), std::sqrt(ends + 0.01 * 0.01 + 0.03 * 0.03), 1e-4)
        << "nothing in common: by way of a";
    EXPECT_FALSE(accuracy.ofDistance(inA, inD)) << "nothing joins them";
    EXPECT_FALSE(with(json::object()).ofDistance(inA, inB)) << "as their files have them: nobody compared them";
    EXPECT_TRUE(with({{"polygons", json::object()}}).ofDistance(inA, inB)) << "ray-traced: exact";
    EXPECT_FALSE(with({{"scan_agreement", {{"pairs", 3}}}}).ofDistance(inA, inB)) << "of another version";
}

TEST_F(KnownTo, DistancesBetweenPhotographsToHowFarTheirSurfacesAre) {
    lookFrom({"one", "two"}, {0, 10});
    const NoteAccuracy accuracy = with({{"poses", {{"after", {{"range_share", 0.01}}}}}});
    EXPECT_NEAR(accuracy.ofDistance({0, 0, 2}, {10, 0, 2}).value(),
                std::sqrt(2 * kOfSpacing * kOfSpacing + std::pow(1.4826 * 0.01 * 2, 2)), 1e-4);
}

} // namespace
} // namespace app
