// What is drawn over the scene: where it lands in both eyes, what hides it, and that it measures nothing.

#include "render/glyphs.h"
#include "render/overlay_list.h"
#include "tests/render/test_device.h"
#include "tests/render/test_scenes.h"

#include <tbb/global_control.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <set>

namespace render {
namespace {

constexpr scene::Rgb8 kGreen{0, 255, 0}, kRed{255, 0, 0};
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();

/// Two eyes 6 cm apart before a wall 2 m away.
class OverlayTest : public RenderTest {
  protected:
    OverlayTest()
        : wall_(cut({takePlane(cameraOf(128, 128, 1.9), {0, 0, 1}, 2)})), scene_(testDevice(), wall_.blocks()),
          renderer_(testDevice(), scene_, kEye.width, kEye.height, 2), eyes_{twoEyes({0, 0, 0})} {}

    static std::array<scene::View, 2> twoEyes(const glm::dvec3& head) {
        const auto [left, right] = scene::eyesOf(kEye, {glm::dmat3(1.0), head}, 0.06);
        return {left, right};
    }
    std::vector<EyeImage> draw(const Overlay& overlay) {
        stats_ = renderer_.draw(eyes_, kMesh, {}, &overlay);
        return renderer_.readBack();
    }
    std::vector<EyeImage> drawBare() {
        renderer_.draw(eyes_, kMesh);
        return renderer_.readBack();
    }
    /// Pixels of exactly that colour: their number and the mean of their centres.
    struct Spot {
        int count = 0;
        glm::dvec2 middle{0};
    };
    static Spot spotOf(const EyeImage& image, scene::Rgb8 colour) {
        Spot spot;
        for (int y = 0; y < image.colour.height(); ++y)
            for (int x = 0; x < image.colour.width(); ++x)
                if (image.colour(x, y) == colour) ++spot.count, spot.middle += glm::dvec2(x + 0.5, y + 0.5);
        if (spot.count > 0) spot.middle /= spot.count;
        return spot;
    }

