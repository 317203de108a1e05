// Ordinary polygons: what they look like against rays, and that they share the z-buffer with images wherever those were
// taken from.

#include "tests/render/test_device.h"
#include "tests/render/test_scenes.h"

#include "render/gpu_polygons.h"
#include "render/shaders/shared/polygons.h"
#include "render/warp/polygon_pass.h"

#include <array>
#include <cmath>
#include <tuple>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace render {
namespace {

using Polygons = RenderTest;

constexpr double kDisparityStep = 1e-5; // relative: float attributes over the screen
const glm::dvec3 kUp(0, -1, 0);         // of test_scenes: y is down

EyeImage draw(const GpuScene& images, const scene::PolygonScene& polygons, const scene::View& view,
              const Quality& quality = {}) {
    const GpuPolygons onDevice(testDevice(), polygons, kUp);
    Renderer renderer(testDevice(), images, view.camera.width, view.camera.height, 1, nullptr, &onDevice);
    renderer.draw({&view, 1}, quality);
    return renderer.readBack()[0];
}

/// Depth at which a pixel's ray meets the rectangle's plane; nothing beyond its edges by more than a pixel's width.
struct RayOnRectangle {
    double z = 0;
    double edge = 0; ///< how far inside, as a share of its sides; negative outside
};
RayOnRectangle meet(const scene::PolygonMesh& mesh, const scene::View& view, int x, int y) {
    const glm::dvec3 corner(mesh.positions[0]), across = glm::dvec3(mesh.positions[1]) - corner,
                                                down = glm::dvec3(mesh.positions[3]) - corner;
    const glm::dvec3 ray = view.worldFromEye.rotation * scene::rayThrough(view.camera, x + 0.5, y + 0.5);
    const glm::dvec3 normal = glm::cross(across, down);
    RayOnRectangle met;
    met.z = glm::dot(corner - view.worldFromEye.translation, normal) / glm::dot(ray, normal);
    const glm::dvec3 p = view.worldFromEye.translation + met.z * ray - corner;
    const double u = glm::dot(glm::cross(p, down), normal) / glm::dot(normal, normal),
                 v = glm::dot(glm::cross(across, p), normal) / glm::dot(normal, normal);
    met.edge = std::min({u, 1 - u, v, 1 - v});
    if (met.z <= 0) met.edge = -1;
    return met;
}

TEST_F(Polygons, StandWhereRaysMeetThem) {
    const scene::View view{cameraOf(320, 240, 1.2), poseAt({0.3, 0.1, -0.2}, 0.2, -0.1)};
    const scene::PolygonScene polygons = rectangle({-1.2f, -0.8f, 2}, {2, 0.3f, 1.5f}, {-0.1f, 1.6f, 0.2f});
    const EyeImage drawn = draw(GpuScene(testDevice(), {}), polygons, view);
    int inside = 0;
    for (int y = 0; y < 240; ++y)
        for (int x = 0; x < 320; ++x) {
            const RayOnRectangle met = meet(polygons.meshes[0], view, x, y);
            if (std::abs(met.edge) < 0.01) continue; // either is right
            ASSERT_EQ(drawn.pixelClass(x, y), met.edge > 0 ? kClassFilled : kClassBackground) << x << " " << y;
            if (met.edge < 0) continue;
            ++inside;
            ASSERT_NEAR(drawn.depthMetres(x, y), met.z, kDisparityStep * met.z) << x << " " << y;
        }
    EXPECT_GT(inside, 10000);
}

TEST_F(Polygons, AreOfTheirColourInAnEvenSky) {
    const scene::View view{cameraOf(64, 64, 1.0), {}};
    const auto colourOf = [&](const glm::vec3& across, const glm::vec3& down) {
        const scene::PolygonScene polygons =
            rectangle(glm::vec3(0, 0, 2) - 0.5f * (across + down), across, down, {0.8f, 0.4f, 0.1f});
        return draw(GpuScene(testDevice(), {}), polygons, view).colour(32, 32);
    };
    const auto expected = [&](float facingUp) {
        const auto channel = [&](float linear) {
            return static_cast<int>(std::lround(255 * encodedChannel(linear * skyLight(facingUp))));
        };
        return std::array{channel(0.8f), channel(0.4f), channel(0.1f)};
    };
    const auto expectNear = [](const scene::Rgb8& drawn, const std::array<int, 3>& wanted) {
        EXPECT_NEAR(drawn.r, wanted[0], 1);
        EXPECT_NEAR(drawn.g, wanted[1], 1);
        EXPECT_NEAR(drawn.b, wanted[2], 1);
    };
    expectNear(colourOf({2, 0, 0}, {0, 2, 0}), expected(0)); // a wall
    // Leaning: its normal (by its winding) has a part that points up, and the other way round down.
    const float lean = std::sqrt(0.5f);
    expectNear(colourOf({2, 0, 0}, {0, 2 * lean, 2 * lean}), expected(lean));
    expectNear(colourOf({0, 2 * lean, 2 * lean}, {2, 0, 0}), expected(-lean));
}

TEST_F(Polygons, AndImagesHideEachOtherWhereverTheImagesWereTaken) {
    // A wall that was photographed from far behind the eye: its samples are pushed back in order. The rectangle crosses
    // it, so that one hides the other along a line that is known.
    const scene::Camera camera = cameraOf(400, 300, 1.0);
    scene::DepthImage wall = takePlane(camera, {0.1, 0, 1}, 6);
    wall.worldFromCamera.translation = {0, 0, -3};
    const CutScene images = cut({wall});
    const GpuScene onDevice(testDevice(), images.blocks());
    const scene::View view{cameraOf(320, 240, 0.6), {}};
    const scene::PolygonScene polygons = rectangle({-2, -2, 2.2f}, {4, 0, 1.6f}, {0, 4, 0});
    for (const float nearBaseline : {0.0f, 0.02f}) {
        Quality quality;
        quality.preference.nearBaseline = nearBaseline;
        const EyeImage alone = drawOnce(onDevice, view, quality), both = draw(onDevice, polygons, view, quality);
        int wallSeen = 0, rectangleSeen = 0;
        for (int y = 0; y < 240; ++y)
            for (int x = 0; x < 320; ++x) {
                const RayOnRectangle met = meet(polygons.meshes[0], view, x, y);
                const double wallZ = alone.depthMetres(x, y);
                ASSERT_GT(wallZ, 0);
                if (std::abs(met.edge) < 0.01 || std::abs(wallZ - met.z) < 1e-3) continue;
                const bool isWall = met.edge < 0 || wallZ < met.z;
                ASSERT_EQ(both.pixelClass(x, y), isWall ? kClassSeen : kClassFilled) << x << " " << y;
                isWall ? ++wallSeen : ++rectangleSeen;
                if (isWall) {
                    ASSERT_EQ(both.colour(x, y), alone.colour(x, y));
                    ASSERT_NEAR(both.depthMetres(x, y), wallZ, 1e-6);
                } else
                    ASSERT_NEAR(both.depthMetres(x, y), met.z, kDisparityStep * met.z);
            }
        EXPECT_GT(wallSeen, 20000);
        EXPECT_GT(rectangleSeen, 20000);
    }
}

/// In a room that was photographed, 63 mm apart, looking at polygons.
struct TwoEyes {
    explicit TwoEyes(const scene::PolygonScene& polygons) : drawn(testDevice(), polygons, kUp) {
        std::tie(eyes[0], eyes[1]) = scene::eyesOf(cameraOf(160, 120, 1.0), {}, 0.063);
    }
    CutScene images = roomFromWithin(64);
    GpuScene onDevice{testDevice(), images.blocks()};
    GpuPolygons drawn;
    std::array<scene::View, 2> eyes;
    Renderer renderer{testDevice(), onDevice, 160, 120, 2, nullptr, &drawn};
};

/// What share of a pixel the rectangle covers, by 16 x 16 rays.
double coverOf(const scene::PolygonMesh& mesh, const scene::View& view, int x, int y) {
    scene::View finer = view;
    finer.camera = scene::resized(view.camera, 16 * view.camera.width, 16 * view.camera.height);
    int inside = 0;
    for (int j = 0; j < 16; ++j)
        for (int i = 0; i < 16; ++i)
            inside += meet(mesh, finer, 16 * x + i, 16 * y + j).edge > 0;
    return inside / 256.0;
}

TEST_F(Polygons, EdgesAreMixedWithWhatStandsBehindByWhatTheyCover) {
    const int samples = edgeSamplesOf(testDevice(), 4);
    if (samples < 4) GTEST_SKIP() << "because this device has no more than " << samples << " samples of a pixel";
    // A black rectangle, leaning, before a wall that is all white.
    scene::DepthImage wall = takePlane(cameraOf(400, 300, 1.4), {0, 0, 1}, 4);
    for (scene::Rgb8& colour : wall.colour.pixels())
        colour = {255, 255, 255};
    const CutScene images = cut({wall});
    const GpuScene onDevice(testDevice(), images.blocks());
    const scene::View view{cameraOf(160, 120, 0.8), {}};
    const scene::PolygonScene polygons =
        rectangle({-0.6f, -0.5f, 2}, {1.1f, 0.2f, 0}, {-0.1f, 0.9f, 0.3f}, glm::vec3(0.0f));
    Quality single, smooth;
    smooth.edgeSamples = 4;
    const EyeImage hard = draw(onDevice, polygons, view, single), soft = draw(onDevice, polygons, view, smooth);
    EXPECT_TRUE(isSame(soft, draw(onDevice, polygons, view, smooth)));
    double hardOff = 0, softOff = 0;
    int edges = 0;
    for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 160; ++x) {
            const double cover = coverOf(polygons.meshes[0], view, x, y);
            if (cover == 0 || cover == 1) {
                ASSERT_EQ(soft.colour(x, y), hard.colour(x, y)) << x << " " << y;
                ASSERT_EQ(soft.pixelClass(x, y), cover == 1 ? kClassFilled : kClassSeen);
                ASSERT_NEAR(soft.depthMetres(x, y), hard.depthMetres(x, y), 1e-4 * hard.depthMetres(x, y));
                continue;
            }
            ++edges;
            hardOff += std::abs(1 - hard.colour(x, y).g / 255.0 - cover);
            softOff += std::abs(1 - soft.colour(x, y).g / 255.0 - cover);
            if (cover > 0.3 && cover < 0.7) continue;
            ASSERT_EQ(soft.pixelClass(x, y), cover > 0.5 ? kClassFilled : kClassSeen) << "what it is mostly";
        }
    ASSERT_GT(edges, 150);
    EXPECT_GT(hardOff / edges, 0.2) << "the test must see what it looks for";
    EXPECT_LT(softOff / edges, 0.1) << "a quarter of a pixel is the least that four samples tell";
}

