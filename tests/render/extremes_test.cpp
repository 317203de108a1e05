// Where single precision, whole numbers and projections end: every warp far from the origin, far away, at a wall, in
// the sky, through the narrowest and the widest pictures.

#include "render/shaders/shared/tile_draw.h"
#include "tests/render/studio.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace render {
namespace {

class Extremes : public RenderTest {};

constexpr int kWidth = 160, kHeight = 120;
constexpr double kPi = 3.14159265358979323846;

/// Share of pixels that show what the room's geometry has there, within a share of depth.
double shareOfTruth(const EyeImage& image, const scene::View& eye, double tolerance = 0.03,
                    const glm::dvec3& offset = glm::dvec3(0)) {
    const scene::DepthImage truth =
        takeRoom(eye.camera, {eye.worldFromEye.rotation, eye.worldFromEye.translation - offset});
    return shareOf(image, [&](int x, int y) {
        return image.pixelClass(x, y) != 0 &&
               std::abs(double(image.depthMetres(x, y)) * double(truth.disparity(x, y)) - 1) < tolerance;
    });
}

/// As if nobody had looked into one quarter of the room of takeRoom.
scene::Coverage quarterUnseen(const glm::dvec3& offset = glm::dvec3(0)) {
    scene::Coverage coverage;
    coverage.cornerInWorld = offset - glm::dvec3(8);
    coverage.edgeMetres = 16;
    coverage.nodes.resize(1);
    for (int y = 0; y < 4; ++y)
        coverage.nodes[0].unseen |= scene::coverageMask(scene::coverageBit(2, y, 2));
    return coverage;
}

Overlay crossAt(const glm::dvec3& middle) {
    Overlay overlay;
    overlay.segments.push_back({middle - glm::dvec3(0.5, 0.2, 0), middle + glm::dvec3(0.5, 0.2, 0), {255, 0, 0}});
    overlay.segments.push_back({middle - glm::dvec3(0, 0.5, 0.3), middle + glm::dvec3(0, 0.5, 0.3), {0, 255, 0}});
    overlay.labels.push_back({.at = middle, .text = "1234.5 m", .colour = {255, 255, 0}});
    return overlay;
}

TEST_F(Extremes, TenThousandKilometresFromTheOriginThePicturesAreTheSame) {
    const scene::View views[] = {{cameraOf(kWidth, kHeight, 1.3), poseAt({0.3, 0.05, -0.2}, 0.4, 0.1)},
                                 {cameraOf(kWidth, kHeight, 1.3), poseAt({-0.4, -0.2, 0.1}, -2.1, -0.2)}};
    const scene::Coverage here = quarterUnseen();
    Studio studio(roomAllAround(), &here);
    for (const glm::dvec3& offset : {glm::dvec3(1e7, -1e7, 1e7), glm::dvec3(-1e7, 1e7 / 3, 9.87654321e6)}) {
        const scene::Coverage there = quarterUnseen(offset);
        Studio far(movedBy(roomAllAround(), offset), &there);
        for (const Way& way : ways())
            for (const scene::View& view : views) {
                const Overlay overlay = crossAt({1, 0, 1}), farOverlay = crossAt(offset + glm::dvec3(1, 0, 1));
                const EyeImage expected = studio.draw(view, way.quality, &overlay);
                ASSERT_GT(shareOf(expected, [&](int x, int y) { return expected.pixelClass(x, y) != 0; }), 0.6);
                const scene::View moved{view.camera,
                                        {view.worldFromEye.rotation, view.worldFromEye.translation + offset}};
                const EyeImage drawn = far.draw(moved, way.quality, &farOverlay);
                EXPECT_TRUE(isSane(drawn)) << way.name;
                EXPECT_GE(psnrOf(expected, drawn), 60) << way.name;
            }
    }
}

TEST_F(Extremes, OnAReferencePositionTheIdentity) {
    for (const double far : {0.0, 1e7}) {
        const glm::dvec3 offset(far, far / 7, -far);
        const scene::Camera camera = cameraOf(kWidth, kHeight, 1.3);
        const scene::DepthImage image = takeRoom(camera, poseAt({0.3, 0.1, -0.2}, 0.7, 0.2), offset);
        Studio studio(cutInLevels({image}));
        const scene::View view{camera, image.worldFromCamera};
        for (const Way& way : ways()) {
            Quality quality = way.quality;
            quality.maxFootprint = 1;
            if (quality.resolutionScale != 1) continue; // other pixels
            const EyeImage drawn = studio.draw(view, quality);
            EXPECT_TRUE(isSane(drawn)) << way.name;
            EyeImage truth = drawn;
            truth.colour = image.colour;
            EXPECT_EQ(coverage(drawn), 1.0) << way.name;
            // Facets stand in their planes, within a tolerance (scene/facets.h).
            const double tolerance = quality.warp == Warp::adaptive ? 5e-3 : 1e-5;
            EXPECT_EQ(shareOfTruth(drawn, view, tolerance, offset), 1.0) << way.name;
            EXPECT_TRUE(drawn.colour == image.colour) << way.name << ": " << psnrOf(drawn, truth) << " dB";
        }
    }
}

/// Depth along z of a plane normal . p = offset (world) at a pixel; infinite where it is not met.
double planeDepth(const scene::View& eye, const glm::dvec3& normal, double offset, double x, double y) {
    const glm::dvec3 ray = eye.worldFromEye.rotation * rayThrough(eye.camera, x + 0.5, y + 0.5);
    const double depth = (offset - glm::dot(normal, eye.worldFromEye.translation)) / glm::dot(normal, ray);
    return depth > 0 ? depth : INFINITY;
}

TEST_F(Extremes, ATenthOfAMillimetreFromAWall) {
    constexpr double kDistance = 2;
    for (const double tilt : {0.0, 0.3}) {
        const glm::dvec3 normal = glm::normalize(glm::dvec3(tilt, 0.1 * tilt, 1));
        Studio studio(cutInLevels({takePlane(cameraOf(200, 200, 1.5), normal, kDistance)}));
        const glm::dvec3 aside(0.0021, 0.0013, 0);
        const glm::dvec3 place = normal * (kDistance - 1e-4) + aside - normal * glm::dot(normal, aside);
        // Facing the wall, askew, along it.
        for (const double yaw : {0.0, 0.7, 1.3, kPi / 2, -1.5}) {
            const scene::View view{cameraOf(kWidth, kHeight, 1.3), poseAt(place, yaw, 0.1)};
            for (const Way& way : ways()) {
                const EyeImage drawn = studio.draw(view, way.quality);
                EXPECT_TRUE(isSane(drawn)) << way.name << ", yaw " << yaw;
                const Quality& quality = way.quality;
                // How far from its place a sample may be shown, pixels.
                const double ofSample = quality.warp == Warp::points   ? quality.maxFootprint / 2.0
                                        : quality.warp == Warp::splats ? quality.maxSplat
                                                                       : 0;
                const double scale = quality.resolutionScale,
                             reach = scale == 1 ? std::max(ofSample, 0.5) : (ofSample + 0.5) / scale;
                int wanted = 0, missing = 0, wrong = 0;
                for (int y = 0; y < kHeight; ++y)
                    for (int x = 0; x < kWidth; ++x) {
                        double least = INFINITY, most = 0;
                        for (const double down : {-reach, reach})
                            for (const double right : {-reach, reach}) {
                                const double depth = planeDepth(view, normal, kDistance, x + right, y + down);
                                least = std::min(least, depth), most = std::max(most, depth);
                            }
                        // What stands near along the wall is in the picture of the plane for sure.
                        const bool isWanted = most < 0.2, isDrawn = drawn.pixelClass(x, y) != 0;
                        const auto depth = static_cast<double>(drawn.depthMetres(x, y));
                        wanted += isWanted;
                        missing += isWanted && !isDrawn;
                        wrong += isDrawn && !(depth > 0.97 * least && depth < 1.03 * most);
                    }
                EXPECT_GT(wanted, 5000);
                EXPECT_EQ(wrong, 0) << way.name << ", yaw " << yaw << ", tilt " << tilt;
                if (isOfSurfaces(quality.warp)) {
                    EXPECT_EQ(missing, 0) << way.name << ", yaw " << yaw << ", tilt " << tilt;
                }
                if (const auto truth = studio.drawByProcessor(view, quality)) {
                    EXPECT_LE(shareThatDiffers(drawn, *truth), 0.002)
                        << way.name << ", yaw " << yaw << ", tilt " << tilt;
                }
            }
        }
    }
}

TEST(ExtremesMath, NoTileThatReachesBehindTheEyeIsTakenForOneBeforeIt) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> unit(-1, 1);
    int before = 0;
    for (int i = 0; i < 20000; ++i) {
        TileDraw draw{};
        // From far off the eye's plane to right at it.
        const float w = 0.02f + std::exp2(-12 * std::abs(unit(random)));
        draw.base = vec4(unit(random), unit(random), w, 0.5f);
        draw.perX = vec4(1, 0, 3e-3f * unit(random), 0), draw.perY = vec4(0, 1, 3e-3f * unit(random), 0);
        draw.perQ = vec4(0, 0, 1e-7f * unit(random), 1e-7f);
        draw.span.w = packMark(0, 1, scene::kPlaceBits, 1);
        bool isBefore = true;
        for (const uint x : {0u, 63u})
            for (const uint y : {0u, 63u})
                for (const uint q : {0u, 0xfffffu})
                    isBefore = isBefore && isBeforeEye(warpSample(draw, x | y << 6 | q << 12));
        ASSERT_TRUE(isBefore || mayReachBehind(draw));
        before += !mayReachBehind(draw);
    }
    EXPECT_GT(before, 2000);
    EXPECT_LT(before, 18000);
}

