#include "tests/app/written_room.h"

#include "tests/scene/scratch_folder.h"

#include <string>

namespace app {

void writeRoom(const std::filesystem::path& path, const glm::dvec3& middle) {
    std::string text;
    int count = 0;
    const auto square = [&](glm::vec3 a, glm::vec3 u, glm::vec3 v) {
        for (const glm::vec3& corner : {a, a + u, a + u + v, a + v}) {
            const glm::dvec3 p = glm::dvec3(corner) + middle;
            text += "v " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
        }
        text += "f " + std::to_string(count + 1) + " " + std::to_string(count + 2) + " " + std::to_string(count + 3) +
                " " + std::to_string(count + 4) + "\n";
        count += 4;
    };
    square({-3, 0, -4}, {0, 0, 8}, {6, 0, 0});
    square({-3, 0, -4}, {6, 0, 0}, {0, 3, 0}), square({3, 0, 4}, {-6, 0, 0}, {0, 3, 0});
    square({-3, 0, 4}, {0, 0, -8}, {0, 3, 0}), square({3, 0, -4}, {0, 0, 8}, {0, 3, 0});
    square({0.7f, 0, 1.3f}, {0.6f, 0, 0}, {0, 2.5f, 0}), square({1.3f, 0, 0.7f}, {-0.6f, 0, 0}, {0, 2.5f, 0});
    square({0.7f, 0, 0.7f}, {0, 0, 0.6f}, {0, 2.5f, 0}), square({1.3f, 0, 1.3f}, {0, 0, -0.6f}, {0, 2.5f, 0});
    square({0.7f, 2.5f, 1.3f}, {0.6f, 0, 0}, {0, 0, -0.6f});
    scene::writeFile(path, text);
}

} // namespace app
