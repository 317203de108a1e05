#pragma once
// The six faces of the cube about a reference position or a scanner: their names, and how each is turned.
//
//                 up                 The cube's axes are a scanner's: +Z up. Side faces have +Z up; up and down are
//                 what
//      left front right back         one sees after tilting the head up or down from the front.
//                down

#include <array>
#include <string>

#include <glm/mat3x3.hpp>

namespace scene {

inline constexpr int kFaceCount = 6;
inline constexpr std::array<const char*, kFaceCount> kFaceNames{"front", "left", "back", "right", "up", "down"};

/// Further images of a face, SCAN-front-2 and so on, for points that share a pixel but not a surface: at most.
inline constexpr int kMostFurtherLayers = 8;

/// "scan1" of "scan1-front" and of "scan1-front-2"; other names as they are.
std::string withoutFace(const std::string& imageName);

/// So much further than 90 degrees a face reaches on each side, so that no seam opens between the meshes of two faces.
inline constexpr int kMeshOverlapPixels = 2;

/// Rotations into the axes of each face (x right, y down, z forward); the front looks along this azimuth, radians from
/// the cube's +X about +Z.
std::array<glm::dmat3, kFaceCount> facesFromCube(double frontAzimuthRadians);

} // namespace scene