TEST_F(Extremes, AHundredKilometresAway) {
    const scene::Coverage coverage = quarterUnseen();
    Studio studio(roomAllAround()), knowing(roomAllAround(), &coverage);
    // With an eye's picture, and through a telescope: 8 m fill a fifth of its width.
    for (const double field : {1.2, 4e-4}) {
        const scene::View view{cameraOf(kWidth, kHeight, field), poseAt({0.2, 0.1, -1e5}, 0, 0)};
        for (const Way& way : ways()) {
            const EyeImage drawn = studio.draw(view, way.quality);
            EXPECT_TRUE(isSane(drawn)) << way.name;
            // 8 m x 3 m of it, and half a footprint around.
            const double f = view.camera.fx / 1e5, share = 8 * f * 3 * f / (kWidth * kHeight);
            const double most = (8 * f + 4) * (3 * f + 4) / (kWidth * kHeight);
            EXPECT_GE(render::coverage(drawn), field < 1 ? 0.9 * share : 0) << way.name << ", field " << field;
            EXPECT_LE(render::coverage(drawn), most) << way.name << ", field " << field;
            // Splats fall off by a hundredth (shared/splat.h).
            const double behind = way.quality.warp == Warp::splats ? 1.02 : 1;
            const double there = shareOf(drawn, [&](int x, int y) {
                const auto depth = static_cast<double>(drawn.depthMetres(x, y));
                return drawn.pixelClass(x, y) != 0 && depth > 1e5 - 4 && depth < behind * (1e5 + 4);
            });
            EXPECT_EQ(there, render::coverage(drawn)) << way.name << ", field " << field;
            if (const auto truth = studio.drawByProcessor(view, way.quality)) {
                EXPECT_LE(shareThatDiffers(drawn, *truth), 0.001) << way.name << ", field " << field;
            }
            // Nobody looked into the kilometres before the room.
            const EyeImage unseen = knowing.draw(view, way.quality);
            EXPECT_TRUE(isSane(unseen)) << way.name;
            EXPECT_EQ(shareOf(unseen, [&](int x, int y) { return unseen.pixelClass(x, y) == 3; }), 1.0) << way.name;
        }
    }
}