TEST_F(Polygons, SamplesOfAPixelMayChangeFromFrameToFrame) {
    TwoEyes walker(rectangle({-0.5f, -0.5f, 2}, {1, 0.1f, 0}, {0, 1, 0}, {0.9f, 0.1f, 0.1f}));
    std::vector<std::vector<EyeImage>> pictures;
    for (const int samples : {1, 4, 2, 8, 1, 4}) {
        Quality quality;
        quality.edgeSamples = samples;
        walker.renderer.draw(walker.eyes, quality);
        pictures.push_back(walker.renderer.readBack());
    }
    for (const std::size_t eye : {0, 1}) {
        EXPECT_TRUE(isSame(pictures[0][eye], pictures[4][eye]));
        EXPECT_TRUE(isSame(pictures[1][eye], pictures[5][eye]));
        EXPECT_EQ(isSame(pictures[0][eye], pictures[1][eye]), edgeSamplesOf(testDevice(), 4) == 1);
    }
}

TEST_F(Polygons, StayAsTheyAreWhereSamplesAreBlendedAndHolesFilled) {
    std::vector<scene::DepthImage> unmeasured = roomFromThreePlaces();
    for (scene::DepthImage& image : unmeasured)
        for (std::uint8_t& flags : image.flags.pixels())
            flags = static_cast<std::uint8_t>(flags | scene::kInterpolated);
    const CutScene measured = roomFromWithin(128), closed = cut(std::move(unmeasured));
    const scene::View view{cameraOf(320, 240, 1.2), poseAt({0.2, 0, 0.1}, 0.3, 0)};
    // Touching what is behind it: samples of the wall stand as near as they are ever blended.
    const scene::PolygonScene polygons = rectangle({-1, -1, 2.99f}, {2, 0, 0}, {0, 2, 0}, {0.9f, 0.0f, 0.9f});
    Quality blended;
    blended.isBlended = true;
    blended.holes.radius = 4;
    const EyeImage alone = draw(GpuScene(testDevice(), {}), polygons, view);
    for (const CutScene* images : {&measured, &closed}) {
        const GpuScene onDevice(testDevice(), images->blocks());
        const EyeImage both = draw(onDevice, polygons, view, blended);
        int shown = 0;
        for (std::size_t i = 0; i < both.colour.size(); ++i) {
            if (alone.pixelClass.pixels()[i] != kClassFilled) continue;
            if (both.depthMetres.pixels()[i] != alone.depthMetres.pixels()[i]) continue; // something stands before it
            ASSERT_EQ(both.colour.pixels()[i], alone.colour.pixels()[i]);
            ++shown;
        }
        EXPECT_GT(shown, 5000);
    }
}

