#pragma once
// Where no image ever looked, a picture says so: pixels of class unseen (shaders/shared/unseen.h).

#include "render/pipeline.h"
#include "render/post/coverage_texels.h"
#include "render/quality.h"
#include "render/resources.h"
#include "render/shaders/shared/unseen.h"
#include "scene/coverage.h"
#include "scene/open_grid.h"
#include "scene/view.h"

#include <memory>

namespace render {

/// What was observed of a scene, on the device.
class GpuCoverage {
  public:
    /// The coverage must outlive it, if it is only lent. Throws scene::Failure if the device cannot hold or see it.
    GpuCoverage(const Device& device, const scene::Coverage& coverage);
    GpuCoverage(const Device& device, scene::Coverage&& coverage);

    VkDescriptorSetLayout layout() const { return layout_; }
    VkDescriptorSet set() const { return set_; }
    const glm::dvec3& cornerInWorld() const { return cornerInWorld_; }
    double edgeMetres() const { return edgeMetres_; }
    int levels() const { return levels_; } ///< of its tree (scene/coverage_levels.h)
    double finestCellMetres() const { return finestCellMetres_; }
    const UnseenGrid& grid() const { return grid_; } ///< of voxels
    std::uint32_t brickLevels() const { return brickLevels_; }
    std::size_t bytes() const { return words_.size() + bricks_.size() + bases_.size(); }
    /// Null if it is its own.
    const scene::Coverage* lent() const { return own_ ? nullptr : &openGrid_.coverage(); }
    const scene::OpenGrid& openGrid() const { return openGrid_; } ///< on the processor: what it may hide

  private:
    GpuCoverage(const Device& device, std::unique_ptr<const scene::Coverage> own, const scene::Coverage* lent);

    std::unique_ptr<const scene::Coverage> own_; ///< null if it is lent
    glm::dvec3 cornerInWorld_{0};
    double edgeMetres_ = 0;
    int levels_ = 0;
    double finestCellMetres_ = 0;
    scene::OpenGrid openGrid_;
    UnseenGrid grid_{};
    std::uint32_t brickLevels_ = 0;
    Buffer words_, bricks_, bases_;
    BufferView wordsView_, bricksView_, basesView_;
    VkDescriptorSetLayout layout_ = VK_NULL_HANDLE;
    DescriptorPool pool_;
    VkDescriptorSet set_ = VK_NULL_HANDLE;
};

ComputePipeline makeUnseenPipeline(const Device& device, const GpuCoverage& coverage, VkDescriptorSetLayout eyeLayout);

UnseenConstants unseenConstants(const glm::dvec3& cornerInWorld, double edgeMetres, const UnseenGrid& grid,
                                const scene::View& eye, const Quality& quality);

/// After the eye was resolved, with reads and writes of its picture behind a barrier before and after.
void recordUnseen(VkCommandBuffer commands, const ComputePipeline& pipeline, const GpuCoverage& coverage,
                  VkDescriptorSet eyeSet, const scene::View& eye, const Quality& quality);

} // namespace render
