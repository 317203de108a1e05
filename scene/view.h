#pragma once
// An eye: where it is and what it can see. An eye is a camera; what it is shown is a depth image of the
// scene.

#include "scene/camera.h"
#include "scene/pose.h"

#include <utility>

namespace scene {

struct View {
    Camera camera;
    Pose worldFromEye;
    friend bool operator==(const View&, const View&) = default;
};

/// C = P V M of the whole source image (Nyland et al. 1999, eq. 2), composed in double precision: a sample
/// (x, y, 1, d) of the source becomes h = (u w, v w, w, d), seen at (u, v) with disparity d / w, provided w >
/// 0.
glm::dmat4 eyeImageFromSourceImage(const View& eye, const Camera& source, const Pose& worldFromSource);

/// Left and right eye of a head, eyeDistance apart along the head's x axis, looking in parallel.
std::pair<View, View> eyesOf(const Camera& camera, const Pose& worldFromHead, double eyeDistanceMetres);

} // namespace scene
