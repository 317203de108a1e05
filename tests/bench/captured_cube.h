#pragma once
// What is seen of polygons from a place all round, ready to be warped.

#include "scene/capture/light.h"
#include "scene/depth_image.h"
#include "scene/tile.h"

#include <vector>

struct CapturedFace {
    scene::DepthImage image; ///< skins cut where disparity jumps
    scene::TileSet tiles;
};

std::vector<CapturedFace> captureForWarp(const scene::PolygonTracer& tracer, const scene::SurfaceLight& light,
                                         const glm::dvec3& position, int faceSize);

/// Lent what lends them.
inline void addBlocks(const std::vector<CapturedFace>& cube, std::vector<scene::TileBlock>& blocks) {
    for (const CapturedFace& face : cube)
        blocks.push_back(lend(face.tiles, face.image.camera, face.image.worldFromCamera));
}