TEST_F(Extremes, AHundredKilometresHighAndWideItIsTheSame) {
    constexpr float kScale = 65536; // a power of two: floats keep their fractions
    std::vector<scene::DepthImage> small = roomFromWithin(64).images, large = small;
    for (scene::DepthImage& image : large) {
        image.worldFromCamera.translation *= double{kScale};
        for (float& disparity : image.disparity.pixels())
            disparity /= kScale;
    }
    Studio room(cutInLevels(std::move(small))), valley(cutInLevels(std::move(large)));
    scene::View view{cameraOf(kWidth, kHeight, 1.3), poseAt({0.3, 0.05, -0.2}, 0.4, 0.1)}, above = view;
    above.worldFromEye.translation *= double{kScale};
    for (const Way& way : ways()) {
        EyeImage expected = room.draw(view, way.quality);
        for (float& depth : expected.depthMetres.pixels())
            depth *= kScale;
        EXPECT_TRUE(isSame(valley.draw(above, way.quality), expected)) << way.name;
    }
}

TEST_F(Extremes, FieldsOfView) {
    const scene::Pose pose = poseAt({0.25, 0.05, -0.2}, 0.6, 0.15);
    scene::Camera aside = cameraOf(kWidth, kHeight, 1.2), beyond = aside;
    aside.cx = 3, aside.cy = 117;
    beyond.cx = -2000, beyond.cy = 900;
    struct Case {
        const char* name;
        scene::Camera camera;
        bool isDense;         ///< drawn from an image taken as densely
        double points, faces; ///< least share of the picture that is right
    };
    const scene::Camera narrow = cameraOf(kWidth, kHeight, kPi / 180);
    const Case cases[] = {{"1 degree", narrow, false, 0, 1},
                          {"1 degree, dense", narrow, true, 0.98, 0.98},
                          {"175 degrees", cameraOf(kWidth, kHeight, 175 * kPi / 180), false, 0.2, 0.96},
                          {"aside", aside, false, 0.85, 0.98},
                          {"beyond", beyond, false, 0, 1}};
    Studio around(roomAllAround());
    const scene::Camera taker{400, 300, 1.9 * narrow.fx, 1.9 * narrow.fx, 200, 150};
    Studio dense(cutInLevels({takeRoom(taker, poseAt({0.251, 0.05, -0.2}, 0.6, 0.15))}));
    const Overlay overlay = crossAt(pose * glm::dvec3(0.01, 0.01, 0.3));
    for (const Case& c : cases) {
        Studio& studio = c.isDense ? dense : around;
        const scene::View view{c.camera, pose};
        for (const Way& way : ways()) {
            const EyeImage drawn = studio.draw(view, way.quality);
            EXPECT_TRUE(isSane(drawn)) << way.name;
            const bool isCoarse = way.quality.resolutionScale < 1;
            const double right = shareOfTruth(drawn, view);
            EXPECT_GE(right, isOfSurfaces(way.quality.warp) ? c.faces - (isCoarse ? 0.1 : 0) : c.points)
                << c.name << ", " << way.name;
            if (const auto truth = studio.drawByProcessor(view, way.quality)) {
                EXPECT_LE(shareThatDiffers(drawn, *truth, 255), 0.002) << c.name << ", " << way.name;
            }
            // Lines through the eye and letters before it change colours alone.
            const EyeImage marked = studio.draw(view, way.quality, &overlay);
            EXPECT_EQ(marked.depthMetres, drawn.depthMetres) << c.name << ", " << way.name;
            EXPECT_EQ(marked.pixelClass, drawn.pixelClass) << c.name << ", " << way.name;
        }
    }
}

