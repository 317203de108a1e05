#include "render/warp/warp_pass.h"

#include "render/command_streams.h"
#include "render/device.h"
#include "render/gpu_scene.h"
#include "render/shaders/shared/large_part.h"
#include "render/shaders/shared/occlusion.h"
#include "render/target.h"
#include "spirv/warp_facets.comp.h"
#include "spirv/warp_mesh.comp.h"
#include "spirv/warp_points.comp.h"
#include "spirv/warp_splats.comp.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace render {

namespace {

struct WarpRow {
    std::span<const std::uint32_t> code;
    std::uint32_t workgroupSize;
    std::uint32_t largePixels = 0; ///< pieces of more are drawn by a subgroup; 0: none are
};

/// So many workgroups at most take parts from the list of large pieces. On a processor so many that none takes too
/// many steps, however long the list.
constexpr std::uint32_t kListedTogether = 1024, kListedOnProcessor = 16384;

/// So many times a workgroup on a processor goes through loops over the pixels of a wide tile's large pieces, before it
/// lists what is left: a quarter of what lavapipe lets it, since small pieces and the list take some, too.
constexpr std::uint32_t kMostStepsOnProcessor = 16000;

/// Points wider than kWidestShared are drawn by so many invocations on a processor: each has fewer of them then.
constexpr std::uint32_t kWidePointsTogether = 512;

/// Of workgroups a card does well with large ones, where tiles have that many squares; they have fewer facets
/// (docs/performance.md).
WarpRow rowOf(const Device& device, Warp warp) {
    switch (warp) {
    case Warp::adaptive:
        return {kWarpFacetsCode, device.workgroupSize(128), 24};
    case Warp::mesh:
        return {kWarpMeshCode, device.workgroupSize(256), 256};
    case Warp::splats:
        return {kWarpSplatsCode, device.workgroupSize(128)};
    default:
        return {kWarpPointsCode, device.workgroupSize(128)};
    }
}

} // namespace

namespace {

/// Pipelines of one warp's shader.
class Maker {
  public:
    Maker(const Device& device, Warp warp, VkDescriptorSetLayout pageLayout, VkDescriptorSetLayout eyeLayout)
        : device_(device), row_(rowOf(device, warp)), layouts_{pageLayout, eyeLayout} {}

    bool hasLarge() const { return row_.largePixels > 0; }
    ComputePipeline make(std::uint32_t drawn, std::uint32_t largePieces) const {
        constexpr std::uint32_t kSharingLanes = 8; // as in shaders/read_draw.glsl
        const bool isProcessor = device_.isProcessor();
        const bool sharesReading = isProcessor && row_.workgroupSize == kSharingLanes;
        return makeComputePipeline(device_, row_.code, layouts_, sizeof(WarpConstants),
                                   std::array{row_.workgroupSize, std::uint32_t{sharesReading}, drawn, largePieces,
                                              row_.largePixels, isProcessor ? kMostStepsOnProcessor : 0u,
                                              isProcessor ? kListedOnProcessor : kListedTogether});
    }
    ComputePipeline makeOfMany(std::uint32_t together) const {
        return makeComputePipeline(device_, row_.code, layouts_, sizeof(WarpConstants),
                                   std::array{together, 0u, kDrawsAll});
    }

  private:
    const Device& device_;
    WarpRow row_;
    std::array<VkDescriptorSetLayout, 2> layouts_;
};

} // namespace

WarpPass makeWarpPass(const Device& device, Warp warp, VkDescriptorSetLayout pageLayout,
                      VkDescriptorSetLayout eyeLayout) {
    const Maker maker(device, warp, pageLayout, eyeLayout);
    // On a processor there is no need to list but in wide tiles, and what is not needed costs.
    const bool lists = maker.hasLarge() && !device.isProcessor();
    const std::uint32_t largePieces = lists ? kListsLarge : kDrawsLarge;
    WarpPass pass;
    pass.any = maker.make(kDrawsAll, largePieces);
    pass.plain = maker.make(kDrawsPlain, largePieces);
    if (warp == Warp::points || warp == Warp::mesh) pass.small = maker.make(kDrawsSmall, largePieces);
    if (device.isProcessor())
        pass.wide = maker.hasLarge() ? maker.make(kDrawsAll, kListsLarge) : maker.makeOfMany(kWidePointsTogether);
    if (maker.hasLarge()) pass.listed = maker.make(kDrawsAll, kDrawsListed);
    return pass;
}

void compile(const WarpPass& pass) {
    for (const ComputePipeline& pipeline : {pass.any, pass.plain, pass.small, pass.wide, pass.listed})
        if (pipeline) pipeline.handle();
}

std::uint32_t togetherFor(const Device& device, std::uint32_t onCards, std::uint32_t mostPoints,
                          std::uint32_t mostInTurn) {
    const std::uint32_t size = device.workgroupSize(onCards);
    if (!device.isProcessor()) return size;
    const std::uint32_t ofOneVector = size * mostInTurn;
    return size * std::max((mostPoints + ofOneVector - 1) / ofOneVector, 1u);
}

