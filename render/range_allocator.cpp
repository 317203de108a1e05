#include "render/range_allocator.h"

#include <cassert>
#include <iterator>

namespace render {

std::optional<std::uint32_t> RangeAllocator::take(std::uint32_t count) {
    assert(count > 0);
    const auto fit = bySize_.lower_bound(count);
    if (fit == bySize_.end()) return std::nullopt;
    const auto [size, first] = *fit;
    forget(byPlace_.find(first));
    if (size > count) give(first + count, size - count);
    return first;
}

void RangeAllocator::give(std::uint32_t first, std::uint32_t count) {
    if (count == 0) return;
    auto next = byPlace_.lower_bound(first);
    assert(next == byPlace_.end() || first + count <= next->first);
    if (next != byPlace_.end() && next->first == first + count) {
        count += next->second;
        forget(next);
        next = byPlace_.lower_bound(first);
    }
    if (next != byPlace_.begin()) {
        const auto before = std::prev(next);
        assert(before->first + before->second <= first);
        if (before->first + before->second == first) {
            first = before->first;
            count += before->second;
            forget(before);
        }
    }
    byPlace_.emplace(first, count);
    bySize_.emplace(count, first);
    free_ += count;
}

void RangeAllocator::forget(std::map<std::uint32_t, std::uint32_t>::iterator range) {
    const auto [first, count] = *range;
    free_ -= count;
    auto sized = bySize_.lower_bound(count);
    while (sized->second != first)
        ++sized;
    bySize_.erase(sized);
    byPlace_.erase(range);
}

} // namespace render