    inline static const scene::Camera kEye{200, 150, 120, 120, 100, 75};
    inline static const Quality kMesh{.warp = Warp::mesh};
    CutScene wall_;
    GpuScene scene_;
    Renderer renderer_;
    std::array<scene::View, 2> eyes_;
    FrameStats stats_;
};

TEST_F(OverlayTest, ASegmentLandsWhereItStandsInBothEyes) {
    // Upright, 1 m away: x = 100 + 120 (0.1 -+ 0.03) is 115.6 to the left eye and 108.4 to the right one.
    Overlay overlay;
    overlay.segments.push_back({{0.1, -0.2, 1}, {0.1, 0.2, 1}, kGreen, 5});
    const std::vector<EyeImage> drawn = draw(overlay);
    const Spot left = spotOf(drawn[0], kGreen), right = spotOf(drawn[1], kGreen);
    EXPECT_GT(left.count, 48 * 4 - 10);
    EXPECT_NEAR(left.middle.x, 115.6, 0.5);
    EXPECT_NEAR(right.middle.x, 108.4, 0.5);
    EXPECT_NEAR(left.middle.y, 75, 0.5);
    // Its upper end is at 75 - 24 and round.
    EXPECT_EQ(drawn[0].colour(115, 51), kGreen);
    EXPECT_NE(drawn[0].colour(115, 46), kGreen);
    EXPECT_EQ(stats_.eyes[0].overlayStrokes, 1u);
    EXPECT_EQ(stats_.eyes[0].overlayDropped, 0u);
}

TEST_F(OverlayTest, SurfacesHideWhatIsBehindThem) {
    const auto count = [&](double z, float whenHidden) {
        Overlay overlay;
        overlay.segments.push_back({{-0.1, 0, z}, {0.1, 0, z}, kGreen, 4, 1, whenHidden});
        const std::vector<EyeImage> drawn = draw(overlay);
        EXPECT_EQ(spotOf(drawn[0], kGreen).count, spotOf(drawn[1], kGreen).count);
        return spotOf(drawn[0], kGreen).count;
    };
    EXPECT_GT(count(1.9, 0), 30) << "before the wall";
    EXPECT_GT(count(2.0, 0), 30) << "on the wall";
    EXPECT_EQ(count(2.1, 0), 0) << "behind it";
    EXPECT_EQ(count(2.1, 0.5f), 0) << "dimmed";
    EXPECT_GT(count(2.1, 1), 30) << "as bright behind as before";

    const std::vector<EyeImage> bare = drawBare();
    Overlay overlay;
    overlay.segments.push_back({{-0.1, 0, 2.1}, {0.1, 0, 2.1}, kGreen, 4, 1, 0.5f});
    const std::vector<EyeImage> dimmed = draw(overlay);
    const scene::Rgb8 was = bare[0].colour(100, 75), is = dimmed[0].colour(100, 75);
    EXPECT_NEAR(is.r, was.r / 2, 1);
    EXPECT_NEAR(is.g, (was.g + 255) / 2, 1);
}

TEST_F(OverlayTest, PartlyBehindTheWall) {
    // Through the wall at x = 0, from 1 m before it to 1 m behind.
    Overlay overlay;
    overlay.segments.push_back({{-0.5, 0.2, 1}, {0.5, 0.2, 3}, kGreen, 4});
    const EyeImage drawn = draw(overlay)[0];
    const Spot spot = spotOf(drawn, kGreen);
    ASSERT_GT(spot.count, 20);
    for (int y = 0; y < kEye.height; ++y)
        for (int x = 0; x < kEye.width; ++x)
            ASSERT_TRUE(drawn.colour(x, y) != kGreen || x <= 104) << x << ": the wall is reached at x = 101.8";
}

TEST_F(OverlayTest, ASegmentFromBehindTheEyeIsCutAndNotMirrored) {
    Overlay overlay;
    // Along the view, below the eye: comes up from the lower edge towards the middle.
    overlay.segments.push_back({{0, 0.3, -5}, {0, 0.3, 1.9}, kGreen, 3});
    const EyeImage drawn = draw(overlay)[0];
    EXPECT_GT(spotOf(drawn, kGreen).count, 60);
    for (int y = 0; y < 75; ++y)
        for (int x = 0; x < kEye.width; ++x)
            ASSERT_NE(drawn.colour(x, y), kGreen) << x << " " << y;
    overlay.segments = {{{0, 0.3, -5}, {0.1, 0.3, -0.1}, kGreen, 3}};
    EXPECT_EQ(spotOf(draw(overlay)[0], kGreen).count, 0) << "all of it behind";
}

TEST_F(OverlayTest, WhatIsOffTheScreenOrNowhereIsLeftOut) {
    const std::vector<EyeImage> bare = drawBare();
    Overlay overlay;
    overlay.segments.push_back({{9, 0, 1}, {9, 1, 1}, kGreen, 4});
    overlay.segments.push_back({{0, -500, 1}, {1, -300, 1.5}, kGreen, 4});
    overlay.labels.push_back({{0, 90, 1}, "below", kGreen});
    EXPECT_TRUE(isSame(draw(overlay)[0], bare[0]));
    EXPECT_EQ(stats_.eyes[0].overlayDropped, 0u);
    overlay.segments.push_back({{kNaN, 0, 1}, {0, 0, 1}, kGreen, 4});
    overlay.segments.push_back({{0, 0, 1}, {kInf, 0, 1}, kGreen, 4});
    overlay.segments.push_back({{0, 0, 1}, {1, 0, 1}, kGreen, std::numeric_limits<float>::quiet_NaN()});
    overlay.segments.push_back({{1e308, 0, 0.02}, {-1e308, 0, 0.02}, kGreen, 3});
    overlay.labels.push_back({{0, 0, kNaN}, "nowhere", kGreen});
    EXPECT_TRUE(isSame(draw(overlay)[0], bare[0]));
    EXPECT_EQ(stats_.eyes[0].overlayDropped, 5u);
}

TEST_F(OverlayTest, MoreThanFitsIsDroppedAndCounted) {
    Overlay overlay;
    for (std::size_t i = 0; i < kMaxStrokes + 7; ++i)
        overlay.segments.push_back({{0, 0, 1}, {0.001, 0, 1}, kGreen, 2});
    draw(overlay);
    EXPECT_EQ(stats_.eyes[1].overlayStrokes, kMaxStrokes);
    EXPECT_EQ(stats_.eyes[1].overlayDropped, 7u);
    for (Segment& segment : overlay.segments)
        segment.a = {-9, 9, 1}, segment.b = {9, -9, 1}; // across the whole picture
    draw(overlay);
    EXPECT_GT(stats_.eyes[1].overlayStrokes, 1000u);
    EXPECT_EQ(stats_.eyes[1].overlayStrokes + stats_.eyes[1].overlayDropped, kMaxStrokes + 7);
}

TEST_F(OverlayTest, TheNearerOfTwoCrossingLinesIsOnTopWhateverTheirOrder) {
    const Segment nearer{{0, -0.2, 1}, {0, 0.2, 1}, kGreen, 9}, farther{{-0.3, 0, 1.5}, {0.3, 0, 1.5}, kRed, 9};
    for (const bool nearFirst : {true, false}) {
        Overlay overlay;
        overlay.segments = {nearFirst ? nearer : farther, nearFirst ? farther : nearer};
        const EyeImage drawn = draw(overlay)[0];
        EXPECT_EQ(drawn.colour(103, 75), kGreen) << nearFirst;
        EXPECT_EQ(drawn.colour(90, 75), kRed) << nearFirst;
    }
}

TEST_F(OverlayTest, ALabelIsWrittenAboveItsPlaceAtItsDepth) {
    Overlay overlay;
    overlay.labels.push_back({{0.1, 0, 1}, "D2 1.234 m", kGreen, 0.1f});
    overlay.labels[0].whenHidden = 0;
    const std::vector<EyeImage> drawn = draw(overlay);
    const Spot left = spotOf(drawn[0], kGreen), right = spotOf(drawn[1], kGreen);
    EXPECT_GT(left.count, 60);
    // 12 pixels high, centred 18 pixels above (100 + 120 * (0.1 -+ 0.03), 75).
    EXPECT_NEAR(left.middle.x, 115.6, 6);
    EXPECT_NEAR(left.middle.y, 57, 2);
    EXPECT_NEAR(left.middle.x - right.middle.x, 7.2, 1.5) << "the parallax of 1 m";
    for (int y = 0; y < kEye.height; ++y)
        for (int x = 0; x < kEye.width; ++x)
            ASSERT_TRUE(drawn[0].colour(x, y) != kGreen || (y >= 48 && y < 66)) << x << " " << y;
    overlay.labels[0].at.z = 2.5;
    EXPECT_EQ(spotOf(draw(overlay)[0], kGreen).count, 0) << "behind the wall";
}

TEST_F(OverlayTest, ALabelKeepsItsHeightAtAnyDistanceAndCanHaveItInPixels) {
    const auto rowsOf = [&](const Label& label) {
        Overlay overlay;
        overlay.labels.push_back(label);
        const EyeImage drawn = draw(overlay)[0];
        std::set<int> rows;
        for (int y = 0; y < kEye.height; ++y)
            for (int x = 0; x < kEye.width; ++x)
                if (drawn.colour(x, y) == kGreen) rows.insert(y);
        return static_cast<int>(rows.size());
    };
    for (const double z : {0.5, 1.0, 1.9})
        EXPECT_NEAR(rowsOf({{0, 0.1, z}, "HI", kGreen, 0.2f}), 24, 5) << z;
    EXPECT_NEAR(rowsOf({{0, 0.1, 1}, "HI", kGreen, 0.2f, 12}), 12, 3);
}

TEST_F(OverlayTest, DepthAndClassStayThoseOfTheSurface) {
    const std::vector<EyeImage> bare = drawBare();
    Overlay overlay;
    overlay.segments.push_back({{-1, 0, 1}, {1, 0.1, 1}, kGreen, 20});
    overlay.labels.push_back({{0, 0, 1}, "text", kRed, 0.2f});
    overlay.vignette = 0.8f;
    const std::vector<EyeImage> drawn = draw(overlay);
    for (std::size_t eye = 0; eye < 2; ++eye) {
        EXPECT_EQ(drawn[eye].depthMetres, bare[eye].depthMetres);
        EXPECT_EQ(drawn[eye].pixelClass, bare[eye].pixelClass);
        EXPECT_NE(drawn[eye].colour, bare[eye].colour);
    }
}

TEST_F(OverlayTest, NothingToDrawLeavesEveryByteAndTakesNoStep) {
    const std::vector<EyeImage> bare = drawBare();
    Overlay overlay;
    overlay.segments.push_back({{-1, 0, 1}, {1, 0.1, 1}, kGreen, 20});
    EXPECT_FALSE(isSame(draw(overlay)[0], bare[0]));
    const std::vector<EyeImage> again = draw({});
    EXPECT_TRUE(isSame(again[0], bare[0]));
    EXPECT_TRUE(isSame(again[1], bare[1]));
    const FrameStats last = renderer_.finish();
    for (const StepTime& time : stats_.cpu)
        EXPECT_STRNE(time.step, "overlay");
    for (const StepTime& time : last.gpu)
        EXPECT_STRNE(time.step, "overlay");
    EXPECT_EQ(stats_.eyes[0].overlayStrokes, 0u);
}

TEST_F(OverlayTest, TheStepIsTimedOnBothSides) {
    if (!testDevice().hasTimestamps()) GTEST_SKIP() << "the device has no timestamps";
    Overlay overlay;
    overlay.segments.push_back({{-1, 0, 1}, {1, 0.1, 1}, kGreen, 20});
    draw(overlay);
    const auto steps = [](const std::vector<StepTime>& times) {
        int count = 0;
        for (const StepTime& time : times)
            count += std::string(time.step) == "overlay";
        return count;
    };
    EXPECT_EQ(steps(stats_.cpu), 2);
    EXPECT_EQ(steps(renderer_.finish().gpu), 2);
}

TEST_F(OverlayTest, TheVignetteDarkensTheRimAlone) {
    const auto sumOf = [](const EyeImage& image, int x, int y) {
        const scene::Rgb8 c = image.colour(x, y);
        return c.r + c.g + c.b;
    };
    const EyeImage bare = drawBare()[0];
    double before = 1e9;
    for (const float strength : {0.3f, 0.6f, 1.0f}) {
        Overlay overlay;
        overlay.vignette = strength;
        const EyeImage drawn = draw(overlay)[0];
        for (int y = 60; y < 90; ++y)
            for (int x = 85; x < 115; ++x)
                ASSERT_EQ(drawn.colour(x, y), bare.colour(x, y)) << strength;
        double sum = 0;
        for (int y = 0; y < kEye.height; ++y)
            for (int x = 0; x < kEye.width; ++x) {
                ASSERT_LE(sumOf(drawn, x, y), sumOf(bare, x, y));
                sum += sumOf(drawn, x, y);
            }
        EXPECT_LT(sum, before) << "the stronger, the darker";
        before = sum;
        // From the middle outwards it only gets darker: no ring.
        double last = 1;
        for (int x = 100; x < kEye.width; ++x) {
            const double light = (sumOf(drawn, x, 75) + 2.0) / (sumOf(bare, x, 75) + 2.0);
            EXPECT_LE(light, last + 0.03) << strength << ": " << x;
            last = light;
        }
        EXPECT_LT(sumOf(drawn, 0, 0), sumOf(bare, 0, 0));
    }
    Overlay full;
    full.vignette = 1;
    EXPECT_EQ(sumOf(draw(full)[0], 1, 1), 0);
}

TEST_F(OverlayTest, TheSameBytesOnAnyNumberOfThreads) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-1, 1);
    Overlay overlay;
    const auto colour = [&] {
        return scene::Rgb8{std::uint8_t(random() % 256), std::uint8_t(random() % 256), std::uint8_t(random() % 256)};
    };
    const auto place = [&] { return glm::dvec3(unit(random), 0.7 * unit(random), 1.6 + 1.5 * unit(random)); };
    for (int i = 0; i < 300; ++i) {
        const glm::dvec3 a = place(), b = place();
        overlay.segments.push_back({a, b, colour(), 4, 0.7f, 0.3f});
    }
    for (int i = 0; i < 10; ++i)
        overlay.labels.push_back({place(), "label " + std::to_string(i), colour(), 0.06f});
    overlay.vignette = 0.5f;
    std::vector<std::vector<EyeImage>> drawn;
    for (const std::size_t threads : {1u, 2u, 2u}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        drawn.push_back(draw(overlay));
    }
    for (const std::vector<EyeImage>& images : drawn)
        for (std::size_t eye = 0; eye < 2; ++eye)
            EXPECT_TRUE(isSame(images[eye], drawn[0][eye]));
}

