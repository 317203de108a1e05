#pragma once
// `revisit walk` in a process of its own, watched from outside while it runs.

#include "tests/app/program.h"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace app {

/// What a process holds, as the kernel says it.
struct Holdings {
    std::size_t memoryBytes = 0; ///< resident
    std::size_t files = 0, threads = 0;
};

/// The command that runs another so that memory which it frees goes back to the kernel: else the C library keeps up to
/// some megabytes for each thread, more or less as it happens, and what is resident says little of what is held.
std::vector<std::string> givingMemoryBack(const std::vector<std::string>& command);

class Walker {
  public:
    /// Starts `command`; what it says goes to a file in `folder`.
    Walker(const std::vector<std::string>& command, const std::filesystem::path& folder);
    /// Kills it if it still runs.
    ~Walker();
    Walker(const Walker&) = delete;
    Walker& operator=(const Walker&) = delete;

    /// What it has said so far.
    std::string said() const;
    int timesSaid(const std::string& words) const;

    /// Until that is so; false if the program ended before, or it takes too long.
    bool waitUntil(const std::function<bool()>& isSo) const;
    bool hasEnded() const;

    /// Of the process, not of a program that it was started by.
    Holdings holdings() const;

    /// Ctrl-C.
    void interrupt() const;
    Outcome waitForEnd();

  private:
    std::filesystem::path log_;
    pid_t process_ = 0;
};

} // namespace app