TEST_F(Polygons, HaveHolesWhereTheirTextureIsCutOut) {
    scene::PolygonScene polygons = rectangle({-1, -1, 2}, {2, 0, 0}, {0, 2, 0});
    scene::PolygonTexture leaf{"leaf", scene::Image<scene::Rgba8>(64, 64, {200, 100, 50, 255})};
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 32; ++x)
            leaf.pixels(x, y).a = 0; // the left half
    for (int x = 0; x < 64; ++x)
        for (int y = 0; y < 32; ++y)
            leaf.pixels(x, y).r = 20; // the upper half is greener
    polygons.textures.push_back(leaf);
    polygons.materials[0].colourTexture = polygons.materials[0].alphaTexture = 0;
    const scene::View view{cameraOf(100, 100, 0.8), {}};
    const EyeImage drawn = draw(GpuScene(testDevice(), {}), polygons, view);
    EXPECT_EQ(drawn.pixelClass(30, 50), kClassBackground);
    EXPECT_EQ(drawn.pixelClass(70, 50), kClassFilled);
    EXPECT_LT(drawn.colour(70, 30).r, 40) << "the picture's first row is its top";
    EXPECT_GT(drawn.colour(70, 70).r, 80);
}

TEST_F(Polygons, StandInNationalGridsAndInSeveralPlaces) {
    const glm::dvec3 far(3.5e6, -5.5e6, 120);
    scene::PolygonScene here = rectangle({-0.5f, -0.5f, 0}, {1, 0, 0}, {0, 1, 0}, {0.3f, 0.7f, 0.2f});
    here.instances = {{0, glm::translate(glm::dmat4(1), glm::dvec3(-0.7, 0, 3))},
                      {0, glm::scale(glm::translate(glm::dmat4(1), glm::dvec3(0.7, 0, 4)), glm::dvec3(-1, 1, 1))}};
    scene::PolygonScene there = here;
    for (scene::PolygonInstance& instance : there.instances)
        instance.worldFromMesh[3] += glm::dvec4(far, 0);
    const scene::View view{cameraOf(200, 150, 1.0), {}};
    scene::View farView = view;
    farView.worldFromEye.translation += far;
    const EyeImage near = draw(GpuScene(testDevice(), {}), here, view);
    const EyeImage away = draw(GpuScene(testDevice(), {}), there, farView);
    EXPECT_EQ(near.colour, away.colour);
    EXPECT_EQ(near.pixelClass(60, 75), kClassFilled);
    EXPECT_EQ(near.pixelClass(130, 75), kClassFilled);
    EXPECT_NEAR(near.depthMetres(60, 75), 3, 1e-4);
    EXPECT_NEAR(away.depthMetres(130, 75), 4, 1e-4);
}

