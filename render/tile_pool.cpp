#include "render/tile_pool.h"

#include "render/command_streams.h"
#include "render/device.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace render {

namespace {

constexpr std::array kPageBindings{Binding::texels, Binding::texels, Binding::texels, Binding::texels};

/// What a device gets at a time whose memory the processor cannot see.
constexpr std::size_t kStagedBytes = std::size_t{64} << 20;

} // namespace

TilePool::TilePool(const Device& device, std::span<const std::uint32_t> texelsOfPages, bool isStaged)
    : layout_(makeSetLayout(device, kPageBindings)), isStaged_(isStaged) {
    if (texelsOfPages.empty()) return;
    pool_ = makeSetPool(device, texelsOfPages.size(), kPageBindings);
    for (const std::uint32_t texels : texelsOfPages) {
        Page page;
        page.texels = texels;
        page.buffer =
            Buffer(device, std::size_t{texels} * kTexelBytes,
                   VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryUse::onDevice);
        page.view = makeTexelView(device, page.buffer);
        const Bound bound{page.buffer.handle(), page.view};
        page.set = allocateSet(device, pool_, layout_, std::array{bound, bound, bound, bound});
        bytes_ += page.buffer.size();
        pages_.push_back(std::move(page));
    }
}

void TilePool::fill(const Device& device, std::span<const Part> parts,
                    const std::function<void(std::size_t, std::byte*)>& write) {
    std::vector<std::size_t> staged; ///< parts that the processor cannot write to
    for (std::size_t i = 0; i < parts.size(); ++i)
        if (mapped(parts[i].place) == nullptr) staged.push_back(i);
    tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t i) {
        if (std::byte* const bytes = mapped(parts[i].place)) write(i, bytes);
    });
    const auto bytesOf = [&](std::size_t i) { return std::size_t{parts[i].texels} * kTexelBytes; };
    for (std::size_t first = 0, end = 0; first < staged.size(); first = end) {
        std::vector<std::size_t> offsets; ///< in the staging buffer
        std::size_t bytes = 0;
        while (end < staged.size() && (end == first || bytes + bytesOf(staged[end]) <= kStagedBytes)) {
            offsets.push_back(bytes);
            bytes += bytesOf(staged[end++]);
        }
        // A chunk may be empty; a buffer, or what is copied of it, may not.
        const Buffer staging(device, std::max(bytes, kTexelBytes), VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
                             MemoryUse::hostWrites);
        tbb::parallel_for(first, end, [&](std::size_t k) { write(staged[k], staging.mapped() + offsets[k - first]); });
        runAndWait(device, [&](VkCommandBuffer commands) {
            for (std::size_t k = first; k < end; ++k) {
                const ChunkPlace& place = parts[staged[k]].place;
                if (bytesOf(staged[k]) == 0) continue;
                const VkBufferCopy one{offsets[k - first], std::size_t{place.firstTexel} * kTexelBytes,
                                       bytesOf(staged[k])};
                vkCmdCopyBuffer(commands, staging.handle(), bufferOf(place.page), 1, &one);
            }
        });
    }
}

} // namespace render
