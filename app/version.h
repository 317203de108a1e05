#pragma once
// Which Revisit this is.

namespace app {

inline constexpr const char* kVersion = REVISIT_VERSION;
inline constexpr const char* kCommit =
    REVISIT_COMMIT; ///< of the tree it was built from; "unknown" outside a repository

} // namespace app
