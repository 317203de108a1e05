#include "render/target.h"

#include "render/device.h"
#include "render/shaders/shared/hole_words.h"
#include "render/shaders/shared/large_part.h"
#include "render/shaders/shared/occlusion.h"
#include "render/shaders/shared/tile_draw.h"
#include "scene/errors.h"

#include <algorithm>
#include <cstdint>

namespace render {

namespace {

constexpr std::array kEyeBindings{Binding::storage, Binding::storage, Binding::storage, Binding::storage,
                                  Binding::texels,  Binding::storage, Binding::storage, Binding::storage,
                                  Binding::storage, Binding::texels,  Binding::texels};

static_assert(std::count(kEyeBindings.begin(), kEyeBindings.end(), Binding::storage) == kEyeStorageBuffers);

constexpr std::uint32_t kDrawsBinding = 0, kPassedBinding = 7, kDrawTexelsBinding = 10;
constexpr std::size_t kDrawTexels = sizeof(TileDraw) / 16;
constexpr std::size_t kFirstDraws = 4096;
constexpr std::size_t kLeastHoles = kLargePartsHead + sizeof(LargePart) / sizeof(std::uint32_t);

void requireTexels(const Device& device, std::size_t texels, const std::string& what, const std::string& remedy) {
    if (texels <= device.limits().maxTexelBufferElements) return;
    throw scene::Failure(what + " takes " + std::to_string(texels) + " texels, more than the " +
                             std::to_string(device.limits().maxTexelBufferElements) + " a shader can read",
                         device.name(), remedy);
}

void makeDrawBuffers(const Device& device, EyeTarget& target, std::size_t most) {
    const std::size_t bytes = most * sizeof(TileDraw);
    const std::string remedy = "let wider samples stand for finer ones: --warp points --sample-pixels 2";
    requireRange(device, bytes, "the list of tiles", remedy);
    requireTexels(device, most * kDrawTexels, "the list of tiles", remedy);
    constexpr VkBufferUsageFlags kStorage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                 kTexels = kStorage | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT;
    for (std::size_t frame = 0; frame < kFramesInFlight; ++frame) {
        target.drawTexels[frame] = {};
        target.draws[frame] = Buffer(device, bytes, kTexels, MemoryUse::hostFeeds);
        target.drawTexels[frame] = makeTexelView(device, target.draws[frame], VK_FORMAT_R32G32B32A32_UINT);
    }
    target.passed = Buffer(device, most * sizeof(PassedDraw), kStorage, MemoryUse::onDevice);
    target.mostDraws = most;
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
    requireTexels(device, pixels, "the z-buffer", "choose a smaller image");

    constexpr VkBufferUsageFlags kStorage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                 kTexels = kStorage | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT;
    EyeTarget target;
    target.zBuffer =
        Buffer(device, pixels * sizeof(std::uint64_t), kTexels | VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryUse::onDevice);
    // On the device: every pass from resolve on reads and writes them, and few frames are read back.
    constexpr VkBufferUsageFlags kPicture = kTexels | VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
    target.colours = Buffer(device, pixels * sizeof(std::uint32_t), kPicture, MemoryUse::onDevice);
    target.depths = Buffer(device, pixels * sizeof(float), kPicture, MemoryUse::onDevice);
    constexpr VkBufferUsageFlags kTransferred = VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
    const auto holes = static_cast<std::size_t>(pinholesAt(width, height, height));
    target.holes = Buffer(device, std::max(holes, kLeastHoles) * sizeof(std::uint32_t), kTransferred | kStorage,
                          MemoryUse::onDevice);
    target.listedGroups =
        Buffer(device, sizeof(VkDispatchIndirectCommand),
               VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryUse::onDevice);
    target.zTexels = makeTexelView(device, target.zBuffer);
    const auto occluders = static_cast<std::size_t>(occludersAlong(width) * occludersAlong(height));
    target.occluders = Buffer(device, occluders * sizeof(Occluder), kTexels, MemoryUse::onDevice);
    target.occluderTexels = makeTexelView(device, target.occluders, VK_FORMAT_R32G32B32A32_UINT);
    target.passedRuns =
        Buffer(device, kMostTestedRuns * sizeof(PassedRun),
               kStorage | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryUse::onDevice);
    target.pool = makeSetPool(device, kFramesInFlight, kEyeBindings);
    makeDrawBuffers(device, target, kFirstDraws);
    for (std::size_t frame = 0; frame < kFramesInFlight; ++frame) {
        const Buffer& draws = target.draws[frame];
        const std::array<Bound, kEyeBindings.size()> bound{{{draws.handle()},
                                                            {target.zBuffer.handle()},
                                                            {target.colours.handle()},
                                                            {target.depths.handle()},
                                                            {target.zBuffer.handle(), target.zTexels},
                                                            {target.holes.handle()},
                                                            {target.occluders.handle()},
                                                            {target.passed.handle()},
                                                            {target.passedRuns.handle()},
                                                            {target.occluders.handle(), target.occluderTexels},
                                                            {draws.handle(), target.drawTexels[frame]}}};
        target.sets[frame] = allocateSet(device, target.pool, eyeLayout, bound);
    }
    return target;
}

void makeRoomForDraws(const Device& device, EyeTarget& target, std::size_t draws) {
    if (draws <= target.mostDraws) return;
    makeDrawBuffers(device, target, draws + draws / 2); // so that it is not done again and again
    for (std::size_t frame = 0; frame < kFramesInFlight; ++frame) {
        rebind(device, target.sets[frame], kDrawsBinding, {target.draws[frame].handle()});
        rebind(device, target.sets[frame], kPassedBinding, {target.passed.handle()});
        rebind(device, target.sets[frame], kDrawTexelsBinding,
               {target.draws[frame].handle(), target.drawTexels[frame]});
    }
}

} // namespace render
