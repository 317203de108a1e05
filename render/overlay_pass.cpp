#include "render/overlay_pass.h"

#include "render/device.h"
#include "spirv/overlay.comp.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace render {

namespace {

constexpr std::array kListBindings{Binding::storage, Binding::storage, Binding::storage};

template <class T>
void copy(const std::vector<T>& values, const Buffer& buffer) {
    const auto room = buffer.as<T>();
    assert(values.size() <= room.size());
    std::copy(values.begin(), values.end(), room.begin());
}

} // namespace

OverlayPass makeOverlayPass(const Device& device, VkDescriptorSetLayout eyeLayout) {
    OverlayPass pass;
    pass.listLayout = makeSetLayout(device, kListBindings);
    const std::uint32_t workgroupSize = device.workgroupSize(128);
    pass.pipeline =
        makeComputePipeline(device, kOverlayCode, std::array<VkDescriptorSetLayout, 2>{eyeLayout, pass.listLayout},
                            sizeof(OverlayConstants), std::array{workgroupSize});
    return pass;
}

OverlayBuffers makeOverlayBuffers(const Device& device, const OverlayPass& pass, int width, int height) {
    const auto room = [&](std::size_t bytes) {
        return Buffer(device, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, MemoryUse::hostFeeds);
    };
    OverlayBuffers buffers;
    buffers.strokes = room(kMaxStrokes * sizeof(OverlayStroke));
    buffers.entries = room(kMaxEntries * sizeof(std::uint32_t));
    buffers.bins = room(std::size_t{binsAlong(width)} * binsAlong(height) * sizeof(OverlayBin));
    buffers.pool = makeSetPool(device, 1, kListBindings);
    const std::array<Bound, kListBindings.size()> bound{
        {{buffers.strokes.handle()}, {buffers.entries.handle()}, {buffers.bins.handle()}}};
    buffers.set = allocateSet(device, buffers.pool, pass.listLayout, bound);
    return buffers;
}

void write(const OverlayList& list, const OverlayBuffers& buffers) {
    copy(list.strokes, buffers.strokes);
    copy(list.entries, buffers.entries);
    copy(list.bins, buffers.bins);
}

void recordOverlay(VkCommandBuffer commands, const OverlayPass& pass, const OverlayList& list,
                   const OverlayBuffers& buffers, VkDescriptorSet eyeSet) {
    const VkPipelineLayout layout = pass.pipeline.layout();
    const std::array sets{eyeSet, buffers.set};
    bind(commands, pass.pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 2, sets.data(), 0, nullptr);
    const auto count = static_cast<std::uint32_t>(list.bins.size());
    for (std::uint32_t done = 0; done < count; done += kMaxWorkgroups) {
        OverlayConstants constants = list.constants;
        constants.firstBin = done;
        vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, &constants);
        vkCmdDispatch(commands, std::min(count - done, kMaxWorkgroups), 1, 1);
    }
}

} // namespace render