void bindPage(VkCommandBuffer commands, VkPipelineLayout layout, const GpuScene& scene, const DrawRun& run) {
    const VkDescriptorSet page = scene.pageSet(run.page);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &page, 0, nullptr);
}

void push(VkCommandBuffer commands, VkPipelineLayout layout, const WarpConstants& constants) {
    vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, &constants);
}

void recordRun(VkCommandBuffer commands, VkPipelineLayout layout, const GpuScene& scene, const DrawRun& run, int width,
               int height) {
    bindPage(commands, layout, scene, run);
    for (std::uint32_t done = 0; done < run.count; done += kMaxWorkgroups) {
        push(commands, layout, {run.first + done, width, height, 0});
        vkCmdDispatch(commands, std::min(run.count - done, kMaxWorkgroups), 1, 1);
    }
}

void recordRuns(VkCommandBuffer commands, VkPipelineLayout layout, const GpuScene& scene, std::span<const DrawRun> runs,
                int width, int height) {
    for (const DrawRun& run : runs)
        recordRun(commands, layout, scene, run, width, height);
}

namespace {

/// Binds for each run the warp that draws it, and the eye's set, and lets `recordOne` do the rest.
template <class RecordOne>
void recordEach(VkCommandBuffer commands, const WarpPasses& passes, VkDescriptorSet eyeSet,
                std::span<const DrawRun> runs, RecordOne&& recordOne) {
    ComputePipeline bound;
    for (std::size_t i = 0; i < runs.size(); ++i) {
        const ComputePipeline& of = passes[static_cast<std::size_t>(runs[i].warp)].of(runs[i]);
        if (of != bound) {
            bind(commands, of);
            vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, of.layout(), 1, 1, &eyeSet, 0, nullptr);
            bound = of;
        }
        recordOne(of.layout(), i);
    }
}

} // namespace

void recordWarp(VkCommandBuffer commands, const WarpPasses& passes, const GpuScene& scene, VkDescriptorSet eyeSet,
                std::span<const DrawRun> runs, int width, int height) {
    recordEach(commands, passes, eyeSet, runs, [&](VkPipelineLayout layout, std::size_t i) {
        recordRun(commands, layout, scene, runs[i], width, height);
    });
}

void recordPassed(VkCommandBuffer commands, const WarpPasses& passes, const GpuScene& scene, VkDescriptorSet eyeSet,
                  const EyeTarget& target, std::span<const DrawRun> runs, int width, int height) {
    recordEach(commands, passes, eyeSet, runs, [&](VkPipelineLayout layout, std::size_t i) {
        assert(runs[i].count <= kMaxWorkgroups);
        bindPage(commands, layout, scene, runs[i]);
        push(commands, layout, {runs[i].first | kAmongPassed, width, height, 0});
        vkCmdDispatchIndirect(commands, target.passedRuns.handle(), i * sizeof(PassedRun));
    });
}

void recordListed(VkCommandBuffer commands, const WarpPasses& passes, const GpuScene& scene, VkDescriptorSet eyeSet,
                  const EyeTarget& target, std::span<const DrawRun> runs, int width, int height) {
    constexpr VkAccessFlags kBoth = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT;
    constexpr VkPipelineStageFlags kIndirect = VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT;
    constexpr Barrier kAfterListing{kCompute | kIndirect, kBoth, kTransfer,
                                    VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT};
    constexpr Barrier kBeforeDrawing{kCompute | kTransfer, kBoth | VK_ACCESS_TRANSFER_WRITE_BIT, kCompute | kIndirect,
                                     kBoth | VK_ACCESS_INDIRECT_COMMAND_READ_BIT};
    bool isFirst = true;
    for (const DrawRun& run : runs) {
        const WarpPass& pass = passes[static_cast<std::size_t>(run.warp)];
        if (!pass.mayList(run)) continue;
        const ComputePipeline& listed = pass.listed;
        if (isFirst) {
            // Copied, since what draws the list might write to it, for all that anybody knows who orders the
            // dispatches.
            record(commands, kAfterListing);
            const VkBufferCopy groups{kLargePartsGroups * sizeof(std::uint32_t), 0, sizeof(VkDispatchIndirectCommand)};
            vkCmdCopyBuffer(commands, target.holes.handle(), target.listedGroups.handle(), 1, &groups);
            record(commands, kBeforeDrawing);
            isFirst = false;
        }
        bind(commands, listed);
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, listed.layout(), 1, 1, &eyeSet, 0, nullptr);
        bindPage(commands, listed.layout(), scene, run);
        push(commands, listed.layout(), {run.first, width, height, run.count});
        vkCmdDispatchIndirect(commands, target.listedGroups.handle(), 0);
    }
}

} // namespace render