/// Metres of depth to where a pixel's ray enters the quarter that nobody looked into; infinite if it does not.
double enterQuarter(const scene::View& eye, const glm::dvec3& offset, int x, int y) {
    const glm::dvec3 from = eye.worldFromEye.translation - offset;
    const glm::dvec3 ray = eye.worldFromEye.rotation * rayThrough(eye.camera, x + 0.5, y + 0.5);
    const glm::dvec3 low = (glm::dvec3(0, -8, 0) - from) / ray, high = (glm::dvec3(4, 8, 4) - from) / ray;
    const glm::dvec3 in = glm::min(low, high), out = glm::max(low, high);
    const double enter = std::max({in.x, in.y, in.z, 0.0});
    return enter < std::min({out.x, out.y, out.z}) ? enter : INFINITY;
}

TEST_F(Extremes, TheUnseenIsWhereItIs) {
    for (const double far : {0.0, 1e7}) {
        const glm::dvec3 offset(far, -far, far / 3);
        const scene::Coverage coverage = quarterUnseen(offset);
        Studio without(movedBy(roomAllAround(), offset)), with(movedBy(roomAllAround(), offset), &coverage);
        scene::Camera aside = cameraOf(kWidth, kHeight, 1.2);
        aside.cx = -2000;
        for (const scene::Camera& camera :
             {cameraOf(kWidth, kHeight, kPi / 180), cameraOf(kWidth, kHeight, 175 * kPi / 180), aside})
            for (const glm::dvec3& place : {glm::dvec3(0.25, 0.05, -0.2), glm::dvec3(2, 0, -1e-4)})
                for (const double yaw : {0.4, -0.9}) {
                    const scene::View view{camera, poseAt(offset + place, yaw, 0.1)};
                    const EyeImage before = without.draw(view, qualityOf(Warp::mesh));
                    const EyeImage drawn = with.draw(view, qualityOf(Warp::mesh));
                    EXPECT_TRUE(isSane(drawn));
                    const double wrong = shareOf(drawn, [&](int x, int y) {
                        const double enter = enterQuarter(view, offset, x, y);
                        const auto shown = static_cast<double>(before.depthMetres(x, y));
                        const bool isUnseen = enter < (before.pixelClass(x, y) != 0 ? 0.996 * shown : 1e30);
                        const auto depth = static_cast<double>(drawn.depthMetres(x, y));
                        if (!isUnseen) return drawn.pixelClass(x, y) != before.pixelClass(x, y) || depth != shown;
                        return drawn.pixelClass(x, y) != 3 || std::abs(depth - enter) > 1e-4 + 1e-4 * enter;
                    });
                    EXPECT_LE(wrong, 0.003)
                        << "far " << far << ", yaw " << yaw << ", f " << camera.fx << ", at " << place.x;
                }
    }
}

