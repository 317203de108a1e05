#include "scene/import/mtl_opacity.h"

#include <cmath>
#include <fstream>
#include <sstream>

namespace scene {

std::map<std::string, double> readMtlOpacities(const std::filesystem::path& path) {
    std::map<std::string, double> opacities;
    std::ifstream file(path);
    std::string line, material;
    while (std::getline(file, line)) {
        std::istringstream words(line);
        std::string keyword;
        words >> keyword;
        if (keyword == "newmtl") words >> material;
        if (keyword != "Kd") continue;
        double red = 0, green = 0, blue = 0, opacity = 0;
        if (words >> red >> green >> blue >> opacity && std::isfinite(opacity)) opacities[material] = opacity;
    }
    return opacities;
}

} // namespace scene
