#pragma once
// What is found damaged of a scene while it is drawn.

#include "render/gpu_scene.h"
#include "scene/scene.h"

#include <set>
#include <string>
#include <vector>

namespace app {

/// Tells of damaged tiles, once for each image.
class DamageTeller {
  public:
    /// A sentence for each image of which chunks have been found damaged since, that was not told of before.
    std::vector<std::string> news(render::GpuScene& gpuScene, const scene::Scene& scene);
    /// A sentence for each image of which nothing can be read.
    static std::vector<std::string> lost(const scene::Scene& scene);
    std::size_t chunks() const { return chunks_.size(); } ///< found damaged so far

  private:
    std::set<std::uint32_t> told_, chunks_; ///< a device made anew finds them again
};

} // namespace app