TEST_F(Extremes, DisparityZero) {
    std::vector<scene::DepthImage> faces = roomFromWithin(48).images;
    for (scene::DepthImage& face : faces) {
        face.camera.fx = face.camera.fy = 22; // neighbours overlap by some samples
        for (float& disparity : face.disparity.pixels())
            disparity = 0;
        for (std::uint8_t& flags : face.flags.pixels())
            flags = 0;
        for (scene::Rgb8& colour : face.colour.pixels())
            colour = {200, 100, 50};
    }
    const scene::Coverage seen = [] {
        scene::Coverage all = quarterUnseen();
        all.nodes[0].unseen = 0;
        return all;
    }();
    Studio studio(cutInLevels(std::move(faces)), &seen);
    for (const double field : {0.3, 1.2, 175 * kPi / 180})
        for (const double yaw : {0.0, 0.8, 2.5, 4.1})
            for (const glm::dvec3& place : {glm::dvec3(0), glm::dvec3(3, 2, -4)}) {
                const scene::View view{cameraOf(kWidth, kHeight, field), poseAt(place, yaw, 0.2)};
                for (const Way& way : ways()) {
                    const EyeImage drawn = studio.draw(view, way.quality);
                    EXPECT_TRUE(isSane(drawn)) << way.name << ", field " << field << ", yaw " << yaw;
                    const double sky = shareOf(drawn, [&](int x, int y) {
                        return std::isinf(drawn.depthMetres(x, y)) && drawn.depthMetres(x, y) > 0 &&
                               drawn.colour(x, y) == scene::Rgb8{200, 100, 50};
                    });
                    if (isOfSurfaces(way.quality.warp)) {
                        EXPECT_EQ(sky, 1) << way.name << ", field " << field << ", yaw " << yaw;
                    }
                }
            }
}

