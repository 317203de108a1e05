#include "tests/app/walker.h"

#include <chrono>
#include <csignal>
#include <fstream>
#include <iterator>
#include <sstream>

#include <poll.h>
#include <sys/wait.h>

namespace app {

namespace {

constexpr std::chrono::seconds kPatience{240}; // for machines with much else to do
constexpr int kLookAgainMilliseconds = 2;

std::size_t countOf(const std::filesystem::path& folder) {
    std::error_code gone;
    std::size_t count = 0;
    for (auto entry = std::filesystem::directory_iterator(folder, gone);
         !gone && entry != std::filesystem::directory_iterator(); entry.increment(gone))
        ++count;
    return count;
}

} // namespace

std::vector<std::string> givingMemoryBack(const std::vector<std::string>& command) {
    std::vector<std::string> words{"/usr/bin/env", "MALLOC_ARENA_MAX=1", "MALLOC_MMAP_THRESHOLD_=131072",
                                   "MALLOC_TRIM_THRESHOLD_=131072"};
    words.insert(words.end(), command.begin(), command.end());
    return words;
}

Walker::Walker(const std::vector<std::string>& command, const std::filesystem::path& folder)
    : log_(folder / "walk.txt"), process_(start(command, log_)) {}

Walker::~Walker() {
    if (process_ == 0) return;
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
}

std::string Walker::said() const {
    std::ifstream file(log_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

int Walker::timesSaid(const std::string& words) const {
    const std::string text = said();
    int times = 0;
    for (std::size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1))
        ++times;
    return times;
}

bool Walker::hasEnded() const {
    siginfo_t info{};
    return process_ == 0 || (waitid(P_PID, static_cast<id_t>(process_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
                             info.si_pid == process_);
}

bool Walker::waitUntil(const std::function<bool()>& isSo) const {
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    // What it says, keeps and holds comes with no event that all of it shares; looking costs little.
    while (!isSo()) {
        if (hasEnded() || std::chrono::steady_clock::now() > deadline) return isSo();
        poll(nullptr, 0, kLookAgainMilliseconds);
    }
    return true;
}

Holdings Walker::holdings() const {
    const std::filesystem::path self = "/proc/" + std::to_string(process_);
    Holdings holdings;
    std::ifstream status(self / "status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with("VmRSS:")) {
            std::size_t kibibytes = 0;
            std::istringstream(line.substr(6)) >> kibibytes;
            holdings.memoryBytes = kibibytes << 10;
        }
    holdings.files = countOf(self / "fd");
    holdings.threads = countOf(self / "task");
    return holdings;
}

void Walker::interrupt() const {
    kill(process_, SIGINT);
}

Outcome Walker::waitForEnd() {
    const pid_t process = process_;
    process_ = 0;
    return waitFor(process, log_);
}

} // namespace app
