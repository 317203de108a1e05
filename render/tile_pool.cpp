#include "render/tile_pool.h"

#include "render/command_streams.h"
#include "render/device.h"

namespace render {

namespace {

constexpr std::array kPageBindings{Binding::texels, Binding::texels, Binding::texels, Binding::texels};

} // namespace

TilePool::TilePool(const Device& device, std::span<const std::uint32_t> texelsOfPages)
    : layout_(makeSetLayout(device, kPageBindings)) {
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

void TilePool::fill(const Device& device, std::size_t page, const std::function<void(std::byte*)>& write) {
    const Buffer& target = pages_[page].buffer;
    if (target.mapped() != nullptr) {
        write(target.mapped());
        return;
    }
    const Buffer staging(device, target.size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, MemoryUse::hostWrites);
    write(staging.mapped());
    runAndWait(device, [&](VkCommandBuffer commands) {
        const VkBufferCopy all{0, 0, staging.size()};
        vkCmdCopyBuffer(commands, staging.handle(), target.handle(), 1, &all);
    });
}

} // namespace render
