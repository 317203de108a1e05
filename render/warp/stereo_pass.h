#pragma once
// Points and splats of two eyes in one pass: each sample is read once and warped to both z-buffers, instead of once in
// the command stream of each eye.

#include "render/device.h"
#include "render/pair_list.h"
#include "render/pipeline.h"
#include "render/target.h"
#include "render/warp/occlusion_pass.h"

#include <array>
#include <cstddef>
#include <span>
#include <string>

namespace render {

struct StereoPass {
    VkDescriptorSetLayout layout =
        VK_NULL_HANDLE;                   ///< 0 pairs, 1 pairs that have passed the test, 2 how many of each run
    std::array<ComputePipeline, 2> warps; ///< of points and of splats
    ComputePipeline test;
    std::uint32_t testSize = 1; ///< of its workgroup
};

/// What both eyes need for it, besides their targets.
struct StereoTarget {
    std::size_t mostPairs = 0;                 ///< that there is room for
    std::array<Buffer, kFramesInFlight> pairs; ///< PairDraw; mapped
    Buffer passed, passedRuns;                 ///< see shaders/shared/occlusion.h
    DescriptorPool pool;
    std::array<VkDescriptorSet, kFramesInFlight> sets{};
    VkDescriptorSet passedSet = VK_NULL_HANDLE; ///< with what has passed as its pairs
};

/// Why a device cannot draw so many eyes of this quality in one pass, as a sentence; empty if it can.
std::string whyNotInOnePass(const Device& device, const Quality& quality, int eyes);

/// mostPoints: of any tile.
StereoPass makeStereoPass(const Device& device, VkDescriptorSetLayout pageLayout, VkDescriptorSetLayout eyeLayout,
                          std::uint32_t mostPoints);

/// Throws scene::Failure if the device cannot see such a list at once.
StereoTarget makeStereoTarget(const Device& device, const StereoPass& pass, std::size_t mostPairs);

/// Draws the runs, batch after batch, into the z-buffers of both eyes, which must be clear, and are finished behind the
/// caller's next barrier. closesGaps: what is behind gaps of one pixel within a surface is left out, too.
void recordStereoWarp(VkCommandBuffer commands, const StereoPass& pass, const OcclusionPass& occlusion,
                      const GpuScene& scene, const std::array<VkDescriptorSet, kMaxEyes>& eyeSets,
                      const StereoTarget& target, std::size_t slot, std::span<const DrawRun> runs, int width,
                      int height, bool closesGaps);

} // namespace render