TEST_F(OverlayTest, FarFromTheOriginNothingMoves) {
    Overlay here;
    here.segments.push_back({{0.1, -0.2, 1}, {0.3, 0.2, 1.7}, kGreen, 5});
    here.labels.push_back({{-0.2, 0, 1}, "here", kRed, 0.1f});
    // A power of two: the offset is exact.
    const glm::dvec3 offset(16777216.0);
    Overlay there = here;
    there.segments[0].a += offset, there.segments[0].b += offset, there.labels[0].at += offset;
    scene::View farEye = eyes_[0];
    farEye.worldFromEye.translation += offset;
    OverlayList near, far;
    listOverlay(here, eyes_[0], near);
    listOverlay(there, farEye, far);
    ASSERT_EQ(near.strokes.size(), far.strokes.size());
    for (std::size_t i = 0; i < near.strokes.size(); ++i)
        EXPECT_LT(glm::length(near.strokes[i].a - far.strokes[i].a), 1e-4f);
}

/// Each bin has every stroke that reaches one of its pixels.
TEST(OverlayList, BinsMissNothing) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> unit(-1, 1);
    const scene::View eye{{200, 150, 120, 120, 90, 80}, {}};
    Overlay overlay;
    for (int i = 0; i < 200; ++i)
        overlay.segments.push_back({{2 * unit(random), 2 * unit(random), 1 + unit(random)},
                                    {2 * unit(random), 2 * unit(random), 1 + unit(random)},
                                    kGreen,
                                    static_cast<float>(1 + 9 * std::abs(unit(random)))});
    OverlayList list;
    listOverlay(overlay, eye, list);
    ASSERT_GT(list.strokes.size(), 100u);
    std::vector<std::set<std::uint32_t>> bins(std::size_t{binsAlong(200)} * binsAlong(150));
    for (const OverlayBin& bin : list.bins)
        for (std::uint32_t i = bin.first; i < bin.first + bin.count; ++i)
            bins[(bin.place >> 16) * binsAlong(200) + (bin.place & 0xffffu)].insert(list.entries[i]);
    for (int y = 0; y < 150; ++y)
        for (int x = 0; x < 200; ++x)
            for (std::uint32_t s = 0; s < list.strokes.size(); ++s) {
                if (!(shareOfStroke(list.strokes[s], glm::vec2(x, y) + 0.5f, 0) > 0)) continue;
                const auto& bin = bins[std::size_t(y / 16) * binsAlong(200) + std::size_t(x / 16)];
                ASSERT_TRUE(bin.contains(s)) << x << " " << y << " stroke " << s;
            }
}

TEST(Glyphs, AllOfAsciiIsThereAndNoTwoAreAlike) {
    std::set<std::string> seen;
    for (char letter = '!'; letter <= '~'; ++letter) {
        const auto& strokes = strokesOf(letter);
        ASSERT_FALSE(strokes.empty()) << letter;
        std::string lines;
        for (const GlyphStroke& stroke : strokes)
            for (const glm::ivec2& p : {stroke.a, stroke.b}) {
                EXPECT_TRUE(p.x >= 0 && p.x <= kGlyphWidth && p.y >= 0 && p.y <= kGlyphHeight + 2) << letter;
                lines += std::to_string(10 * p.x + p.y) + " ";
            }
        EXPECT_TRUE(seen.insert(lines).second) << letter;
    }
    EXPECT_TRUE(strokesOf(' ').empty());
    EXPECT_EQ(&strokesOf('\n'), &strokesOf('?'));
    EXPECT_EQ(&strokesOf('\xe4'), &strokesOf('?'));
}

} // namespace
} // namespace render
