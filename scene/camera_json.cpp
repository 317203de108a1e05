#include "scene/camera_json.h"

namespace scene {

using nlohmann::json;

json rowMajor(const Pose& pose) {
    json numbers = json::array();
    const glm::dmat4 m = toMatrix(pose);
    for (int i = 0; i < 16; ++i)
        numbers.push_back(m[i % 4][i / 4]);
    return numbers;
}

json describeCamera(const std::string& name, const Camera& c, const Pose& worldFromCamera) {
    return {{"name", name}, {"width", c.width}, {"height", c.height}, {"fx", c.fx},
            {"fy", c.fy},   {"cx", c.cx},       {"cy", c.cy},         {"world_from_camera", rowMajor(worldFromCamera)}};
}

} // namespace scene
