#include "app/progress.h"

#include <cstdio>
#include <exception>

#include <unistd.h>

namespace app {

namespace {

constexpr auto kBarPause = std::chrono::milliseconds(100);
constexpr auto kLinePause = std::chrono::seconds(10);
constexpr std::size_t kBarWidth = 30;

std::string timeText(double seconds) {
    char text[32];
    if (seconds >= 90)
        std::snprintf(text, sizeof text, "%.0f min", seconds / 60);
    else
        std::snprintf(text, sizeof text, "%.0f s", seconds);
    return text;
}

} // namespace

Progress::Progress(std::string step, std::size_t total)
    : step_(std::move(step)), total_(total), isTerminal_(isatty(STDERR_FILENO) == 1),
      start_(std::chrono::steady_clock::now()), shown_(start_) {}

Progress::~Progress() {
    // A step that an error ended is not told as done.
    if (std::uncaught_exceptions() > 0) {
        if (isTerminal_) std::fputc('\n', stderr);
        return;
    }
    show(true);
}

void Progress::advance(std::size_t items) {
    const std::lock_guard lock(mutex_);
    done_ += items;
    const auto now = std::chrono::steady_clock::now();
    if (now - shown_ < (isTerminal_ ? std::chrono::duration_cast<std::chrono::milliseconds>(kBarPause)
                                    : std::chrono::duration_cast<std::chrono::milliseconds>(kLinePause)))
        return;
    shown_ = now;
    show(false);
}

void Progress::show(bool isLast) {
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    const double share = total_ > 0 ? static_cast<double>(done_) / static_cast<double>(total_) : 1.0;
    const std::string counts = std::to_string(done_) + "/" + std::to_string(total_);
    std::string line = step_;
    line.resize(std::max<std::size_t>(line.size(), 12), ' ');
    if (isLast)
        line += " " + counts + ", " + timeText(seconds);
    else if (isTerminal_) {
        const auto filled = static_cast<std::size_t>(share * kBarWidth);
        line += " [" + std::string(filled, '#') + std::string(kBarWidth - filled, '.') + "] " + counts;
    } else
        line += " " + counts;
    if (!isLast && share > 0) line += ", " + timeText(seconds / share - seconds) + " left";
    if (isTerminal_) line = "\r" + line + "\x1b[K";
    if (isLast || !isTerminal_) line += '\n';
    std::fputs(line.c_str(), stderr);
    std::fflush(stderr);
}

} // namespace app
