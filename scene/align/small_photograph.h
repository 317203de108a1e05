#pragma once

#include "scene/camera.h"
#include "scene/image.h"

namespace scene {

/// A photograph without distortion, no larger than laying it on others asks for: those of a scan are kept together.
struct SmallPhotograph {
    Image<Rgb8> picture;
    Camera camera;
};

SmallPhotograph smallPhotograph(const Image<Rgb8>& picture, const Camera& camera);

} // namespace scene
