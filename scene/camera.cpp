#include "scene/camera.h"

#include <cmath>

namespace scene {

glm::dmat4 cameraFromImage(const Camera& camera) {
    glm::dmat4 e(1.0);
    e[0][0] = 1.0 / camera.fx;
    e[1][1] = 1.0 / camera.fy;
    e[2][0] = -camera.cx / camera.fx;
    e[2][1] = -camera.cy / camera.fy;
    return e;
}

glm::dmat4 imageFromCamera(const Camera& camera) {
    glm::dmat4 inverseOfE(1.0);
    inverseOfE[0][0] = camera.fx;
    inverseOfE[1][1] = camera.fy;
    inverseOfE[2][0] = camera.cx;
    inverseOfE[2][1] = camera.cy;
    return inverseOfE;
}

Camera resized(const Camera& c, int width, int height) {
    const double sx = static_cast<double>(width) / c.width, sy = static_cast<double>(height) / c.height;
    return {width, height, c.fx * sx, c.fy * sy, c.cx * sx, c.cy * sy};
}

bool isUsable(const Camera& camera) {
    return camera.width > 0 && camera.height > 0 && std::isfinite(camera.fx) && std::isfinite(camera.fy) &&
           std::isfinite(camera.cx) && std::isfinite(camera.cy) && camera.fx > 0 && camera.fy > 0;
}

} // namespace scene
