#include "scene/capture/texture_pyramid.h"

#include "scene/capture/texels.h"
#include "scene/srgb.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

namespace scene {

namespace {

constexpr float kMostLooks = 8; ///< along the longer side of a footprint

glm::vec3 linearColour(const Rgb8& c) {
    return {linearFromSrgb(c.r), linearFromSrgb(c.g), linearFromSrgb(c.b)};
}

/// Colours times alpha, and alpha: what is cut out has no say in what is left.
using Weighted = Image<glm::vec4>;

Weighted weightedOf(const Image<Rgba8>& picture, bool isCutOut) {
    Weighted weighted(picture.width(), picture.height());
    for (std::size_t i = 0; i < picture.size(); ++i) {
        const Rgba8& p = picture.pixels()[i];
        const float alpha = isCutOut ? static_cast<float>(p.a) / 255 : 1.0f;
        weighted.pixels()[i] = {linearColour({p.r, p.g, p.b}) * alpha, alpha};
    }
    return weighted;
}

/// Each texel is the mean of what it covers of the finer level, in shares where sizes are odd.
Weighted halved(const Weighted& fine) {
    const int width = std::max(1, fine.width() / 2), height = std::max(1, fine.height() / 2);
    Weighted coarse(width, height, glm::vec4(0));
    const double stepX = static_cast<double>(fine.width()) / width, stepY = static_cast<double>(fine.height()) / height;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double x0 = x * stepX, x1 = x0 + stepX, y0 = y * stepY, y1 = y0 + stepY;
            glm::vec4 sum(0);
            for (int j = static_cast<int>(y0); j < std::min(fine.height(), static_cast<int>(std::ceil(y1))); ++j)
                for (int i = static_cast<int>(x0); i < std::min(fine.width(), static_cast<int>(std::ceil(x1))); ++i) {
                    const double share = (std::min(x1, i + 1.0) - std::max(x0, static_cast<double>(i))) *
                                         (std::min(y1, j + 1.0) - std::max(y0, static_cast<double>(j)));
                    sum += fine(i, j) * static_cast<float>(share);
                }
            coarse(x, y) = sum / static_cast<float>(stepX * stepY);
        }
    return coarse;
}

/// Texels that are wholly cut out get the colour of the coarser level: what is beside them may look at them.
Image<Rgb8> finished(const Weighted& level, const Image<Rgb8>* coarser) {
    Image<Rgb8> colours(level.width(), level.height());
    for (int y = 0; y < level.height(); ++y)
        for (int x = 0; x < level.width(); ++x) {
            const glm::vec4& w = level(x, y);
            if (w.w > 0)
                colours(x, y) = encoded(glm::vec3(w) / w.w);
            else if (coarser != nullptr)
                colours(x, y) =
                    (*coarser)(std::min(x / 2, coarser->width() - 1), std::min(y / 2, coarser->height() - 1));
        }
    return colours;
}

glm::vec3 bilinear(const Image<Rgb8>& level, const glm::vec2& place) {
    return blend(texelsAt(place, level.width(), level.height()),
                 [&](int x, int y) { return linearColour(level(x, y)); });
}

} // namespace

TexturePyramid::TexturePyramid(const Image<Rgba8>& picture, bool isCutOut) {
    std::vector<Weighted> weighted{weightedOf(picture, isCutOut)};
    while (weighted.back().size() > 1)
        weighted.push_back(halved(weighted.back()));
    levels_.resize(weighted.size());
    for (std::size_t i = weighted.size(); i-- > 0;)
        levels_[i] = finished(weighted[i], i + 1 < levels_.size() ? &levels_[i + 1] : nullptr);
    mean_ = linearColour(levels_.back()(0, 0));
}

glm::vec3 TexturePyramid::colourAt(const glm::vec2& place, const TextureFootprint& footprint) const {
    const glm::vec2 size(levels_.front().width(), levels_.front().height());
    const float across = glm::length(footprint.across * size), down = glm::length(footprint.down * size);
    const glm::vec2 along = across > down ? footprint.across : footprint.down;
    const float longer = std::max(across, down), shorter = std::max(std::min(across, down), longer / kMostLooks);
    const float highest = static_cast<float>(levels_.size() - 1);
    const float level = shorter > 1 ? std::min(std::log2(shorter), highest) : 0;
    const int looks = longer > 1 ? static_cast<int>(std::ceil(longer / std::max(shorter, 1.0f))) : 1;
    const auto fine = static_cast<std::size_t>(level), coarse = std::min(fine + 1, levels_.size() - 1);
    glm::vec3 sum(0);
    for (int i = 0; i < looks; ++i) {
        const glm::vec2 at = place + along * ((static_cast<float>(i) + 0.5f) / static_cast<float>(looks) - 0.5f);
        const glm::vec3 colour = bilinear(levels_[fine], at);
        sum +=
            fine == coarse ? colour : glm::mix(colour, bilinear(levels_[coarse], at), level - static_cast<float>(fine));
    }
    return sum / static_cast<float>(looks);
}

} // namespace scene
