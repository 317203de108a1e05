#pragma once
// Runs the built programs as a user would.

#include <filesystem>
#include <string>
#include <vector>

#include <sys/types.h>

namespace app {

#ifdef REVISIT_PROGRAM // by the targets that run them
inline const std::string kRevisit = REVISIT_PROGRAM, kMakeSample = REVISIT_MAKE_SAMPLE;
#endif

struct Outcome {
    int status = 0;     ///< exit status; 128 + signal if killed by one
    std::string output; ///< stdout and stderr together
};

/// Starts a program with its output in a file.
pid_t start(const std::vector<std::string>& command, const std::filesystem::path& outputFile);
Outcome waitFor(pid_t process, const std::filesystem::path& outputFile);

/// Runs to the end.
Outcome run(const std::vector<std::string>& command, const std::filesystem::path& scratch);

/// All files below a folder: path relative to it, and the bytes.
std::vector<std::pair<std::string, std::string>> filesOf(const std::filesystem::path& folder);

} // namespace app