TEST_F(Extremes, NothingToFillHolesFrom) {
    Studio studio(CutScene{});
    for (const Way& way : ways()) {
        Quality quality = way.quality;
        quality.holes.radius = kMostHoleRadius;
        const EyeImage drawn = studio.draw({cameraOf(kWidth, kHeight, 1.2), {}}, quality);
        EXPECT_TRUE(isSane(drawn)) << way.name;
        EXPECT_EQ(coverage(drawn), 0.0) << way.name;
    }
}

/// The middle of what is brighter than the wall, pixels.
glm::dvec2 centroidOf(const EyeImage& image) {
    glm::dvec2 sum(0);
    double weight = 0;
    for (int y = 0; y < image.colour.height(); ++y)
        for (int x = 0; x < image.colour.width(); ++x) {
            const double bright = std::max(image.colour(x, y).g - 40, 0);
            sum += bright * glm::dvec2(x + 0.5, y + 0.5);
            weight += bright;
        }
    return sum / weight;
}

TEST_F(Extremes, NoJitterAlongAMillimetre) {
    const glm::dvec3 offset(1e7, -1e7, 1e7);
    const scene::Camera camera = cameraOf(200, 150, 0.1);
    const glm::dvec3 normal = glm::normalize(glm::dvec3(0.2, 0.1, 1));
    scene::DepthImage wall = takePlane(camera, normal, 2);
    wall.worldFromCamera = {glm::dmat3(1), offset};
    const glm::dvec2 markAt(104, 71);
    for (int y = 0; y < 150; ++y)
        for (int x = 0; x < 200; ++x) {
            const double r = glm::length(glm::dvec2(x + 0.5, y + 0.5) - markAt);
            const auto bright = static_cast<std::uint8_t>(std::lround(40 + 200 * std::clamp((20 - r) / 8, 0.0, 1.0)));
            wall.colour(x, y) = {bright, bright, bright};
        }
    const glm::dvec3 ray = rayThrough(camera, markAt.x, markAt.y);
    const glm::dvec3 mark = offset + ray * (2 / glm::dot(normal, ray));
    Studio studio(cutInLevels({wall}));
    const glm::dvec3 step = 2e-5 * glm::normalize(glm::dvec3(1, 0.6, 0.3)); // 0.024 pixels
    for (const Way& way : ways()) {
        glm::dvec2 least(1e9), most(-1e9), last(0);
        double worstStep = 0;
        int worstChange = 0;
        EyeImage before;
        for (int i = 0; i <= 50; ++i) {
            const glm::dvec3 place = offset + glm::dvec3(0.01, 0.02, 0.1) + static_cast<double>(i) * step;
            const scene::View view{cameraOf(kWidth, kHeight, 0.07), {glm::dmat3(1), place}};
            EyeImage drawn = studio.draw(view, way.quality);
            const glm::dvec2 error = centroidOf(drawn) - project(view.camera, mark - place);
            least = glm::min(least, error), most = glm::max(most, error);
            if (i > 0) {
                worstStep = std::max(worstStep, glm::length(error - last));
                for (std::size_t p = 0; p < drawn.colour.size(); ++p)
                    worstChange =
                        std::max(worstChange, std::abs(drawn.colour.pixels()[p].g - before.colour.pixels()[p].g));
            }
            last = error;
            before = std::move(drawn);
        }
        // Squares and circles of whole pixels move by whole pixels, each for itself; the mark they make moves smoothly.
        const bool isSmooth = isOfSurfaces(way.quality.warp) || way.quality.isBlended;
        const bool isBetween = way.quality.interpolatesSamples;
        EXPECT_LE(glm::length(most - least), isSmooth    ? 0.03
                                             : isBetween ? 0.15
                                                         : 0.3)
            << way.name << ": beside the mark's true path";
        EXPECT_LE(worstStep, isSmooth ? 0.012 : isBetween ? 0.05 : 0.15) << way.name << ": from picture to picture";
        if (isSmooth) {
            EXPECT_LE(worstChange, 4) << way.name << ": a pixel from picture to picture";
        } else if (isBetween) {
            EXPECT_LE(worstChange, 18) << way.name << ": a pixel from picture to picture"; // 36 without
        }
    }
}

} // namespace
} // namespace render
