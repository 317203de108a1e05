#pragma once
// A scene that the programs made: a sample capture, prepared.

#include "tests/scene/scratch_folder.h"

#include <string>
#include <vector>

namespace app {

class SampleScene {
  public:
    /// kind, images and size as make_sample has them. Throws std::runtime_error with what the programs said.
    SampleScene(const std::string& kind, int images, const std::string& size);

    std::string capture() const { return (folder_ / "capture").string(); }
    std::string scene() const { return (folder_ / "sample.revisit").string(); }

  private:
    scene::ScratchFolder folder_;
};

/// Prepares a capture into a scene. Throws std::runtime_error with what the program said.
void prepare(const std::string& capture, const std::string& scene, const std::filesystem::path& scratch,
             const std::vector<std::string>& options = {});

} // namespace app
