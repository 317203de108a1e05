#pragma once
// How much the colours of a small patch differ from those of a photograph, by vectors; for refine/silhouettes.cpp.

#include "scene/image.h"

#include <cstddef>
#include <vector>

#include <glm/vec3.hpp>

namespace scene {

/// Samples about a pixel, value by value: offsets from it in pixels, weights, colours of 0 to 255.
class PatchSamples {
  public:
    void clear();
    void add(float dx, float dy, float weight, const glm::vec3& colour);
    /// To be called after the last sample.
    void pad();

    float weightOfAll() const { return weightOfAll_; }
    std::size_t padded() const { return dx.size(); } ///< a multiple of kMostLanes; those beyond the samples weigh 0

    static constexpr std::size_t kMostLanes = 16;
    std::vector<float> dx, dy, weight, red, green, blue;

  private:
    float weightOfAll_ = 0;
};

/// Where the patch's samples are seen: (u, v) + dx (uByX, vByX) + dy (uByY, vByY), in the photograph's pixels.
struct PatchPlaces {
    float u, v, uByX, uByY, vByX, vByY;
};

/// Sum over the samples of weight times the difference to the photograph's bilinear colour there: the mean over the
/// three colours, at most `most`. All places are a pixel within the photograph.
float sumOfDifferences(const Image<Rgb8>& photograph, const PatchSamples& patch, const PatchPlaces& places, float most);

} // namespace scene
