#pragma once
// A plane (takePlane) of which some samples are in no square.

#include "render/readback.h"
#include "tests/render/test_scenes.h"

#include <gtest/gtest.h>

namespace render {

/// Of the columns and rows from first to end.
struct LoneSamples {
    int first = 0, end = 0;
    /// By what takePlane paints them; no mixture of others' colours is any of theirs.
    bool areOf(const scene::Rgb8& colour) const {
        const auto isWithin = [&](int i) { return i >= first && i < end; };
        return isWithin(colour.r) && isWithin(colour.g);
    }
};

inline scene::DepthImage withLone(scene::DepthImage plane, const LoneSamples& lone) {
    for (int y = lone.first - 1; y < lone.end; ++y)
        for (int x = lone.first - 1; x < lone.end; ++x)
            plane.flags(x, y) |= scene::kSkinUpper | scene::kSkinLower;
    return plane;
}

/// The mesh's picture, with lone samples, and no others, as in that of all samples. Where both reach either may be
/// seen.
inline void expectMeshAndLone(const EyeImage& drawn, const EyeImage& mesh, const EyeImage& samples,
                              const LoneSamples& lone) {
    int alone = 0;
    for (int y = 0; y < drawn.colour.height(); ++y)
        for (int x = 0; x < drawn.colour.width(); ++x) {
            const bool isLone = samples.pixelClass(x, y) != 0 && lone.areOf(samples.colour(x, y));
            if (isLone && mesh.pixelClass(x, y) == 0) {
                ++alone;
                ASSERT_EQ(drawn.colour(x, y), samples.colour(x, y)) << x << " " << y;
                ASSERT_NEAR(drawn.depthMetres(x, y) / samples.depthMetres(x, y), 1, 8e-6) << x << " " << y;
            } else if (drawn.pixelClass(x, y) == 0 || !lone.areOf(drawn.colour(x, y))) {
                ASSERT_EQ(drawn.pixelClass(x, y), mesh.pixelClass(x, y)) << x << " " << y;
                ASSERT_EQ(drawn.colour(x, y), mesh.colour(x, y)) << x << " " << y;
            }
        }
    EXPECT_GT(alone, 500);
}

} // namespace render
