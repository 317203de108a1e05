#pragma once
// Memory on the device for what tiles hold, in pages that shaders see.

#include "render/pipeline.h"
#include "render/resources.h"
#include "render/scene_index.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace render {

class TilePool {
  public:
    /// A page of so many texels each. isStaged: as if the processor could not see the device's memory. Throws
    /// scene::Failure if that does not suffice.
    TilePool(const Device& device, std::span<const std::uint32_t> texelsOfPages, bool isStaged);

    std::size_t pageCount() const { return pages_.size(); }
    std::uint32_t texelsOf(std::size_t page) const { return pages_[page].texels; }
    std::size_t bytes() const { return bytes_; }

    /// Bindings 0: vertices, 1: quads, 2: facets (two texels each), 3: what they are textured with. All are the page:
    /// a chunk's parts lie side by side in it.
    VkDescriptorSetLayout layout() const { return layout_; }
    VkDescriptorSet setOf(std::size_t page) const { return pages_[page].set; }
    VkBuffer bufferOf(std::size_t page) const { return pages_[page].buffer.handle(); }

    /// Where a place is seen by the processor; null if it cannot see the device's memory, or that is nowhere.
    std::byte* mapped(const ChunkPlace& place) const {
        if (isStaged_ || place.page >= pages_.size()) return nullptr;
        std::byte* const page = pages_[place.page].buffer.mapped();
        return page != nullptr ? page + std::size_t{place.firstTexel} * kTexelBytes : nullptr;
    }

    /// A place and how much of it there is.
    struct Part {
        ChunkPlace place;
        std::uint32_t texels = 0;
    };
    /// Lets write(i, bytes) fill each part (what is there starts undefined), several at the same time, and waits until
    /// the device has them.
    void fill(const Device& device, std::span<const Part> parts,
              const std::function<void(std::size_t, std::byte*)>& write);

  private:
    struct Page {
        Buffer buffer;
        BufferView view;
        VkDescriptorSet set = VK_NULL_HANDLE;
        std::uint32_t texels = 0;
    };
    VkDescriptorSetLayout layout_ = VK_NULL_HANDLE;
    bool isStaged_;
    DescriptorPool pool_;
    std::vector<Page> pages_;
    std::size_t bytes_ = 0;
};

} // namespace render
