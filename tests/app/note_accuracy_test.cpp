// How exactly notes are known, by what scene.json says of set-ups.

#include "app/note_accuracy.h"

#include "tests/scene/known_scenes.h"
#include "tests/scene/tiled.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace app {
namespace {

using nlohmann::json;

constexpr double kFocal = 300, kOfSpacing = 2 / kFocal / 3.4641016;

/// Walls 2 m before cameras 10 m apart, all of one plane without noise.
class KnownTo : public testing::Test {
  protected:
    void lookFrom(const std::vector<std::string>& names, const std::vector<glm::dvec3>& places) {
        std::vector<scene::DepthImage> images;
        for (std::size_t i = 0; i < names.size(); ++i) {
            scene::Pose pose;
            pose.translation = places[i];
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
        return {
            {"name", name}, {"registered", true}, {"group", group}, {"deviation_m", deviation}, {"deviation_deg", 0.1}};
    }

    scene::Scene scene_;
    std::optional<scene::Tiled> tiled_;
};

TEST_F(KnownTo, PlacesToTheSpacingOfTheirSamples) {
    lookFrom({"a-front"}, {glm::dvec3(0)});
    const NoteAccuracy accuracy = with(json::object());
    EXPECT_NEAR(accuracy.ofPlace({0, 0, 2}).value(), kOfSpacing, 1e-4);
    EXPECT_FALSE(accuracy.ofPlace({0, 0, 1}));
    EXPECT_NEAR(accuracy.ofDistance({-0.1, 0, 2}, {0.1, 0, 2}).value(), std::sqrt(2.0) * kOfSpacing, 1e-4);
    EXPECT_FALSE(accuracy.ofDistance({-0.1, 0, 2}, {0.1, 0, 1}));
}

TEST_F(KnownTo, DistancesBetweenScansToHowFarThoseAreApart) {
    lookFrom({"a-front", "b-left-2", "c-up", "d-up"}, {glm::dvec3(0), {10, 0, 0}, {20, 0, 0}, {30, 0, 0}});
    const glm::dvec3 inA(0, 0, 2), inB(10, 0, 2), inC(20, 0, 2), inD(30, 0, 2);
    const double ends = 2 * kOfSpacing * kOfSpacing;
    const NoteAccuracy accuracy =
        with({{"scan_agreement", {{"pairs", {{{"a", "b"}, {"b", "a"}, {"apart_m", 0.02}}}}}},
              {"registration",
               {{"scans", {scan("a", "a", 0), scan("b", "a", 0.01), scan("c", "a", 0.03), scan("d", "d", 0)}}}}});
    EXPECT_NEAR(accuracy.ofDistance(inA, inB).value(), std::sqrt(ends + std::pow(1.4826 * 0.02, 2)), 1e-4);
    const double turned = 2 * 0.1 / 57.29578;
    EXPECT_NEAR(accuracy.ofDistance(inB, inC).value(),
                std::sqrt(ends + 0.01 * 0.01 + 0.03 * 0.03 + 2 * turned * turned), 1e-4)
        << "nothing in common: by way of a";
    EXPECT_FALSE(accuracy.ofDistance(inA, inD)) << "nothing joins them";
    EXPECT_FALSE(with(json::object()).ofDistance(inA, inB)) << "as their files have them: nobody compared them";
    EXPECT_TRUE(with({{"polygons", json::object()}}).ofDistance(inA, inB)) << "ray-traced: exact";
    EXPECT_FALSE(with({{"scan_agreement", {{"pairs", 3}}}}).ofDistance(inA, inB)) << "of another version";
}

TEST_F(KnownTo, ScansThatLieOnEachOtherMayHaveSlid) {
    lookFrom({"a-front", "b-front"}, {glm::dvec3(0), {10, 0, 0}});
    const NoteAccuracy accuracy = with({{"scan_agreement", {{"pairs", {{{"a", "a"}, {"b", "b"}, {"apart_m", 0.001}}}}}},
                                        {"registration", {{"scans", {scan("a", "a", 0), scan("b", "a", 0.05)}}}}});
    EXPECT_GT(accuracy.ofDistance({0, 0, 2}, {10, 0, 2}).value(), 0.05);
}

TEST_F(KnownTo, ScansInTheCoordinatesOfTheSiteAreNotOneSetUp) {
    lookFrom({"a-front", "b-front", "b-left"}, {glm::dvec3(0), glm::dvec3(0), glm::dvec3(0)});
    std::vector<scene::DepthImage> images = tiled_->images;
    for (int x = 0; x < 120; ++x) // each shows another part of one wall
        for (int y = 0; y < 90; ++y)
            for (int i = 0; i < 3; ++i)
                images[static_cast<std::size_t>(i)].flags(x, y) = x / 40 == i ? 0 : scene::kNoSurface;
    tiled_.emplace(std::move(images));
    scene_.blocks = tiled_->blocks;
    const glm::dvec3 inA(-0.3, 0, 2), inFront(0, 0, 2), inLeft(0.3, 0, 2);
    const NoteAccuracy accuracy =
        with({{"scan_agreement", {{"pairs", {{{"a", "a"}, {"b", "b"}, {"apart_m", 0.05}}}}}}});
    EXPECT_GT(accuracy.ofDistance(inA, inFront).value(), 0.05);
    EXPECT_LT(accuracy.ofDistance(inFront, inLeft).value(), 0.005) << "one scan's";
}

TEST_F(KnownTo, DistancesBetweenPhotographsToHowFarTheirSurfacesAreWhereOneShowsBoth) {
    const json manifest{{"poses",
                         {{"after", {{"range_share", 0.01}}},
                          {"images",
                           {{{"name", "one"}, {"place", "adjusted"}},
                            {{"name", "two"}, {"place", "given"}},
                            {{"name", "behind"}, {"place", "given"}}}}}}};
    const glm::dvec3 inOne(-0.3, 0, 2), inTwo(0.7, 0, 2);
    lookFrom({"one", "two"}, {glm::dvec3(0), {0.5, 0, 0}});
    EXPECT_FALSE(with(manifest).ofDistance(inOne, inTwo)) << "neither shows what the other does: a chain";
    EXPECT_TRUE(with(manifest).ofDistance(inOne, {-0.1, 0, 2})) << "one image's";
    scene_.images.clear();
    lookFrom({"one", "two", "behind"}, {glm::dvec3(0), {0.5, 0, 0}, {0.2, 0, -3}});
    const double range = glm::length(glm::dvec3(0.3, 0, 2));
    EXPECT_NEAR(with(manifest).ofDistance(inOne, inTwo).value(),
                std::sqrt(2 * kOfSpacing * kOfSpacing + std::pow(1.4826 * 0.01 * range, 2)), 3e-4);
    json loose = manifest;
    loose["poses"]["images"][1]["place"] = "loose";
    EXPECT_FALSE(with(loose).ofDistance(inOne, inTwo));
}

} // namespace
} // namespace app