TEST_F(Polygons, OfGlassAreNotThereAndSceneWithoutAnyDrawsAsBefore) {
    scene::PolygonScene polygons = rectangle({-1, -1, 2}, {2, 0, 0}, {0, 2, 0});
    polygons.materials[0].isGlass = true;
    const CutScene images = roomFromWithin(64);
    const GpuScene onDevice(testDevice(), images.blocks());
    const scene::View view{cameraOf(100, 75, 1.0), {}};
    const GpuPolygons none(testDevice(), polygons, kUp);
    EXPECT_EQ(none.triangles(), 0);
    EXPECT_TRUE(isSame(draw(onDevice, polygons, view), drawOnce(onDevice, view, {})));
}

TEST_F(Polygons, AreDrawnAtOtherResolutionsAndForBothEyesAlike) {
    TwoEyes walker(rectangle({-0.5f, -0.5f, 2}, {1, 0, 0}, {0, 1, 0}, {0.9f, 0.1f, 0.1f}));
    for (const double scale : {1.0, 0.5, 2.0, 1.0}) {
        Quality quality;
        quality.resolutionScale = scale;
        walker.renderer.draw(walker.eyes, quality);
        const FrameStats stats = walker.renderer.finish();
        EXPECT_EQ(stats.eyes[0].trianglesDrawn, 2u);
        const std::vector<EyeImage> pictures = walker.renderer.readBack();
        for (const EyeImage& picture : pictures) {
            EXPECT_EQ(picture.pixelClass(80, 60), kClassFilled) << scale;
            EXPECT_NEAR(picture.depthMetres(80, 60), 2, 1e-3) << scale;
        }
        // The eyes stand 63 mm apart, the rectangle 2 m away.
        const auto edgeOf = [](const EyeImage& picture) {
            int x = 0;
            while (picture.pixelClass(x, 60) != kClassFilled)
                ++x;
            return x;
        };
        EXPECT_NEAR(edgeOf(pictures[0]) - edgeOf(pictures[1]), 0.063 / 2 * walker.eyes[0].camera.fx, 2);
    }
}

TEST_F(Polygons, PartsBesideTheViewAreNotDrawn) {
    scene::PolygonScene polygons = rectangle({-0.5f, -0.5f, 0}, {1, 0, 0}, {0, 1, 0});
    polygons.instances.clear();
    for (const glm::dvec3& place :
         {glm::dvec3(0, 0, 3), glm::dvec3(0, 0, -3), glm::dvec3(20, 0, 3), glm::dvec3(0, 9, 3)})
        polygons.instances.push_back({0, glm::translate(glm::dmat4(1), place)});
    const GpuPolygons onDevice(testDevice(), polygons, kUp);
    const GpuScene none(testDevice(), {});
    const scene::View view{cameraOf(100, 75, 1.0), {}};
    Renderer renderer(testDevice(), none, 100, 75, 1, nullptr, &onDevice);
    renderer.draw({&view, 1}, {});
    EXPECT_EQ(renderer.finish().eyes[0].trianglesDrawn, 2u);
    EXPECT_EQ(onDevice.triangles(), 8);
}

} // namespace
} // namespace render
