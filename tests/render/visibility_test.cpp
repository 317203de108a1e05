#include "render/gpu_scene.h"
#include "render/visibility.h"
#include "tests/render/test_scenes.h"
#include "tests/scene/vector_widths.h"

#include <glm/matrix.hpp>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace render {
namespace {

/// Random boxes in an image of 4096 x 4096 samples.
struct Boxes {
    TileBounds bounds;
    BoundsExtent extent;
};

Boxes randomBoxes(std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    Boxes boxes;
    for (std::size_t i = 0; i < count; ++i) {
        scene::Tile tile;
        tile.x0 = static_cast<int>(unit(random) * 4060), tile.y0 = static_cast<int>(unit(random) * 4060);
        tile.width = tile.height = 32;
        tile.minDisparity = static_cast<float>(std::pow(unit(random), 3) * 5);
        tile.maxDisparity = tile.minDisparity + static_cast<float>(std::pow(unit(random), 4) * 2);
        boxes.bounds.append(tile, {4096, 4096, 1, 1, 0, 0});
    }
    boxes.extent = boxes.bounds.extentOf(0, count);
    return boxes;
}

scene::View randomView(std::mt19937& random, const scene::Camera& camera) {
    std::uniform_real_distribution<double> unit(-1, 1);
    return {camera,
            poseAt({unit(random) * 2, unit(random), unit(random) * 2}, 3.14 * unit(random), 1.5 * unit(random))};
}

bool isSeen(const glm::dmat4& c, double x, double y, double d, int width, int height) {
    const glm::dvec4 h = c * glm::dvec4(x, y, 1, d);
    return h.z > 0 && h.x >= 0 && h.x < width * h.z && h.y >= 0 && h.y < height * h.z;
}

/// Exactly, in double precision: is the whole box at least this far outside of one plane, relative to its
/// terms?
bool isClearlyOutside(const glm::dmat4& c, const TileBounds& b, std::size_t i, int width, int height, double slack) {
    const glm::dvec4 u(c[0][0], c[1][0], c[2][0], c[3][0]), v(c[0][1], c[1][1], c[2][1], c[3][1]),
        w(c[0][2], c[1][2], c[2][2], c[3][2]);
    for (const glm::dvec4& plane : {u, double(width) * w - u, v, double(height) * w - v, w}) {
        bool allOutside = true;
        for (const double x : {b.xMin[i], b.xMax[i]})
            for (const double y : {b.yMin[i], b.yMax[i]})
                for (const double d : {b.dMin[i], b.dMax[i]}) {
                    const double size =
                        std::abs(plane.x) * 4096 + std::abs(plane.y) * 4096 + std::abs(plane.z) + std::abs(plane.w) * 7;
                    allOutside = allOutside && plane.x * x + plane.y * y + plane.z + plane.w * d < -slack * size;
                }
        if (allOutside) return true;
    }
    return false;
}

TEST(Visibility, NeverRejectsWhatIsSeenAndRejectsWhatIsOutsideOnePlane) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(0, 1);
    const scene::Camera eye = cameraOf(640, 480, 1.6);
    const scene::Camera source = cameraOf(4096, 4096, 1.5708);
    std::size_t rejected = 0, tested = 0;
    for (int pose = 0; pose < 60; ++pose) {
        const Boxes boxes = randomBoxes(517, 100u + static_cast<unsigned>(pose));
        const TileBounds& b = boxes.bounds;
        const glm::dmat4 c = scene::eyeImageFromSourceImage(randomView(random, eye), source, {});
        const ImagePlanes planes = planesOf(c, 640, 480, 0, boxes.extent);
        std::vector<std::uint32_t> visible(b.size());
        visible.resize(findVisible(b, 0, b.size(), planes, visible.data()));
        std::vector<bool> isVisible(b.size(), false);
        for (const std::uint32_t i : visible)
            isVisible[i] = true;
        EXPECT_TRUE(std::is_sorted(visible.begin(), visible.end()));
        for (std::size_t i = 0; i < b.size(); ++i) {
            ++tested, rejected += !isVisible[i];
            if (isVisible[i]) {
                EXPECT_FALSE(isClearlyOutside(c, b, i, 640, 480, 4e-6)) << "pose " << pose << " tile " << i;
                continue;
            }
            for (int sample = 0; sample < 60; ++sample) {
                // The corners first, then anywhere inside.
                const double sx = sample < 8 ? sample & 1 : unit(random),
                             sy = sample < 8 ? sample >> 1 & 1 : unit(random),
                             sd = sample < 8 ? sample >> 2 & 1 : unit(random);
                EXPECT_FALSE(isSeen(c, b.xMin[i] + sx * (b.xMax[i] - b.xMin[i]),
                                    b.yMin[i] + sy * (b.yMax[i] - b.yMin[i]), b.dMin[i] + sd * (b.dMax[i] - b.dMin[i]),
                                    640, 480))
                    << "pose " << pose << " tile " << i;
            }
        }
    }
    EXPECT_GT(rejected, tested / 4);
    EXPECT_LT(rejected, tested);
}

