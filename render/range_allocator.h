#pragma once
// Which parts of a page are taken.

#include <cstdint>
#include <map>
#include <optional>

namespace render {

/// Places of any size in [0, size), best fit first; what is given back joins its free neighbours.
class RangeAllocator {
  public:
    explicit RangeAllocator(std::uint32_t size) { give(0, size); }

    /// Nothing if no free range is long enough. count > 0.
    std::optional<std::uint32_t> take(std::uint32_t count);
    void give(std::uint32_t first, std::uint32_t count);
    std::uint32_t free() const { return free_; }
    std::uint32_t longest() const { return bySize_.empty() ? 0 : bySize_.rbegin()->first; }

  private:
    void forget(std::map<std::uint32_t, std::uint32_t>::iterator range);

    std::map<std::uint32_t, std::uint32_t> byPlace_;     ///< first -> count of each free range
    std::multimap<std::uint32_t, std::uint32_t> bySize_; ///< count -> first
    std::uint32_t free_ = 0;
};

} // namespace render
