#pragma once
// The yardstick of the warps: every sample a 16-byte record, one transform, one atomic, nothing culled.

#include "render/command_streams.h"
#include "render/pipeline.h"
#include "render/resources.h"
#include "render/timing.h"
#include "scene/tile.h"
#include "scene/view.h"

#include <span>

namespace render {

class BareScatter {
  public:
    /// The points of the blocks, as seen by an image of that size.
    BareScatter(const Device& device, std::span<const scene::TileBlock> blocks, int width, int height);

    /// Clears, scatters, waits; milliseconds of the scatter alone on the device.
    double run(const scene::View& view);
    std::size_t samples() const { return samples_; }

  private:
    const Device& device_;
    int width_, height_;
    std::size_t samples_ = 0;
    Buffer records_, zBuffer_;
    VkDescriptorSetLayout layout_ = VK_NULL_HANDLE;
    DescriptorPool pool_;
    VkDescriptorSet set_ = VK_NULL_HANDLE;
    ComputePipeline pipeline_;
    StepTimer timer_;
    CommandStreams streams_;
};

} // namespace render
