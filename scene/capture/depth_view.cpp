#include "scene/capture/depth_view.h"

#include "scene/capture/cube_capture.h"

namespace scene {

DepthImage traceDepth(const PolygonTracer& tracer, const View& view) {
    const Camera& camera = view.camera;
    DepthImage image;
    image.camera = camera;
    image.worldFromCamera = view.worldFromEye;
    image.colour = Image<Rgb8>(camera.width, camera.height);
    image.disparity = Image<float>(camera.width, camera.height, 0.0f);
    image.flags = Image<std::uint8_t>(camera.width, camera.height, kNoSurface);
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
            // The ray is 1 long along z, so that its length there is the depth.
            const glm::dvec3 ray = view.worldFromEye.rotation * rayThrough(camera, x + 0.5, y + 0.5);
            const std::optional<PolygonHit> hit = tracer.cast(view.worldFromEye.translation, ray);
            if (!hit) continue;
            image.disparity(x, y) = static_cast<float>(1 / hit->t);
            image.flags(x, y) = 0;
        }
    return image;
}

std::vector<DepthImage> traceDepthCube(const PolygonTracer& tracer, const glm::dvec3& positionInWorld, int faceSize) {
    std::vector<DepthImage> faces;
    for (int face = 0; face < kFaceCount; ++face)
        faces.push_back(traceDepth(tracer, faceView(face, positionInWorld, faceSize)));
    return faces;
}

} // namespace scene
