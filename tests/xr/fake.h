#pragma once
// The runtime in tests/xr/fake_runtime.cpp: where it is, and what it is told.

#include "tests/scene/scratch_folder.h"

#include <string>
#include <vector>

namespace xr {

/// Its manifest, for as long as this lives.
class Fake {
  public:
    Fake();

    std::filesystem::path manifest() const { return folder_ / "fake.json"; }
    /// The command that runs another where this is the runtime, it is told those words, and there is no display.
    std::vector<std::string> around(const std::string& words, const std::vector<std::string>& command) const;

  private:
    scene::ScratchFolder folder_;
};

} // namespace xr
