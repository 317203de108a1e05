#include "scene/capture/cube_capture.h"

#include "scene/project/cube_faces.h"

#include "tests/scene/capture/known_polygons.h"

#include <cmath>

#include <gtest/gtest.h>

namespace scene {
namespace {

constexpr int kSize = 36;

TEST(CubeCapture, FacesLookWhereTheyShould) {
    const glm::dvec3 place(1, 2, 3);
    const auto forward = [&](int face) { return faceView(face, place, kSize).worldFromEye.rotation[2]; };
    const auto top = [&](int face) { return -faceView(face, place, kSize).worldFromEye.rotation[1]; };
    EXPECT_EQ(forward(0), glm::dvec3(0, 0, -1)) << "front";
    EXPECT_EQ(forward(1), glm::dvec3(-1, 0, 0)) << "left";
    EXPECT_EQ(forward(2), glm::dvec3(0, 0, 1)) << "back";
    EXPECT_EQ(forward(3), glm::dvec3(1, 0, 0)) << "right";
    EXPECT_EQ(forward(4), glm::dvec3(0, 1, 0)) << "up";
    EXPECT_EQ(forward(5), glm::dvec3(0, -1, 0)) << "down";
    for (int side = 0; side < 4; ++side)
        EXPECT_EQ(top(side), glm::dvec3(0, 1, 0));
    EXPECT_EQ(top(4), glm::dvec3(0, 0, 1)) << "looking up, what is behind is at the top";
    EXPECT_EQ(top(5), glm::dvec3(0, 0, -1));
    for (int face = 0; face < kFaceCount; ++face) {
        const View view = faceView(face, place, kSize);
        EXPECT_EQ(view.worldFromEye.translation, place);
        EXPECT_NEAR(glm::determinant(view.worldFromEye.rotation), 1.0, 1e-12);
        EXPECT_NEAR(rayThrough(view.camera, kMeshOverlapPixels, 7).x, -1.0, 1e-12) << "45 degrees to the side";
    }
}

TEST(CubeCapture, FacesAreThoseOfAScanThere) {
    // A scanner whose +Z is the world's +Y and whose +X looks along the world's -Z.
    Scan scan;
    scan.name = "s";
    scan.worldFromScanner = {glm::dmat3(0, 0, -1, -1, 0, 0, 0, 1, 0), glm::dvec3(1, 2, 3)};
    for (const glm::vec3& p :
         {glm::vec3(1, 0, 0), glm::vec3(-1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, -1, 0), glm::vec3(0, 0, 1),
          glm::vec3(0, 0, -1), glm::vec3(1, 0.9f, 0.1f), glm::vec3(-1, 0.9f, 0.1f)})
        scan.pointsInScanner.push_back(p * 3.0f), scan.colours.push_back({9, 9, 9});
    const CubeFaces faces = projectToCubeFaces(scan);
    ASSERT_EQ(faces.faces.size(), 6u);
    for (int face = 0; face < kFaceCount; ++face) {
        const Pose mine = faceView(face, {1, 2, 3}, kSize).worldFromEye;
        const DepthImage& theirs = faces.faces[static_cast<std::size_t>(face)];
        EXPECT_EQ(theirs.name, std::string("s-") + kFaceNames[static_cast<std::size_t>(face)]);
        for (int axis = 0; axis < 3; ++axis)
            EXPECT_LT(glm::distance(mine.rotation[axis], theirs.worldFromCamera.rotation[axis]), 1e-12) << face;
    }
}

TEST(CubeCapture, EveryDirectionIsSeenAndFacesAgreeWhereTheyMeet) {
    const glm::dvec3 low(-3, 0, -4), high(5, 2.7, 6), place(0.3, 1.6, -0.7);
    const PolygonScene scene = sceneOf(boxMesh(glm::vec3(low), glm::vec3(high), true));
    const PolygonTracer tracer(scene);
    const SurfaceLight light(tracer, evenLight());
    std::vector<DepthImage> faces;
    captureCube(tracer, light, "p007", place, kSize, {}, [&](const DepthImage& face) { faces.push_back(face); });
    ASSERT_EQ(faces.size(), 6u);
    EXPECT_EQ(faces[0].name, "p007-front");
    EXPECT_EQ(faces[5].name, "p007-down");
    for (int i = 0; i < 2000; ++i) {
        const glm::dvec3 d(std::sin(i * 1.7 + 0.3), std::cos(i * 2.9), std::sin(i * 0.77 + 1.1));
        int seen = 0;
        for (const DepthImage& face : faces) {
            const glm::dvec3 inFace = glm::transpose(face.worldFromCamera.rotation) * d;
            if (inFace.z <= 0) continue;
            const glm::dvec2 at = project(face.camera, inFace);
            if (at.x < 0 || at.y < 0 || at.x >= kSize || at.y >= kSize) continue;
            ++seen;
            // The sample there is a point of the box, exactly.
            const int x = static_cast<int>(at.x), y = static_cast<int>(at.y);
            const glm::dvec3 p = face.worldFromCamera * (rayThrough(face.camera, x + 0.5, y + 0.5) /
                                                         static_cast<double>(face.disparity(x, y)));
            double toSide = INFINITY;
            for (int axis = 0; axis < 3; ++axis)
                toSide = std::min({toSide, std::abs(p[axis] - low[axis]), std::abs(p[axis] - high[axis])});
            EXPECT_LT(toSide, 1e-5);
        }
        EXPECT_GE(seen, 1) << i;
        const double most = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
        const glm::dvec3 n = glm::abs(d) / most;
        const int nearEdges = (n.x > 0.95) + (n.y > 0.95) + (n.z > 0.95);
        EXPECT_GE(seen, nearEdges) << "faces overlap where they meet, so that meshes leave no seam";
    }
}

} // namespace
} // namespace scene
