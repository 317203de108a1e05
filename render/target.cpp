#include "render/target.h"

#include "render/device.h"
#include "render/shaders/shared/tile_draw.h"
#include "scene/errors.h"

#include <algorithm>
#include <cstdint>
#include <string>

namespace render {

namespace {

void requireRange(const Device& device, std::size_t bytes, const std::string& what,
                  const std::string& remedy) {
    if (bytes <= device.limits().maxStorageBufferRange) return;
    throw scene::Failure(what + " takes " + std::to_string(bytes) + " bytes, more than the " +
                             std::to_string(device.limits().maxStorageBufferRange) + " a shader can see",
                         device.name(), remedy);
}

} // namespace

DescriptorSetLayout makeEyeLayout(const Device& device) {
    return makeStorageLayout(device, 4);
}

EyeTarget makeEyeTarget(const Device& device, VkDescriptorSetLayout eyeLayout, int width, int height,
                        std::size_t maxDraws) {
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    const std::size_t drawBytes = std::max<std::size_t>(maxDraws, 1) * sizeof(TileDraw);
    requireRange(device, pixels * sizeof(std::uint64_t), "the z-buffer", "choose a smaller image");
    requireRange(device, drawBytes, "the list of tiles", "build the scene with larger tiles");

    constexpr VkBufferUsageFlags kStorage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    EyeTarget target;
    target.zBuffer = Buffer(device, pixels * sizeof(std::uint64_t),
                            kStorage | VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryUse::onDevice);
    target.colours = Buffer(device, pixels * sizeof(std::uint32_t), kStorage, MemoryUse::hostReads);
    target.depths = Buffer(device, pixels * sizeof(float), kStorage, MemoryUse::hostReads);
    target.pool = makeStoragePool(device, kFramesInFlight, 4 * kFramesInFlight);
    for (std::size_t frame = 0; frame < kFramesInFlight; ++frame) {
        target.draws[frame] = Buffer(device, drawBytes, kStorage, MemoryUse::hostWrites);
        target.sets[frame] =
            allocateStorageSet(device, target.pool, eyeLayout,
                               std::array{target.draws[frame].handle(), target.zBuffer.handle(),
                                          target.colours.handle(), target.depths.handle()});
    }
    return target;
}

} // namespace render
