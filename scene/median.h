#pragma once
// The middle one by size.

#include <algorithm>
#include <vector>

namespace scene {

/// The upper of two middle ones; 0 of none. The values are left in another order.
template <class T>
T medianOf(std::vector<T>& values) {
    if (values.empty()) return 0;
    const auto middle = values.begin() + std::ssize(values) / 2;
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

} // namespace scene
