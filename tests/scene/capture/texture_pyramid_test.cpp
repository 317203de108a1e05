#include "scene/capture/texture_pyramid.h"
#include "scene/srgb.h"

#include <gtest/gtest.h>

namespace scene {
namespace {

Image<Rgba8> checker(int size) {
    Image<Rgba8> picture(size, size);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
            picture(x, y) = (x + y) % 2 == 0 ? Rgba8{255, 255, 255, 255} : Rgba8{0, 0, 0, 255};
    return picture;
}

TEST(TexturePyramid, WithoutAFootprintTheTexelItself) {
    Image<Rgba8> picture(4, 2, {0, 0, 0, 255});
    picture(2, 0) = {255, 0, 0, 255};
    const TexturePyramid pyramid(picture, true);
    const glm::vec3 at = pyramid.colourAt({2.5f / 4, 0.75f}, {}); // the upper row: v runs up
    EXPECT_EQ(at, glm::vec3(1, 0, 0));
    EXPECT_EQ(pyramid.colourAt({2.5f / 4 + 3, 0.75f - 2}, {}), at) << "textures repeat";
    EXPECT_EQ(pyramid.colourAt({2.5f / 4, 0.25f}, {}), glm::vec3(0));
    EXPECT_NEAR(pyramid.colourAt({2.0f / 4, 0.75f}, {}).x, 0.5f, 1e-6) << "between two texels";
}

TEST(TexturePyramid, AWideFootprintIsTheMeanOfTheLight) {
    for (const int size : {64, 37}) {
        const TexturePyramid pyramid(checker(size), false);
        EXPECT_NEAR(pyramid.mean().x, 0.5f, 0.01f);
        const glm::vec3 wide = pyramid.colourAt({0.3f, 0.6f}, {{0.5f, 0}, {0, 0.5f}});
        EXPECT_NEAR(wide.x, 0.5f, 0.02f);
        // 8 texels one way, 1 the other: the mean along the footprint all the same.
        const glm::vec3 slanted = pyramid.colourAt({0.3f, 0.6f}, {{8.0f / static_cast<float>(size), 0}, {}});
        EXPECT_NEAR(slanted.x, 0.5f, 0.15f);
    }
}

TEST(TexturePyramid, WhatIsCutOutHasNoSay) {
    Image<Rgba8> picture(16, 16, {255, 0, 255, 0}); // leaves on magenta that nobody should see
    for (int y = 4; y < 12; ++y)
        for (int x = 4; x < 12; ++x)
            picture(x, y) = {0, 255, 0, 255};
    const TexturePyramid pyramid(picture, true);
    EXPECT_NEAR(pyramid.mean().x, 0.0f, 1e-6);
    EXPECT_NEAR(pyramid.mean().y, 1.0f, 1e-6);
    for (float width : {0.0f, 0.05f, 0.2f, 1.0f})
        EXPECT_NEAR(pyramid.colourAt({4.0f / 16, 0.5f}, {{width, 0}, {0, width}}).x, 0.0f, 1e-6) << "at its rim";
}

TEST(TexturePyramid, WhereNothingIsCutOutAlphaMeansNothing) {
    const TexturePyramid pyramid(Image<Rgba8>(8, 8, {0, 255, 0, 0}), false);
    EXPECT_EQ(pyramid.mean(), glm::vec3(0, 1, 0));
    EXPECT_EQ(pyramid.colourAt({0.5f, 0.5f}, {}), glm::vec3(0, 1, 0));
}

TEST(TexturePyramid, ColoursGoThereAndBack) {
    for (int value = 0; value < 256; ++value) {
        const auto byte = static_cast<std::uint8_t>(value);
        const TexturePyramid one(Image<Rgba8>(1, 1, {byte, byte, byte, 255}), false);
        EXPECT_EQ(encoded(one.mean()).r, byte);
    }
    EXPECT_EQ(encoded(glm::vec3(7)).g, 255);
    EXPECT_EQ(encoded(glm::vec3(-1)).g, 0);
}

} // namespace
} // namespace scene
