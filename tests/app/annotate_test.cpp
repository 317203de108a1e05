// A walker notes: aim, press, undo, and the file and the picture that come of it.

#include "app/annotate.h"

#include "app/model_aim.h"
#include "app/overlays.h"
#include "scene/tile.h"
#include "tests/scene/scratch_folder.h"

#include <algorithm>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

namespace app {
namespace {

/// A wall 2 m before a camera at the origin; the left of it a guess.
class Annotating : public testing::Test {
  protected:
    Annotating() {
        const scene::Camera camera{200, 150, 150, 150, 100, 75};
        scene::DepthImage wall{"wall",
                               camera,
                               {},
                               scene::Image<scene::Rgb8>(200, 150, {90, 80, 70}),
                               scene::Image<float>(200, 150, 0.5f),
                               scene::Image<std::uint8_t>(200, 150, 0)};
        for (int y = 0; y < 150; ++y)
            for (int x = 0; x < 50; ++x)
                wall.flags(x, y) = scene::kNoSurface | scene::kInterpolated;
        tiles_ = scene::cutIntoTiles(wall);
        scene_.blocks = {scene::lend(tiles_, camera, {})};
    }
    static NotingWants aimAt(double x, double y, NoteMode mode = NoteMode::points) {
        return {.aim = scene::Ray{{0, 0, 0}, {x, y, 2}}, .mode = mode};
    }
    static NotingWants pressAt(double x, double y, NoteMode mode = NoteMode::points) {
        NotingWants wants = aimAt(x, y, mode);
        wants.presses = true;
        return wants;
    }
    static bool says(const render::Overlay& overlay, const std::string& text) {
        return std::any_of(overlay.labels.begin(), overlay.labels.end(),
                           [&](const render::Label& label) { return label.text == text; });
    }
    Notes onDisk() const { return NotesFile(scratch_.path()).read(); }
    std::filesystem::path file() const { return scratch_ / "notes.json"; }

