#include "scene/view.h"

namespace scene {

glm::dmat4 eyeImageFromSourceImage(const View& eye, const Camera& source, const Pose& worldFromSource) {
    // The two positions cancel in double precision before anything is rounded: what is left is relative to the eye.
    const Pose eyeFromSource = inverse(eye.worldFromEye) * worldFromSource;
    return imageFromCamera(eye.camera) * toMatrix(eyeFromSource) * cameraFromImage(source);
}

std::pair<View, View> eyesOf(const Camera& camera, const Pose& worldFromHead, double eyeDistanceMetres) {
    const auto eyeAt = [&](double xInHead) {
        return View{camera, worldFromHead * Pose{glm::dmat3(1.0), glm::dvec3(xInHead, 0, 0)}};
    };
    return {eyeAt(-eyeDistanceMetres / 2), eyeAt(eyeDistanceMetres / 2)};
}

} // namespace scene
