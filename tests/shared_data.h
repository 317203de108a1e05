#pragma once
// Captures that are too large for this repository.

#include <cstdlib>
#include <filesystem>

namespace tests {

/// The folder they lie in: the environment variable REVISIT_DATA, or what the build was told. May be absent.
inline std::filesystem::path dataFolder() {
    const char* const chosen = std::getenv("REVISIT_DATA");
    return chosen ? std::filesystem::path(chosen) : std::filesystem::path(REVISIT_SHARED_DATA);
}

} // namespace tests
