#include "scene/view.h"

#include <glm/matrix.hpp>

namespace scene {

glm::dmat4 eyeImageFromSourceImage(const View& eye, const Camera& source, const Pose& worldFromSource) {
    // The positions are subtracted first, which is exact where they are near each other: rotating each of
    // them would leave nanometres of rounding at 10^7 m, and 0.1 mm before a surface a nanometre is 0.01
    // pixels.
    const glm::dmat3 eyeFromWorldRotation = glm::transpose(eye.worldFromEye.rotation);
    const Pose eyeFromSource{eyeFromWorldRotation * worldFromSource.rotation,
                             eyeFromWorldRotation * (worldFromSource.translation - eye.worldFromEye.translation)};
    return imageFromCamera(eye.camera) * toMatrix(eyeFromSource) * cameraFromImage(source);
}

std::pair<View, View> eyesOf(const Camera& camera, const Pose& worldFromHead, double eyeDistanceMetres) {
    const auto eyeAt = [&](double xInHead) {
        return View{camera, worldFromHead * Pose{glm::dmat3(1.0), glm::dvec3(xInHead, 0, 0)}};
    };
    return {eyeAt(-eyeDistanceMetres / 2), eyeAt(eyeDistanceMetres / 2)};
}

} // namespace scene
