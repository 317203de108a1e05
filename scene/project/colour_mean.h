#pragma once
// What colour a pixel has from the points of a scan that it stands for.

#include "scene/depth_image.h"
#include "scene/scan.h"

#include <cmath>
#include <cstddef>
#include <cstdint>

#include <glm/vec3.hpp>

namespace scene {

/// The weighted mean of points' colours: of those whose colour is known if there are any, since the others' grey is
/// none; else of the others.
class ColourMean {
  public:
    void add(const Scan& scan, std::size_t point, double weight = 1) {
        const Rgb8 c = scan.colours[point];
        Sum& sum = scan.hasColourAt(point) ? known_ : grey_;
        sum.weight += weight;
        sum.colour += weight * glm::dvec3(c.r, c.g, c.b);
    }

    /// Mid-grey of nothing.
    Rgb8 colour() const {
        const Sum& sum = known_.weight > 0 ? known_ : grey_;
        if (!(sum.weight > 0)) return {128, 128, 128};
        const auto byte = [&](double channel) { return static_cast<std::uint8_t>(std::lround(channel / sum.weight)); };
        return {byte(sum.colour.x), byte(sum.colour.y), byte(sum.colour.z)};
    }

    /// kNoColour if of most of it the colour is not known: what knows it better may then say.
    std::uint8_t flags() const {
        return known_.weight > 0 && known_.weight >= grey_.weight ? std::uint8_t{0} : std::uint8_t{kNoColour};
    }

  private:
    struct Sum {
        double weight = 0;
        glm::dvec3 colour{0};
    };
    Sum known_, grey_;
};

} // namespace scene
