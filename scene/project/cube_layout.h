#pragma once
// The six faces of the cube about a scanner: how each looks, which points are its own, and how large its
// image must be.
// The cube's axes are the scanner's (scene/cube.h), turned about its +Z so that a scanner that saw a part of the
// horizon has the middle of it in front.

#include "scene/camera.h"
#include "scene/cube.h"
#include "scene/project/cube_faces.h"
#include "scene/scan.h"

#include <array>
#include <span>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace scene {

/// Points nearer to the centre of projection than this have no disparity that is worth storing.
inline constexpr double kNearestMetres = 1e-4;

/// Where the cube stands and how it is turned. Face axes: x right, y down, z forward.
struct CubeFrame {
    glm::dvec3 copInScanner{0.0};
    std::array<glm::dmat3, kFaceCount> faceFromScanner;

    glm::dvec3 inFace(int face, const glm::vec3& pInScanner) const {
        return faceFromScanner[static_cast<std::size_t>(face)] * (glm::dvec3(pInScanner) - copInScanner);
    }
    /// The face whose axis is nearest to the point's direction; -1 if it is nearer to the centre than
    /// kNearestMetres.
    int faceOf(const glm::vec3& pInScanner) const;
};

CubeFrame cubeFrame(const Scan& scan, const glm::dvec3& copInScanner);

/// Angles between neighbouring samples, radians.
struct AngularSteps {
    double horizontal = 0, vertical = 0;
};

/// The image of one face; width 0 if no point is its own. Cropped to what the scan covers, and no larger than the
/// scan's points justify: few of them, far apart in angle, must not take memory for millions. Where the scan is a mesh,
/// a face reaches kMeshOverlapPixels beyond its 90 degrees, so that no seam opens between the meshes of two faces.
struct FaceLayout {
    Camera camera;
    bool coarserThanScan = false; ///< the scan's own density was not allowed
};

/// directions: further ones that faces are to reach, though no point is there.
std::array<FaceLayout, kFaceCount> layOutFaces(const Scan& scan, const CubeFrame& frame, const AngularSteps& steps,
                                               bool isMesh, const CubeFaceOptions& options,
                                               std::span<const glm::vec3> directions = {});

} // namespace scene
