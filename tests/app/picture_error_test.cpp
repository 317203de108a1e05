// PSNR, SSIM and shares on pictures whose figures are known.

#include "app/picture_error.h"
#include "render/shaders/shared/z_key.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

namespace app {
namespace {

using Picture = scene::Image<scene::Rgb8>;
using Mask = scene::Image<std::uint8_t>;
constexpr float kSky = std::numeric_limits<float>::infinity();

Picture grey(int width, int height, std::uint8_t value) {
    return {width, height, {value, value, value}};
}

Picture noise(int width, int height, unsigned seed) {
    Picture picture(width, height);
    std::mt19937 random(seed);
    for (scene::Rgb8& c : picture.pixels())
        c.r = c.g = c.b = static_cast<std::uint8_t>(random() % 256);
    return picture;
}

TEST(Truth, IsWhatWasMeasured) {
    scene::DepthImage image;
    image.camera = {5, 1, 5, 5, 2.5, 0.5};
    image.colour = Picture(5, 1);
    image.disparity = scene::Image<float>(5, 1, 0.5f);
    image.flags = Mask(5, 1, 0);
    image.flags(1, 0) = scene::kNoSurface;
    image.flags(2, 0) = scene::kNoSurface | scene::kInterpolated; // a guess
    image.flags(3, 0) = scene::kInterpolated;                     // closed
    image.disparity(4, 0) = 0;                                    // sky
    const Truth truth = truthOf(image);
    EXPECT_TRUE(std::ranges::equal(truth.depthMetres.pixels(), std::array{2.0f, 0.0f, 0.0f, 0.0f, kSky}));
}

TEST(Psnr, OfKnownErrors) {
    const Mask all(8, 4, 1);
    EXPECT_NEAR(psnrOf(grey(8, 4, 100), grey(8, 4, 101), all), 20 * std::log10(255.0), 1e-9);
    EXPECT_EQ(psnrOf(grey(8, 4, 100), grey(8, 4, 100), all), kMostDecibels);
    EXPECT_EQ(psnrOf(grey(8, 4, 0), grey(8, 4, 255), all), 0);
    EXPECT_EQ(psnrOf(grey(8, 4, 100), grey(8, 4, 101), Mask(8, 4, 0)), 0) << "nothing drawn is not well drawn";
    // Half the pixels wrong by 10 is a mean square of 50; where only they count, of 100.
    Picture half = grey(8, 4, 100);
    Mask wrong(8, 4, 0);
    for (int x = 0; x < 4; ++x)
        for (int y = 0; y < 4; ++y)
            half(x, y) = {110, 110, 110}, wrong(x, y) = 1;
    EXPECT_NEAR(psnrOf(half, grey(8, 4, 100), all), 10 * std::log10(255 * 255 / 50.0), 1e-9);
    EXPECT_NEAR(psnrOf(half, grey(8, 4, 100), wrong), 10 * std::log10(255 * 255 / 100.0), 1e-9);
}

TEST(Ssim, OfFlatPicturesIsItsFirstFactor) {
    // Without variance the second factor is 1: (2 p q + c1) / (p^2 + q^2 + c1), c1 = (0.01 * 255)^2.
    const double c1 = 2.55 * 2.55, expected = (2 * 100.0 * 150 + c1) / (100.0 * 100 + 150.0 * 150 + c1);
    EXPECT_NEAR(ssimOf(grey(32, 24, 100), grey(32, 24, 150), Mask(32, 24, 1)), expected, 1e-9);
    EXPECT_NEAR(ssimOf(noise(32, 24, 1), noise(32, 24, 1), Mask(32, 24, 1)), 1, 1e-9);
    EXPECT_EQ(ssimOf(grey(32, 24, 0), grey(32, 24, 0), Mask(32, 24, 0)), 0);
}

TEST(Ssim, IsThePapersSumWindowByWindow) {
    // The definition, written out: an 11 x 11 Gaussian window about each pixel, what is masked left out.
    const Picture p = noise(20, 16, 2);
    Picture q = noise(20, 16, 3);
    Mask where(20, 16, 1);
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 20; ++x) {
            q(x, y).r = q(x, y).g = q(x, y).b = static_cast<std::uint8_t>((p(x, y).g * 3 + q(x, y).g) / 4);
            if (x > 12 && y < 6) where(x, y) = 0;
        }
    double sum = 0;
    int count = 0;
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 20; ++x) {
            if (where(x, y) == 0) continue;
            double weights = 0, sp = 0, sq = 0, spp = 0, sqq = 0, spq = 0;
            for (int v = std::max(0, y - 5); v <= std::min(15, y + 5); ++v)
                for (int u = std::max(0, x - 5); u <= std::min(19, x + 5); ++u) {
                    if (where(u, v) == 0) continue;
                    const double w = std::exp(-((u - x) * (u - x) + (v - y) * (v - y)) / (2 * 1.5 * 1.5));
                    const double a = p(u, v).g, b = q(u, v).g;
                    weights += w, sp += w * a, sq += w * b, spp += w * a * a, sqq += w * b * b, spq += w * a * b;
                }
            const double mp = sp / weights, mq = sq / weights;
            const double vp = spp / weights - mp * mp, vq = sqq / weights - mq * mq, c = spq / weights - mp * mq;
            const double c1 = 2.55 * 2.55, c2 = 7.65 * 7.65;
            sum += (2 * mp * mq + c1) * (2 * c + c2) / ((mp * mp + mq * mq + c1) * (vp + vq + c2));
            ++count;
        }
    EXPECT_NEAR(ssimOf(p, q, where), sum / count, 1e-6);
    EXPECT_LT(sum / count, 0.99);
}

