#include "render/target.h"

#include "render/device.h"
#include "render/shaders/shared/hole_words.h"
#include "render/shaders/shared/occlusion.h"
#include "render/shaders/shared/tile_draw.h"
#include "scene/errors.h"

#include <algorithm>
#include <cstdint>

namespace render {

namespace {

constexpr std::array kEyeBindings{Binding::storage, Binding::storage, Binding::storage,
                                  Binding::storage, Binding::texels,  Binding::storage,
                                  Binding::storage, Binding::storage, Binding::storage};

static_assert(std::count(kEyeBindings.begin(), kEyeBindings.end(), Binding::storage) == kEyeStorageBuffers);

constexpr std::uint32_t kDrawsBinding = 0, kPassedBinding = 7;
constexpr std::size_t kFirstDraws = 4096;

void makeDrawBuffers(const Device& device, EyeTarget& target, std::size_t most) {
    const std::size_t bytes = most * sizeof(TileDraw);
    requireRange(device, bytes, "the list of tiles",
                 "let wider samples stand for finer ones: --warp points --sample-pixels 2");
    for (Buffer& draws : target.draws)
        draws = Buffer(device, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, MemoryUse::hostWrites);
    target.passed = Buffer(device, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, MemoryUse::onDevice);
    target.mostDraws = most;
}

void requireTexels(const Device& device, std::size_t texels) {
    if (texels <= device.limits().maxTexelBufferElements) return;
    throw scene::Failure("the image has " + std::to_string(texels) + " pixels, more than the " +
                             std::to_string(device.limits().maxTexelBufferElements) + " a shader can read",
                         device.name(), "choose a smaller image");
}

} // namespace

void requireRange(const Device& device, std::size_t bytes, const std::string& what, const std::string& remedy) {
    if (bytes <= device.limits().maxStorageBufferRange) return;
    throw scene::Failure(what + " takes " + std::to_string(bytes) + " bytes, more than the " +
                             std::to_string(device.limits().maxStorageBufferRange) + " a shader can see",
                         device.name(), remedy);
}

VkDescriptorSetLayout makeEyeLayout(const Device& device) {
    return makeSetLayout(device, kEyeBindings);
}

EyeTarget makeEyeTarget(const Device& device, VkDescriptorSetLayout eyeLayout, int width, int height) {
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    requireRange(device, pixels * sizeof(std::uint64_t), "the z-buffer", "choose a smaller image");
    requireTexels(device, pixels);

    constexpr VkBufferUsageFlags kStorage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                 kTexels = kStorage | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT;
    EyeTarget target;
    target.zBuffer =
        Buffer(device, pixels * sizeof(std::uint64_t), kTexels | VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryUse::onDevice);
    target.colours = Buffer(device, pixels * sizeof(std::uint32_t), kTexels | VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
                            MemoryUse::hostReads);
    target.depths = Buffer(device, pixels * sizeof(float), kTexels, MemoryUse::hostReads);
    const auto holes = static_cast<std::size_t>(pinholesAt(width, height, height));
    target.holes = Buffer(device, holes * sizeof(std::uint32_t), kStorage, MemoryUse::onDevice);
    target.zTexels = makeTexelView(device, target.zBuffer);
    const auto occluders = static_cast<std::size_t>(occludersAlong(width) * occludersAlong(height));
    target.occluders = Buffer(device, occluders * sizeof(std::uint32_t), kStorage, MemoryUse::onDevice);
    target.passedRuns =
        Buffer(device, kMostTestedRuns * sizeof(PassedRun),
               kStorage | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryUse::onDevice);
    target.pool = makeSetPool(device, kFramesInFlight + 1, kEyeBindings);
    makeDrawBuffers(device, target, kFirstDraws);
    const auto makeSet = [&](const Buffer& draws) {
        const std::array<Bound, kEyeBindings.size()> bound{{{draws.handle()},
                                                            {target.zBuffer.handle()},
                                                            {target.colours.handle()},
                                                            {target.depths.handle()},
                                                            {target.zBuffer.handle(), target.zTexels},
                                                            {target.holes.handle()},
                                                            {target.occluders.handle()},
                                                            {target.passed.handle()},
                                                            {target.passedRuns.handle()}}};
        return allocateSet(device, target.pool, eyeLayout, bound);
    };
    target.passedSet = makeSet(target.passed);
    for (std::size_t frame = 0; frame < kFramesInFlight; ++frame)
        target.sets[frame] = makeSet(target.draws[frame]);
    return target;
}

void makeRoomForDraws(const Device& device, EyeTarget& target, std::size_t draws) {
    if (draws <= target.mostDraws) return;
    makeDrawBuffers(device, target, draws + draws / 2); // so that it is not done again and again
    rebind(device, target.passedSet, kDrawsBinding, {target.passed.handle()});
    rebind(device, target.passedSet, kPassedBinding, {target.passed.handle()});
    for (std::size_t frame = 0; frame < kFramesInFlight; ++frame) {
        rebind(device, target.sets[frame], kDrawsBinding, {target.draws[frame].handle()});
        rebind(device, target.sets[frame], kPassedBinding, {target.passed.handle()});
    }
}

} // namespace render
