#include "scene/cube.h"

#include <cmath>

#include <glm/matrix.hpp>

namespace scene {

std::string withoutFace(const std::string& imageName) {
    std::string name = imageName;
    const std::size_t layer = name.find_last_not_of("0123456789");
    if (layer != std::string::npos && layer + 1 < name.size() && name[layer] == '-') name.resize(layer);
    for (const char* face : kFaceNames)
        if (const std::string suffix = std::string("-") + face; name.size() > suffix.size() && name.ends_with(suffix))
            return name.substr(0, name.size() - suffix.size());
    return imageName;
}

std::array<glm::dmat3, kFaceCount> facesFromCube(double frontAzimuthRadians) {
    const double c = std::cos(frontAzimuthRadians), s = std::sin(frontAzimuthRadians);
    const glm::dvec3 front(c, s, 0), right(s, -c, 0), up(0, 0, 1);
    const auto look = [](const glm::dvec3& x, const glm::dvec3& y, const glm::dvec3& z) {
        return glm::transpose(glm::dmat3(x, y, z));
    };
    return {look(right, -up, front),  look(front, -up, -right), look(-right, -up, -front),
            look(-front, -up, right), look(right, front, up),   look(right, -front, -up)};
}

} // namespace scene