TEST(Ssim, AHoleDoesNotSpoilItsNeighbours) {
    const Picture truth = noise(32, 32, 5);
    Picture drawn = truth;
    Mask where(32, 32, 1);
    for (int y = 10; y < 20; ++y)
        for (int x = 10; x < 20; ++x)
            drawn(x, y) = {0, 0, 0}, where(x, y) = 0;
    EXPECT_NEAR(ssimOf(drawn, truth, where), 1, 1e-9);
}

TEST(PictureError, SharesOfHolesAndOfWhatIsWronglySolid) {
    constexpr int kWidth = 10, kHeight = 10;
    render::EyeImage drawn{{kWidth, kHeight}, {kWidth, kHeight, 4.f}, {kWidth, kHeight, render::kClassSeen}};
    Truth truth{{kWidth, kHeight}, {kWidth, kHeight, 4.f}};
    PictureError error = errorOf(drawn, truth);
    EXPECT_EQ(error.holeShare, 0);
    EXPECT_EQ(error.wronglySolidShare, 0);
    EXPECT_EQ(error.coveredShare, 1);

    // Row 0 is sky to the camera, row 1 it knows nothing of: 80 pixels of surface and 10 of sky.
    for (int x = 0; x < kWidth; ++x) {
        truth.depthMetres(x, 0) = kSky, truth.depthMetres(x, 1) = 0;
        drawn.pixelClass(x, 0) = render::kClassBackground, drawn.depthMetres(x, 0) = 0;
    }
    EXPECT_EQ(errorOf(drawn, truth).holeShare, 0) << "nothing has to be drawn of the sky";
    for (int x = 0; x < 4; ++x)
        drawn.pixelClass(x, 5) = render::kClassUnseen;
    drawn.pixelClass(5, 5) = render::kClassFilled;
    error = errorOf(drawn, truth);
    EXPECT_NEAR(error.holeShare, 4.0 / 80, 1e-12) << "the unseen is a hole, what is filled is none";
    EXPECT_NEAR(error.unseenShare, 4.0 / 80, 1e-12);
    EXPECT_NEAR(error.coveredShare, 86.0 / 100, 1e-12);

    // In front by 3 % is within the tolerance, by 10 % it is wrong; where nothing is known nobody can tell.
    drawn.depthMetres(0, 7) = 3.88f, drawn.depthMetres(1, 7) = 3.6f, drawn.depthMetres(2, 1) = 1;
    EXPECT_NEAR(errorOf(drawn, truth).wronglySolidShare, 1.0 / 90, 1e-12);
    // An edge that is off by a pixel is not.
    truth.depthMetres(2, 7) = 3.6f;
    EXPECT_EQ(errorOf(drawn, truth).wronglySolidShare, 0);
    // Unseen is not solid.
    truth.depthMetres(2, 7) = 4, drawn.pixelClass(1, 7) = render::kClassUnseen;
    EXPECT_EQ(errorOf(drawn, truth).wronglySolidShare, 0);
}

TEST(PictureError, WithoutDepthEveryPixelShouldBeDrawn) {
    render::EyeImage drawn{{4, 4}, {4, 4, 1.f}, {4, 4, render::kClassSeen}};
    drawn.pixelClass(0, 0) = render::kClassBackground;
    for (const Truth& truth : {Truth{{4, 4}, {}}, Truth{{4, 4}, {4, 4, 0.f}}}) {
        const PictureError error = errorOf(drawn, truth);
        EXPECT_NEAR(error.holeShare, 1.0 / 16, 1e-12);
        EXPECT_TRUE(std::isnan(error.wronglySolidShare));
    }
}

} // namespace
} // namespace app
