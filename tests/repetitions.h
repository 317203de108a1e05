#pragma once
// How often tests repeat themselves.

#include <algorithm>
#include <cstdlib>

namespace tests {

/// Of so many usual repetitions with other seeds or places an eighth under a sanitizer, which takes ten times as long
/// and sees in the first what it would see in the last: whether results are right is for the release run to say.
constexpr int repetitions(int usual) {
#ifdef REVISIT_SANITIZED
    return std::max(1, usual / 8);
#else
    return usual;
#endif
}

/// Whether there is time for what takes minutes and says what shorter tests beside it make likely: ./dev test --long.
inline bool areLong() {
    return std::getenv("REVISIT_LONG_TESTS") != nullptr;
}

} // namespace tests
