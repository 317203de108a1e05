#include "app/positions.h"

#include "scene/errors.h"

#include "tests/scene/scratch_folder.h"

#include <CLI/Error.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace app {
namespace {

using scene::failureOf;
using testing::HasSubstr;

TEST(Positions, ACountOrAFile) {
    EXPECT_EQ(parsePositions("8").count, 8);
    EXPECT_TRUE(parsePositions("8").file.empty());
    EXPECT_EQ(parsePositions("places.json").file, "places.json");
    EXPECT_EQ(parsePositions("8.json").file, "8.json");
    for (const char* wrong : {"0", "-3", "1.5", "1e9", "nan"})
        EXPECT_THROW(parsePositions(wrong), CLI::ValidationError) << wrong;
}

TEST(Positions, ASunShinesFromSomewhere) {
    EXPECT_EQ(parseDirection({0, 2, 0}), glm::dvec3(0, 1, 0));
    EXPECT_THROW(parseDirection({0, 0, 0}), CLI::ValidationError);
    EXPECT_THROW(parseDirection({1e300, 1e300, 0}), CLI::ValidationError);
}

TEST(Positions, AFileOfPlaces) {
    const scene::ScratchFolder folder;
    const auto failureWith = [&](const std::string& text) {
        scene::writeFile(folder / "p.json", text);
        return failureOf<scene::Failure>([&] { readPositionsFile(folder / "p.json"); });
    };
    EXPECT_EQ(failureWith(R"({"positions": [[1, 2, 3], [4.5, -5, 6e2]]})"), "");
    EXPECT_EQ(readPositionsFile(folder / "p.json"), (std::vector<glm::dvec3>{{1, 2, 3}, {4.5, -5, 600}}));
    EXPECT_THAT(failureWith("{"), HasSubstr("not valid JSON"));
    EXPECT_THAT(failureWith("[]"), HasSubstr("no list of positions"));
    EXPECT_THAT(failureWith(R"({"positions": []})"), HasSubstr("no list of positions"));
    EXPECT_THAT(failureWith(R"({"positions": [[1, 2, 3], [1, 2]]})"), HasSubstr("position 1: is not three numbers"));
    EXPECT_THAT(failureWith(R"({"positions": [[1, 2, "x"]]})"), HasSubstr("position 0: is not three numbers"));
    EXPECT_THAT(failureWith(R"({"positions": [[1e200, 2, 3]]})"), HasSubstr("farther away"));
    EXPECT_THAT(failureOf<scene::Failure>([&] { readPositionsFile(folder / "none.json"); }), HasSubstr("no such file"));
}

TEST(Positions, BelongToPolygonsAlone) {
    scene::Capture photos, polygons;
    polygons.polygons.push_back("room.obj");
    EXPECT_EQ(failureOf<scene::Failure>([&] { checkPositionsWish({3, {}}, polygons); }), "");
    EXPECT_EQ(failureOf<scene::Failure>([&] { checkPositionsWish({}, photos); }), "");
    EXPECT_THAT(failureOf<scene::Failure>([&] { checkPositionsWish({}, polygons); }), HasSubstr("--positions 8"));
    EXPECT_THAT(failureOf<scene::Failure>([&] {
                    checkPositionsWish({0, "p.json"}, photos);
                }),
                HasSubstr("for polygons"));
}

} // namespace
} // namespace app
