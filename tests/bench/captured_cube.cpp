#include "tests/bench/captured_cube.h"

#include "scene/capture/cube_capture.h"
#include "scene/refine/skins.h"

std::vector<CapturedFace> captureForWarp(const scene::PolygonTracer& tracer, const scene::SurfaceLight& light,
                                         const glm::dvec3& position, int faceSize) {
    std::vector<CapturedFace> cube;
    scene::captureCube(tracer, light, "p", position, faceSize, {}, [&](const scene::DepthImage& taken) {
        scene::DepthImage image = taken;
        scene::SkinFigures figures;
        image.flags = scene::markPlanarSkins(image, scene::SkinOptions{}.planarity, figures);
        scene::TileSet tiles = scene::cutIntoTiles(image);
        cube.push_back({std::move(image), std::move(tiles)});
    });
    return cube;
}
