#pragma once
// The walker's settings from walk to walk: read before one, written after it if they were changed. Nothing that goes
// wrong with them keeps anybody from walking.

#include "input/settings.h"

#include <filesystem>
#include <functional>
#include <string>

namespace app {

class KeptSettings {
  public:
    /// file: empty where there is no home. tell is called with one sentence for what goes wrong: a broken file means
    /// the defaults, and is left as it is.
    KeptSettings(std::filesystem::path file, std::function<void(const std::string&)> tell);

    const input::Settings& read() const { return read_; }
    void keep(const input::Settings& settings) const;

  private:
    std::filesystem::path file_;
    std::function<void(const std::string&)> tell_;
    input::Settings read_;
    bool isBroken_ = false;
};

} // namespace app
