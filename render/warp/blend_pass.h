#pragma once
// The second pass of the blended warp: adds samples at the front surface, and puts their mean into the picture.

#include "render/blend_list.h"
#include "render/pipeline.h"
#include "render/target.h"

#include <array>

namespace render {

class Device;
class GpuScene;

struct BlendPass {
    VkDescriptorSetLayout layout = VK_NULL_HANDLE; ///< 0 draws, 1 sums
    ComputePipeline add, resolve;
};

/// What an eye needs for it, besides its target.
struct BlendTarget {
    std::size_t pixels = 0;                    ///< of the largest image there is room for
    std::size_t mostDraws = 0;                 ///< that there is room for
    Buffer sums;                               ///< two 64-bit words a pixel, see shaders/shared/blend.h
    std::array<Buffer, kFramesInFlight> draws; ///< BlendDraw; mapped
    DescriptorPool pool;
    std::array<VkDescriptorSet, kFramesInFlight> sets{};
};

/// mostPoints: of any tile.
BlendPass makeBlendPass(const Device& device, VkDescriptorSetLayout pageLayout, VkDescriptorSetLayout eyeLayout,
                        std::uint32_t mostPoints);

/// Throws scene::Failure if the device cannot see such an image or list at once.
BlendTarget makeBlendTarget(const Device& device, const BlendPass& pass, std::size_t pixels, std::size_t maxDraws);

/// Clears the sums and adds the list's samples; the z-buffer must be finished.
void recordBlend(VkCommandBuffer commands, const BlendPass& pass, const GpuScene& scene, VkDescriptorSet eyeSet,
                 const BlendTarget& target, std::size_t slot, std::span<const DrawRun> runs, int width, int height);

/// Over the resolved picture of eyeSet.
void recordBlendResolve(VkCommandBuffer commands, const BlendPass& pass, VkDescriptorSet eyeSet,
                        const BlendTarget& target, std::size_t slot, int width, int height);

} // namespace render
