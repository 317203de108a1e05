#pragma once
// The runtime in tests/xr/fake_runtime.cpp: where it is, and what it is told.

#include "tests/scene/scratch_folder.h"

#include <string>
#include <vector>

#include <openxr/openxr.h>

namespace xr {

/// Its manifest, for as long as this lives.
class Fake {
  public:
    Fake();

    std::filesystem::path manifest() const { return folder_ / "fake.json"; }
    /// From here on this process finds it and nothing else; tell() says what it is told from then on.
    void enter() const;
    static void tell(const std::string& words);
    /// Its objects in this process that were made and not destroyed.
    int alive() const;
    /// Of the right eye's picture that it was handed last.
    XrRect2Di shown() const;

    /// The command that runs another where this is the runtime, it is told those words, and there is no display.
    std::vector<std::string> around(const std::string& words, const std::vector<std::string>& command) const;

  private:
    scene::ScratchFolder folder_;
    mutable void* library_ = nullptr; ///< kept loaded once entered: it counts
};

} // namespace xr
