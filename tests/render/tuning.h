#pragma once
// How devices that are made in the meantime deal their work out (ARCHITECTURE.md, Processor or card).

#include <cstdlib>
#include <optional>
#include <string>

namespace render {

/// REVISIT_TUNING is `value` as long as it lives; then what it was.
class Tuning {
  public:
    explicit Tuning(const std::string& value) {
        if (const char* before = std::getenv(kName)) before_ = before;
        setenv(kName, value.c_str(), 1);
    }
    ~Tuning() {
        if (before_)
            setenv(kName, before_->c_str(), 1);
        else
            unsetenv(kName);
    }
    Tuning(const Tuning&) = delete;
    Tuning& operator=(const Tuning&) = delete;

  private:
    static constexpr const char* kName = "REVISIT_TUNING";
    std::optional<std::string> before_;
};

} // namespace render
