#pragma once
// What was observed of a scene, brought to a device as finely as it was asked for and as there is room. Coarser cells
// tell nearly as well what nobody saw (docs/performance.md, "What the unseen costs"); without any it would look empty.

#include "render/check.h"
#include "render/post/unseen.h"
#include "scene/scene.h"

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

namespace app {

struct CoverageWish {
    double leastCellMetres = 0; ///< cells no smaller than this; 0: as they were built
    std::size_t mostBytes = 0;  ///< on the device, if there is a form so small
    std::string whyNoMore{};    ///< than mostBytes, in words
};

/// How finely it is brought: levels of its tree (scene/coverage_levels.h).
struct CoverageForm {
    int wished = 0;
    int levels = 0;        ///< fewer if there is no room for those
    std::size_t bytes = 0; ///< that it takes then, or a little less
    std::string why{};     ///< it is fewer
};

/// mostTexels: how many a device's shaders can read of one buffer.
CoverageForm formOf(const scene::Coverage& coverage, std::size_t mostTexels, const CoverageWish& wish);

/// Null, with a line that says so, if the device cannot hold its coarsest form. A line says, too, if cells are coarser
/// than was wished.
std::unique_ptr<render::GpuCoverage> bringCoverage(const render::Device& device, const scene::Coverage& coverage,
                                                   const CoverageForm& form);

/// Cells become coarser by a level, or where they are coarsest coverage is given up, and a line says so; whatever draws
/// it must have gone. False if there is none.
bool giveUpFinest(const render::Device& device, const scene::Scene& scene,
                  std::unique_ptr<render::GpuCoverage>& onDevice, const render::OutOfMemory& failure);

/// Makes what needs memory beside `onDevice`. While there is too little, the finest cells are given up
/// (giveUpFinest). Throws what `make` throws if that was all that could be.
void makeBeside(const render::Device& device, const scene::Scene& scene, std::unique_ptr<render::GpuCoverage>& onDevice,
                const std::function<void()>& make);

} // namespace app
