#include "scene/align/edge_score.h"

#include <cmath>
#include <cstring>

namespace scene {

namespace {

/// Four numbers that are reckoned with at once; glm's own operators are not compiled so.
using Four [[gnu::vector_size(16)]] = float;

Four fourOf(const glm::vec4& pixel) {
    Four four;
    std::memcpy(&four, &pixel, sizeof four);
    return four;
}

} // namespace

double PartSums::scoreWithout(int part) const {
    double gain = 0, weight = 0;
    for (int i = 0; i < kParts; ++i) {
        if (i == part) continue;
        gain += gains[static_cast<std::size_t>(i)], weight += weights[static_cast<std::size_t>(i)];
    }
    return weight > 0 ? gain / weight : 0;
}

EdgeScore::Sum EdgeScore::sumAt(const glm::dmat3& givenFromTurned, std::span<const EdgeRay> rays, std::size_t first,
                                std::size_t end) const {
    const glm::mat3 turn(givenFromTurned);
    const auto fx = static_cast<float>(camera_.fx), fy = static_cast<float>(camera_.fy);
    const auto cx = static_cast<float>(camera_.cx), cy = static_cast<float>(camera_.cy);
    // Edges turn with the camera: about its axis by the angle between the x axes.
    const float roll = std::atan2(turn[0][1] - turn[1][0], turn[0][0] + turn[1][1]);
    const float rollCosine = std::cos(2 * roll), rollSine = std::sin(2 * roll);
    Sum sum;
    for (const EdgeRay& ray : rays) {
        sum.weight += ray.strength;
        const glm::vec3 p = turn * ray.direction;
        if (!(p.z > 0.1f)) continue;
        const float u = fx * p.x / p.z + cx, v = fy * p.y / p.z + cy;
        const float cosine = ray.cosine * rollCosine - ray.sine * rollSine,
                    sine = ray.sine * rollCosine + ray.cosine * rollSine;
        float gain = 0;
        for (std::size_t l = first; l < end; ++l) {
            const Image<glm::vec4>& edges = levels_[l].edges;
            const float per = 1.0f / static_cast<float>(levels_[l].pixelsPerPixel);
            const float x = u * per - 0.5f, y = v * per - 0.5f;
            if (!(x >= 0 && y >= 0)) continue;
            const int i = static_cast<int>(x), j = static_cast<int>(y);
            if (i + 1 >= edges.width() || j + 1 >= edges.height()) continue;
            const float a = x - static_cast<float>(i), b = y - static_cast<float>(j);
            const Four here = (1 - b) * ((1 - a) * fourOf(edges(i, j)) + a * fourOf(edges(i + 1, j))) +
                              b * ((1 - a) * fourOf(edges(i, j + 1)) + a * fourOf(edges(i + 1, j + 1)));
            gain += here[0] + cosine * here[1] + sine * here[2];
        }
        sum.gain += double{ray.strength} * gain;
    }
    return sum;
}

double EdgeScore::at(const glm::dmat3& givenFromTurned, std::span<const EdgeRay> rays, std::size_t first,
                     std::size_t end) const {
    const Sum sum = sumAt(givenFromTurned, rays, first, end);
    return sum.weight > 0 ? sum.gain / sum.weight : 0;
}

PartSums EdgeScore::partsAt(const glm::dmat3& givenFromTurned, const std::array<std::vector<EdgeRay>, kParts>& rays,
                            std::size_t first, std::size_t end) const {
    PartSums sums;
    for (std::size_t part = 0; part < rays.size(); ++part) {
        const Sum sum = sumAt(givenFromTurned, rays[part], first, end);
        sums.gains[part] = sum.gain, sums.weights[part] = sum.weight;
    }
    return sums;
}

} // namespace scene
