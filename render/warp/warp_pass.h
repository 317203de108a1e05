#pragma once
// A warp: the shader that moves samples to an eye's z-buffer. Every warp draws the same list of tiles; a new
// one is a shader, a file like points.cpp, and a row in makeWarpPass.

#include "render/draw_list.h"
#include "render/pipeline.h"
#include "render/quality.h"

#include <array>
#include <span>

namespace render {

class Device;
class GpuScene;
struct EyeTarget;

struct WarpPass {
    ComputePipeline any, plain; ///< plain: for runs of plain tiles
    ComputePipeline small;      ///< for runs of small tiles, where those have one of their own
    ComputePipeline wide;       ///< for runs of wide tiles, where those need one of their own: few frames have any
    /// Draws parts of large pieces that the others have put on a list (shaders/shared/large_part.h); none if they do
    /// not.
    ComputePipeline listed;
    const ComputePipeline& of(const DrawRun& run) const {
        if (run.reach == Reach::wide && wide) return wide;
        if (run.reach == Reach::small && small) return small;
        return run.reach == Reach::plain ? plain : any;
    }
    bool mayList(const DrawRun& run) const {
        if (!listed) return false;
        if (wide) return run.reach == Reach::wide;
        return run.reach >= Reach::any || run.warp != Warp::mesh;
    }
};
using WarpPasses = std::array<WarpPass, 4>; ///< by Warp

/// Compiles all of them that there are.
void compile(const WarpPass& pass);

WarpPass makeWarpPass(const Device& device, Warp warp, VkDescriptorSetLayout pageLayout,
                      VkDescriptorSetLayout eyeLayout);

/// Invocations that draw a tile together: on a processor so many that none has more than mostInTurn of a tile's
/// mostPoints (lavapipe lets none go through loops for too long: shaders/shared/large_part.h).
std::uint32_t togetherFor(const Device& device, std::uint32_t onCards, std::uint32_t mostPoints,
                          std::uint32_t mostInTurn);

/// Dispatches one workgroup for each tile of the runs, with the page at set 0 of the bound pipeline and WarpConstants
/// pushed.
void recordRuns(VkCommandBuffer commands, VkPipelineLayout layout, const GpuScene& scene, std::span<const DrawRun> runs,
                int width, int height);

/// Draws the runs, each by its own warp, into the z-buffer of eyeSet: one workgroup per tile.
void recordWarp(VkCommandBuffer commands, const WarpPasses& passes, const GpuScene& scene, VkDescriptorSet eyeSet,
                std::span<const DrawRun> runs, int width, int height);

/// What the runs' large pieces have left to other workgroups; after all of them. target: where they have listed it.
void recordListed(VkCommandBuffer commands, const WarpPasses& passes, const GpuScene& scene, VkDescriptorSet eyeSet,
                  const EyeTarget& target, std::span<const DrawRun> runs, int width, int height);

/// The same for what has passed a test (render/warp/occlusion_pass.h): how many of run i, the device knows.
void recordPassed(VkCommandBuffer commands, const WarpPasses& passes, const GpuScene& scene, VkDescriptorSet eyeSet,
                  const EyeTarget& target, std::span<const DrawRun> runs, int width, int height);

} // namespace render
