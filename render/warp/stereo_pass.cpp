#include "render/warp/stereo_pass.h"

#include "render/gpu_scene.h"
#include "spirv/pair_occlusion.comp.h"
#include "spirv/warp_eyes.comp.h"

#include <algorithm>

namespace render {

namespace {

constexpr std::array kStereoBindings{Binding::storage, Binding::storage, Binding::storage};

/// Buffers of two eyes and of the pairs: a shader must be able to see them all at once.
constexpr std::uint32_t kStorageBuffers = 2 * kEyeStorageBuffers + kStereoBindings.size();
constexpr std::uint32_t kSets = 4;

void use(VkCommandBuffer commands, const ComputePipeline& pipeline, std::span<const VkDescriptorSet> sets) {
    bind(commands, pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.layout(), 0,
                            static_cast<std::uint32_t>(sets.size()), sets.data(), 0, nullptr);
}

/// With the page of a run, what draws it.
const ComputePipeline& useForRun(VkCommandBuffer commands, const StereoPass& pass, const GpuScene& scene,
                                 const DrawRun& run, std::span<const VkDescriptorSet> eyeSets, VkDescriptorSet pairs) {
    const ComputePipeline& pipeline = pass.warps[run.warp == Warp::splats ? 1 : 0];
    use(commands, pipeline, std::array{scene.pageSet(run.page), eyeSets[0], eyeSets[1], pairs});
    return pipeline;
}

void push(VkCommandBuffer commands, const ComputePipeline& pipeline, const auto& constants) {
    vkCmdPushConstants(commands, pipeline.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, &constants);
}

} // namespace

std::string whyNotInOnePass(const Device& device, const Quality& quality, int eyes) {
    if (eyes != kMaxEyes) return "one eye is drawn: there is nothing to put into one pass";
    if (quality.warp != Warp::points && quality.warp != Warp::splats)
        return "eyes are drawn one by one: only points and splats can be drawn in one pass";
    if (device.limits().maxPerStageDescriptorStorageBuffers < kStorageBuffers ||
        device.limits().maxBoundDescriptorSets < kSets)
        return "eyes are drawn one by one: " + device.name() + " cannot see the buffers of both at once";
    return {};
}

StereoPass makeStereoPass(const Device& device, VkDescriptorSetLayout pageLayout, VkDescriptorSetLayout eyeLayout,
                          std::uint32_t mostPoints) {
    // As for one eye (warp_pass.cpp), but that each invocation has the pixels of both: circles of 9 across at most.
    constexpr std::uint32_t kMostInTurn = 300;
    const std::uint32_t size = togetherFor(device, 128, mostPoints, kMostInTurn);
    StereoPass pass;
    pass.layout = makeSetLayout(device, kStereoBindings);
    const std::array<VkDescriptorSetLayout, kSets> sets{pageLayout, eyeLayout, eyeLayout, pass.layout};
    for (std::uint32_t isSplats = 0; isSplats < pass.warps.size(); ++isSplats)
        pass.warps[isSplats] =
            makeComputePipeline(device, kWarpEyesCode, sets, sizeof(WarpConstants), std::array{size, isSplats});
    pass.testSize = device.workgroupSize(64);
    pass.test = makeComputePipeline(device, kPairOcclusionCode,
                                    std::array<VkDescriptorSetLayout, 3>{eyeLayout, eyeLayout, pass.layout},
                                    sizeof(PairTestConstants), std::array{pass.testSize});
    return pass;
}

StereoTarget makeStereoTarget(const Device& device, const StereoPass& pass, std::size_t mostPairs) {
    const std::size_t bytes = std::max<std::size_t>(mostPairs, 1) * sizeof(PairDraw);
    requireRange(device, bytes, "the list of tiles", "draw the eyes one by one: --one-pass false");
    constexpr VkBufferUsageFlags kStorage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    StereoTarget target;
    target.mostPairs = mostPairs;
    target.passed = Buffer(device, bytes, kStorage, MemoryUse::onDevice);
    target.passedRuns =
        Buffer(device, kMostTestedRuns * sizeof(PassedRun),
               kStorage | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryUse::onDevice);
    target.pool = makeSetPool(device, kFramesInFlight + 1, kStereoBindings);
    const auto makeSet = [&](const Buffer& pairs) {
        return allocateSet(
            device, target.pool, pass.layout,
            std::array<Bound, 3>{{{pairs.handle()}, {target.passed.handle()}, {target.passedRuns.handle()}}});
    };
    target.passedSet = makeSet(target.passed);
    for (std::size_t frame = 0; frame < kFramesInFlight; ++frame) {
        target.pairs[frame] = Buffer(device, bytes, kStorage, MemoryUse::hostFeeds);
        target.sets[frame] = makeSet(target.pairs[frame]);
    }
    return target;
}

void recordStereoWarp(VkCommandBuffer commands, const StereoPass& pass, const OcclusionPass& occlusion,
                      const GpuScene& scene, const std::array<VkDescriptorSet, kMaxEyes>& eyeSets,
                      const StereoTarget& target, std::size_t slot, std::span<const DrawRun> runs, int width,
                      int height, bool closesGaps) {
    bool hasLooked = false;
    while (!runs.empty()) {
        const std::span<const DrawRun> now = takeBatch(runs);
        if (now.front().batch == 0) {
            for (const DrawRun& run : now) {
                const ComputePipeline& pipeline = useForRun(commands, pass, scene, run, eyeSets, target.sets[slot]);
                push(commands, pipeline, WarpConstants{run.first, width, height, 0});
                vkCmdDispatch(commands, run.count, 1, 1);
            }
            continue;
        }
        const std::vector<PassedRun> none = nonePassed(now, closesGaps);
        const std::uint32_t pairs = now.back().first + now.back().count - now.front().first;
        const OccluderConstants occluders{width, height, closesGaps ? 1 : 0, hasLooked ? 1 : 0};
        hasLooked = true;
        recordPassing(commands, occlusion, eyeSets, occluders, target.passedRuns, none, [&] {
            use(commands, pass.test, std::array{eyeSets[0], eyeSets[1], target.sets[slot]});
            const std::uint32_t atOnce = kMaxWorkgroups * pass.testSize;
            for (std::uint32_t done = 0; done < pairs; done += atOnce) {
                const PairTestConstants constants{now[0].first + done, std::min(pairs - done, atOnce), width, height};
                push(commands, pass.test, constants);
                vkCmdDispatch(commands, (constants.count + pass.testSize - 1) / pass.testSize, 1, 1);
            }
        });
        for (std::size_t i = 0; i < now.size(); ++i) {
            const ComputePipeline& pipeline = useForRun(commands, pass, scene, now[i], eyeSets, target.passedSet);
            push(commands, pipeline, WarpConstants{now[i].first, width, height, 0});
            vkCmdDispatchIndirect(commands, target.passedRuns.handle(), i * sizeof(PassedRun));
        }
    }
}

} // namespace render
