#include "render/readback.h"

#include <algorithm>

namespace render {

EyeImage readBack(const EyeTarget& target, int width, int height) {
    EyeImage image{{width, height}, {width, height}, {width, height}};
    const auto colours = target.colours.as<const std::uint32_t>();
    const auto depths = target.depths.as<const float>();
    for (std::size_t i = 0; i < image.colour.size(); ++i) {
        const std::uint32_t c = colours[i];
        image.colour.pixels()[i] = {static_cast<std::uint8_t>(c), static_cast<std::uint8_t>(c >> 8),
                                    static_cast<std::uint8_t>(c >> 16)};
        image.pixelClass.pixels()[i] = static_cast<std::uint8_t>(c >> 24);
    }
    std::copy_n(depths.begin(), image.depthMetres.size(), image.depthMetres.pixels().begin());
    return image;
}

} // namespace render