    scene::ScratchFolder scratch_;
    scene::TileSet tiles_;
    scene::Scene scene_;
};

TEST_F(Annotating, APressNotesWhereTheAimMeetsTheScene) {
    Annotator annotator(scene_, scratch_.path());
    annotator.update(aimAt(0.3, 0.2));
    ASSERT_TRUE(annotator.aimedAt());
    EXPECT_LT(glm::distance(annotator.aimedAt()->position, {0.3, 0.2, 2}), 1e-4);
    EXPECT_FALSE(std::filesystem::exists(file())) << "aiming writes nothing";
    annotator.update(pressAt(0.3, 0.2));
    EXPECT_EQ(onDisk().list.at(0).label, "P1");
    EXPECT_LT(glm::distance(onDisk().list.at(0).from, {0.3, 0.2, 2}), 1e-4);
    EXPECT_EQ(annotator.takeNotice().substr(0, 5), "P1 at");
    EXPECT_EQ(annotator.takeNotice(), "") << "said once";
    render::Overlay overlay;
    annotator.appendTo(overlay);
    EXPECT_TRUE(says(overlay, "P1"));
}

TEST_F(Annotating, NothingIsNotedThroughAModelNorOnIt) {
    scene::PolygonScene model; // right of the middle, before the wall
    model.materials.emplace_back();
    scene::PolygonMesh& mesh = model.meshes.emplace_back();
    mesh.positions = {{0.1f, -1, 1.5f}, {1, -1, 1.5f}, {0.1f, 1, 1.5f}};
    mesh.triangles = {{0, 1, 2}};
    model.instances.push_back({});
    const ModelAim models(model);
    const auto pressThrough = [&](double x, double y) {
        NotingWants wants = pressAt(x, y);
        wants.model = models.meet(*wants.aim);
        return wants;
    };
    Annotator annotator(scene_, scratch_.path());
    annotator.update(pressThrough(0.3, 0));
    EXPECT_EQ(annotator.notes().list.size(), 0u);
    EXPECT_EQ(annotator.takeNotice(), "no range was measured there: only what was seen is noted");
    ASSERT_TRUE(annotator.aimedAt());
    EXPECT_LT(glm::distance(annotator.aimedAt()->position, {0.225, 0, 1.5}), 1e-6);
    EXPECT_LT(glm::distance(annotator.aimedAt()->normal.value(), {0, 0, -1}), 1e-6);
    annotator.update(pressThrough(-0.2, 0)); // beside it
    ASSERT_EQ(annotator.notes().list.size(), 1u);
    EXPECT_LT(glm::distance(annotator.notes().list[0].from, {-0.2, 0, 2}), 1e-4);
    // A model behind the wall is hidden by it.
    model.instances[0].worldFromMesh[3] = glm::dvec4(0, 0, 2, 1);
    const ModelAim behind(model);
    NotingWants wants = pressAt(0.3, 0);
    wants.model = behind.meet(*wants.aim);
    ASSERT_TRUE(wants.model);
    annotator.update(wants);
    EXPECT_EQ(annotator.notes().list.size(), 2u);
}

TEST_F(Annotating, ADistanceIsShownWhileItIsDrawnOut) {
    Annotator annotator(scene_, scratch_.path());
    annotator.update(pressAt(-0.2, 0, NoteMode::distances));
    EXPECT_FALSE(std::filesystem::exists(file()));
    annotator.update(aimAt(0.4, 0, NoteMode::distances));
    render::Overlay underWay;
    annotator.appendTo(underWay);
    EXPECT_TRUE(says(underWay, "0.600 m"));
    annotator.update(pressAt(0.8, 0, NoteMode::distances));
    EXPECT_EQ(onDisk().list.at(0).label, "D1 1.000 m +-0.006");
    annotator.update({});
    EXPECT_FALSE(annotator.aimedAt());
    render::Overlay done;
    annotator.appendTo(done);
    ASSERT_EQ(done.labels.size(), 1u);
    EXPECT_EQ(done.labels[0].text, "D1 1.000 m +-0.006");
    EXPECT_LT(glm::distance(done.labels[0].at, {0.3, 0.05, 2}), 1e-4);
}

TEST_F(Annotating, GuessesAndEmptySpaceAreNotNoted) {
    Annotator annotator(scene_, scratch_.path());
    annotator.update(pressAt(-1, 0));
    ASSERT_TRUE(annotator.aimedAt());
    EXPECT_FALSE(annotator.aimedAt()->isSeen);
    EXPECT_NE(annotator.takeNotice().find("no range was measured"), std::string::npos);
    render::Overlay overlay;
    annotator.appendTo(overlay);
    ASSERT_FALSE(overlay.segments.empty());
    EXPECT_EQ(overlay.segments[0].colour, kRefusedColour);
    annotator.update(pressAt(20, 0));
    EXPECT_NE(annotator.takeNotice().find("nothing"), std::string::npos);
    annotator.update({.aim = {}, .presses = true});
    EXPECT_TRUE(annotator.notes().list.empty());
    EXPECT_FALSE(std::filesystem::exists(file()));
}

TEST_F(Annotating, WhatTheUnseenHidesIsNotNoted) {
    scene_.coverage.emplace();
    scene_.coverage->cornerInWorld = {-2, -2, -2};
    scene_.coverage->edgeMetres = 4;
    scene_.coverage->nodes.resize(1);
    for (int y = 0; y < 4; ++y)
        scene_.coverage->nodes[0].unseen |= scene::coverageMask(scene::coverageBit(2, y, 3)); // before half of the wall
    Annotator annotator(scene_, scratch_.path());
    NotingWants behind = pressAt(0.3, 0.2), beside = pressAt(-0.3, 0.2);
    for (NotingWants* wants : {&behind, &beside})
        wants->shown.shownUnseen = &*scene_.coverage;
    annotator.update(behind);
    EXPECT_FALSE(annotator.aimedAt());
    EXPECT_NE(annotator.takeNotice().find("nothing"), std::string::npos);
    annotator.update(beside);
    EXPECT_TRUE(annotator.aimedAt());
    behind.shown.shownUnseen = nullptr;
    annotator.update(behind);
    EXPECT_TRUE(annotator.aimedAt()) << "nor is it hidden where the unseen is not shown";
}

TEST_F(Annotating, UndoIsWrittenAndStopsAtEarlierWalks) {
    {
        Annotator earlier(scene_, scratch_.path());
        earlier.update(pressAt(0, 0));
    }
    Annotator annotator(scene_, scratch_.path());
    ASSERT_EQ(annotator.notes().list.size(), 1u);
    annotator.update(pressAt(0.1, 0));
    EXPECT_EQ(onDisk().list.size(), 2u);
    const NotingWants undoes{.aim = {}, .undoes = true};
    annotator.takeNotice();
    annotator.update(undoes);
    EXPECT_EQ(onDisk().list.size(), 1u);
    EXPECT_EQ(annotator.takeNotice(), "P2 is taken back");
    annotator.update(undoes);
    EXPECT_EQ(onDisk().list.size(), 1u);
    EXPECT_EQ(annotator.takeNotice(), "nothing that was noted in this walk is left to take back");
}

TEST_F(Annotating, ABrokenFileIsSaidAndLeftAlone) {
    scene::writeFile(file(), "{ my own");
    Annotator annotator(scene_, scratch_.path());
    EXPECT_NE(annotator.takeNotice().find("notes.json"), std::string::npos);
    annotator.update(pressAt(0, 0));
    EXPECT_NE(annotator.takeNotice().find("notes.json"), std::string::npos) << "said again";
    EXPECT_TRUE(annotator.notes().list.empty());
    EXPECT_EQ(scene::bytesOfFile(file()), "{ my own");
}

TEST_F(Annotating, WhatCannotBeWrittenStaysInViewAndIsSaid) {
    Annotator annotator(scene_, scratch_ / "gone");
    annotator.update(pressAt(0, 0));
    EXPECT_NE(annotator.takeNotice().find("gone"), std::string::npos);
    EXPECT_EQ(annotator.notes().list.size(), 1u);
    std::filesystem::create_directory(scratch_ / "gone");
    annotator.update(pressAt(0.1, 0));
    EXPECT_EQ(NotesFile(scratch_ / "gone").read().list.size(), 2u) << "the next time all of it";
}

} // namespace
} // namespace app