/// Boxes that are points, as near to the left and upper edge of what is seen as single precision can put
/// them.
TEST(Visibility, NeverRejectsWhatIsSeenByAHair) {
    std::mt19937 random(33);
    std::uniform_real_distribution<double> unit(0, 1);
    const scene::Camera eye = cameraOf(640, 480, 1.6), source = cameraOf(4096, 4096, 1.5708);
    int seen = 0;
    for (int pose = 0; pose < 200; ++pose) {
        const glm::dmat4 c = scene::eyeImageFromSourceImage(randomView(random, eye), source, {});
        const glm::dmat4 back = glm::inverse(c);
        TileBounds bounds;
        for (int i = 0; i < 64; ++i) {
            const double alongEdge = 400 * unit(random), eyeDisparity = 0.1 + unit(random);
            const glm::dvec4 h = back * (i % 2 == 0 ? glm::dvec4(0, alongEdge, 1, eyeDisparity)
                                                    : glm::dvec4(alongEdge, 0, 1, eyeDisparity));
            const glm::dvec3 sample(h.x / h.z, h.y / h.z, h.w / h.z);
            if (h.z <= 0 || sample.z < 0 || std::abs(sample.x) > 4096 || std::abs(sample.y) > 4096) continue;
            bounds.xMin.push_back(static_cast<float>(sample.x)), bounds.xMax.push_back(bounds.xMin.back());
            bounds.yMin.push_back(static_cast<float>(sample.y)), bounds.yMax.push_back(bounds.yMin.back());
            bounds.dMin.push_back(static_cast<float>(sample.z)), bounds.dMax.push_back(bounds.dMin.back());
        }
        const ImagePlanes planes = planesOf(c, 640, 480, 0, {4096, 4096, 5});
        for (std::size_t i = 0; i < bounds.size(); ++i) {
            if (!isSeen(c, bounds.xMin[i], bounds.yMin[i], bounds.dMin[i], 640, 480)) continue;
            std::uint32_t number = 0;
            ASSERT_EQ(findVisible(bounds, i, 1, planes, &number), 1u);
            ++seen;
        }
    }
    EXPECT_GT(seen, 200);
}

TEST(Visibility, HoldsExactlyOnTheEdges) {
    // The eye is the camera: its own four corner samples are seen, and a sample on the border belongs to the
    // image.
    const scene::Camera camera{64, 64, 50, 50, 32, 32};
    const glm::dmat4 c = scene::eyeImageFromSourceImage({camera, {}}, camera, {});
    TileBounds bounds;
    for (const int x : {0, 63})
        for (const int y : {0, 63}) {
            scene::Tile tile;
            tile.x0 = x, tile.y0 = y, tile.width = tile.height = 1, tile.minDisparity = tile.maxDisparity = 1;
            bounds.append(tile, camera);
        }
    std::vector<std::uint32_t> visible(4);
    EXPECT_EQ(findVisible(bounds, 0, 4, planesOf(c, 64, 64, 0, bounds.extentOf(0, 4)), visible.data()), 4u);
    EXPECT_EQ(findVisible(bounds, 0, 4, planesOf(c, 64, 64, -2, bounds.extentOf(0, 4)), visible.data()), 0u);
}

class VisibilityByWidth : public scene::VectorWidths {};

TEST_F(VisibilityByWidth, EveryLengthAndStartGivesTheSameAsOneByOne) {
    const Boxes boxes = randomBoxes(100, 5);
    std::mt19937 random(9);
    const glm::dmat4 c =
        scene::eyeImageFromSourceImage(randomView(random, cameraOf(640, 480, 1.6)), cameraOf(4096, 4096, 1.5708), {});
    const ImagePlanes planes = planesOf(c, 640, 480, 1, boxes.extent);
    forEach([&](const char* width) {
        std::size_t most = 0;
        for (std::size_t first = 0; first < 20; ++first)
            for (std::size_t count = 0; first + count <= 100; ++count) {
                std::vector<std::uint32_t> together(count + 1, 4711), single;
                const std::size_t found = findVisible(boxes.bounds, first, count, planes, together.data());
                EXPECT_EQ(together[count], 4711u) << "wrote past its slot, " << width;
                together.resize(found);
                for (std::size_t i = first; i < first + count; ++i) {
                    std::uint32_t number = 0;
                    if (findVisible(boxes.bounds, i, 1, planes, &number) == 1) single.push_back(number);
                }
                ASSERT_EQ(together, single) << width;
                most = std::max(most, found);
            }
        EXPECT_GT(most, 20u) << width;
        EXPECT_LT(most, 80u) << width;
    });
}

TEST(Visibility, IsTheSameOnAnyNumberOfThreads) {
    const Boxes boxes = randomBoxes(10000, 21);
    std::mt19937 random(4);
    const glm::dmat4 c =
        scene::eyeImageFromSourceImage(randomView(random, cameraOf(640, 480, 1.6)), cameraOf(4096, 4096, 1.5708), {});
    const std::vector<ImagePlanes> planes{planesOf(c, 640, 480, 1, boxes.extent)};
    std::vector<TilePiece> pieces;
    for (std::uint32_t first = 0; first < 10000; first += 300)
        pieces.push_back({.image = 0,
                          .first = first,
                          .count = std::min(300u, 10000 - first),
                          .box = boxes.bounds.boxAround(first, std::min(300u, 10000 - first))});
    std::vector<VisibleTiles> results(2, {numbersOf(pieces), {}, {}});
    for (std::size_t run = 0; run < 2; ++run) {
        const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, run + 1);
        cull(
            boxes.bounds, pieces, [&](const TilePiece& piece) { return planes[piece.image]; }, results[run]);
    }
    EXPECT_EQ(results[0].counts, results[1].counts);
    for (std::size_t p = 0; p < pieces.size(); ++p)
        for (std::uint32_t i = 0; i < results[0].counts[p]; ++i)
            EXPECT_EQ(results[0].slots[pieces[p].first + i], results[1].slots[pieces[p].first + i]);
}

} // namespace
} // namespace render
