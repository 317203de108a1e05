#pragma once
// compareWith for many samples of one image against one other, by vectors: what the stages of a build spend much of
// their time on.

#include "scene/reprojection.h"

#include <cassert>
#include <cstdint>
#include <vector>

namespace scene {

/// Samples are added, compared, and then asked about by the order in which they were added. What is said of a sample is
/// what sightingOf and compareWith say of it, to the bit, on every processor.
class SampleComparison {
  public:
    /// most: samples that are added before the next clear().
    explicit SampleComparison(int most);

    void clear() { count_ = 0; }
    int count() const { return count_; }
    int most() const { return most_; }
    /// A place in the source's image, pixels, and the disparity there (1/m).
    void add(float x, float y, float disparity) {
        assert(count_ < most_);
        const auto i = static_cast<std::size_t>(count_++);
        x_[i] = x, y_[i] = y, disparity_[i] = disparity;
    }

    float x(int i) const { return x_[at(i)]; }
    float y(int i) const { return y_[at(i)]; }
    float disparity(int i) const { return disparity_[at(i)]; }

    /// May be called again with another target. into: from the source's image to the target's. The target is to stay as
    /// long as it is asked about.
    void compare(const DepthImage& target, const Reprojection& into, const ComparisonOptions& options);

    /// Before the target, and within its image.
    bool isSeen(int i) const { return code(i) != Code::unseen; }
    /// Where; of samples that are seen. w is not kept.
    Sighting sighting(int i) const { return {u_[at(i)], v_[at(i)], seenDisparity_[at(i)], 1.f}; }

    Relation relation(int i) const {
        switch (code(i)) {
        case Code::unseen:
            return Relation::outside;
        case Code::agrees:
            return Relation::agrees;
        case Code::behind:
            return Relation::behind;
        case Code::askWhole:
            break;
        }
        return whole(i).relation;
    }
    /// Everything; costs more than the relation alone.
    Comparison comparison(int i) const {
        switch (code(i)) {
        case Code::unseen:
            return {};
        case Code::agrees:
            return {Relation::agrees, surface_[at(i)], true};
        case Code::behind:
            return {Relation::behind, surface_[at(i)], true};
        case Code::askWhole:
            break;
        }
        return whole(i);
    }

    /// What vectors find out. Silhouettes, rims and what stands before the target's surface are asked one by one.
    enum class Code : std::int32_t { unseen, agrees, behind, askWhole };

  private:
    static std::size_t at(int i) { return static_cast<std::size_t>(i); }
    Code code(int i) const { return static_cast<Code>(codes_[at(i)]); }
    Comparison whole(int i) const;

    int most_, count_ = 0;
    std::vector<float> x_, y_, disparity_;
    std::vector<float> u_, v_, seenDisparity_, surface_;
    std::vector<std::int32_t> codes_; ///< of Code
    const DepthImage* target_ = nullptr;
    ComparisonOptions options_;
};

} // namespace scene
