#pragma once
// How far a long step is: a bar with the time left on a terminal, a plain line now and then elsewhere. Written to
// stderr.

#include <chrono>
#include <cstddef>
#include <mutex>
#include <string>

namespace app {

/// One step of `total` items; advance may be called from any thread. The end is told when it goes out of scope.
class Progress {
  public:
    Progress(std::string step, std::size_t total);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    void advance(std::size_t items = 1);

  private:
    void show(bool isLast);
    std::string step_;
    std::size_t total_, done_ = 0;
    bool isTerminal_;
    std::chrono::steady_clock::time_point start_, shown_;
    std::mutex mutex_;
};

} // namespace app
