// Images that come and go by shares of their samples (scene/plan/walk_cells.h): none of one is as if it were not there,
// all is as if nobody had asked, and between the two just the samples that a hash names are drawn, more and more.

#include "render/shaders/shared/detail.h"
#include "tests/render/studio.h"
#include "tests/render/test_device.h"
#include "tests/render/test_scenes.h"

#include <algorithm>

namespace render {
namespace {

class SelectionTest : public RenderTest {
  protected:
    const scene::View eye_{cameraOf(200, 150, 1.3), poseAt({0.1, 0.02, 0.1}, 0.3, 0.1)};
};

TEST_F(SelectionTest, OfAllOfAllImagesItIsThePictureThatNobodyAskedFor) {
    const CutScene cut = cutInLevels(roomFromThreePlaces());
    GpuScene scene(testDevice(), cut.blocks());
    for (const Way& way : ways()) {
        scene.showOnly({});
        const EyeImage plain = drawOnce(scene, eye_, way.quality);
        const std::vector<float> all(3, 1.0f);
        scene.showOnly({all, all});
        EXPECT_TRUE(isSame(plain, drawOnce(scene, eye_, way.quality))) << way.name;
    }
}

TEST_F(SelectionTest, AnImageOfWhichNothingIsDrawnIsNotThere) {
    CutScene cut = cutInLevels(roomFromThreePlaces());
    GpuScene all(testDevice(), cut.blocks());
    const std::vector<float> shares{1, 1, 0};
    all.showOnly({shares, shares});
    cut.images.pop_back(), cut.sets.pop_back();
    const GpuScene two(testDevice(), cut.blocks());
    Painter paintAll(all, eye_.camera), paintTwo(two, eye_.camera);
    for (const Way& way : ways()) {
        const EyeImage left = paintAll(eye_, way.quality), without = paintTwo(eye_, way.quality);
        // What one image may add to a blended pixel hangs on how many there are, by a rounding.
        if (way.quality.isBlended)
            EXPECT_GE(psnrOf(left, without), 50) << way.name;
        else
            EXPECT_TRUE(isSame(left, without)) << way.name;
    }
}

/// Of image 2 only the samples of that share, taken out of its tiles by hand.
CutScene thinned(CutScene cut, float share) {
    scene::TileSet& set = cut.sets[2];
    for (scene::Tile& tile : set.tiles) {
        TileDraw draw{};
        draw.source = uvec4(static_cast<uint>(tile.x0), static_cast<uint>(tile.y0), 0, packSource(2, share));
        const auto first = set.vertices.begin() + tile.firstVertex;
        const auto end = std::stable_partition(first, first + tile.pointCount, [&](const scene::TileVertex& vertex) {
            const scene::VertexPlace place = scene::placeOf(tile, vertex);
            return isOfDetail(draw, place.x, place.y, 1);
        });
        tile.pointCount = static_cast<std::uint32_t>(end - first);
    }
    return cut;
}

TEST_F(SelectionTest, OfAShareTheSamplesThatTheHashNamesAreDrawn) {
    const CutScene whole = cut(roomFromThreePlaces());
    GpuScene scene(testDevice(), whole.blocks());
    Painter paint(scene, eye_.camera);
    std::size_t before = 0;
    for (const float share : {0.1f, 0.5f, 0.9f}) {
        const CutScene thin = thinned(whole, share);
        const std::size_t drawn = pointsOf(thin);
        EXPECT_GT(drawn, before);
        before = drawn;
        const double expected = static_cast<double>(pointsOf(whole)) * (2 + static_cast<double>(share)) / 3;
        EXPECT_NEAR(static_cast<double>(drawn), expected, 0.01 * expected);
        const GpuScene byHand(testDevice(), thin.blocks());
        const std::vector<float> shares{1, 1, share};
        scene.showOnly({shares, shares});
        Painter paintByHand(byHand, eye_.camera);
        for (const Warp warp : {Warp::points, Warp::splats})
            EXPECT_TRUE(isSame(paint(eye_, qualityOf(warp)), paintByHand(eye_, qualityOf(warp)))) << share;
    }
}

int pixelsThatDiffer(const EyeImage& a, const EyeImage& b) {
    int differ = 0;
    for (int y = 0; y < a.colour.height(); ++y)
        for (int x = 0; x < a.colour.width(); ++x)
            differ += a.colour(x, y) != b.colour(x, y) || a.pixelClass(x, y) != b.pixelClass(x, y) ? 1 : 0;
    return differ;
}

/// Of points most with the first samples, each of which shows in all of its pixels until those beside it have come.
TEST_F(SelectionTest, WhatComesInComesLittleByLittle) {
    constexpr int kSteps = 16;
    const CutScene cut = cutInLevels(roomFromThreePlaces());
    GpuScene scene(testDevice(), cut.blocks());
    Painter paint(scene, eye_.camera);
    for (const Warp warp : {Warp::points, Warp::mesh, Warp::adaptive, Warp::splats}) {
        const Quality quality = qualityOf(warp);
        std::vector<EyeImage> pictures;
        for (int i = 0; i <= kSteps; ++i) {
            const std::vector<float> shares{1, 1, static_cast<float>(i) / kSteps};
            scene.showOnly({shares, shares});
            pictures.push_back(paint(eye_, quality));
        }
        const int all = pixelsThatDiffer(pictures.front(), pictures.back());
        EXPECT_GT(all, 1000);
        for (int i = 1; i <= kSteps; ++i)
            EXPECT_LE(
                pixelsThatDiffer(pictures[static_cast<std::size_t>(i) - 1], pictures[static_cast<std::size_t>(i)]),
                warp == Warp::points ? all / 5 : 3 * all / kSteps)
                << "step " << i << " of warp " << static_cast<int>(warp);
    }
}

} // namespace
} // namespace render
