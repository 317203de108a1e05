#include "app/coverage_on_device.h"

#include "render/check.h"
#include "render/device.h"
#include "render/post/coverage_texels.h"
#include "scene/coverage_levels.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

namespace app {

namespace {

/// Of fewer levels the tree takes no less: they are the grid of voxels.
constexpr int kFewestLevels = render::kVoxelLevels;

std::string millimetresOf(double metres) {
    char text[32];
    std::snprintf(text, sizeof text, "%.1f mm", 1e3 * metres);
    return text;
}

void sayIsEmptiness(const scene::Failure& why) {
    std::fprintf(stderr, "revisit: what nobody saw is shown as emptiness: the device cannot hold it (%s)\n",
                 why.what());
}

void sayIsCoarser(const scene::Coverage& coverage, int wished, int levels) {
    std::fprintf(stderr, "revisit: what nobody saw is told by cells of %s instead of %s: there is no room for more\n",
                 millimetresOf(scene::cellOfLevels(coverage, levels)).c_str(),
                 millimetresOf(scene::cellOfLevels(coverage, wished)).c_str());
}

/// Of so many levels, or if there is no room, of as many as there is room for. wished: what was hoped for.
std::unique_ptr<render::GpuCoverage> bring(const render::Device& device, const scene::Coverage& coverage, int wished,
                                           int levels) {
    while (true) {
        std::optional<scene::Failure> failure;
        try {
            auto brought = levels < scene::levelsOf(coverage)
                               ? std::make_unique<render::GpuCoverage>(device, scene::coarsened(coverage, levels))
                               : std::make_unique<render::GpuCoverage>(device, coverage);
            if (levels < wished) sayIsCoarser(coverage, wished, levels);
            return brought;
        } catch (const render::DeviceLost&) {
            throw;
        } catch (const scene::Failure& why) {
            failure = why;
        }
        if (levels <= kFewestLevels) {
            sayIsEmptiness(*failure);
            return nullptr;
        }
        --levels;
    }
}

} // namespace

CoverageForm formOf(const scene::Coverage& coverage, const render::Device& device, const CoverageWish& wish) {
    const std::vector<std::size_t> texels = render::coverageTexelsByLevels(coverage);
    CoverageForm form{.wished = static_cast<int>(texels.size()) - 1};
    while (form.wished > 1 && scene::cellOfLevels(coverage, form.wished) < wish.leastCellMetres)
        --form.wished;
    const std::size_t most =
        std::min<std::size_t>(wish.mostBytes / sizeof(render::CoverageTexel), device.limits().maxTexelBufferElements);
    const auto texelsNow = [&] { return texels[static_cast<std::size_t>(form.levels)]; };
    form.levels = form.wished;
    while (form.levels > kFewestLevels && texelsNow() > most)
        --form.levels;
    form.bytes = texelsNow() * sizeof(render::CoverageTexel);
    return form;
}

std::unique_ptr<render::GpuCoverage> bringCoverage(const render::Device& device, const scene::Coverage& coverage,
                                                   const CoverageForm& form) {
    return bring(device, coverage, form.wished, form.levels);
}

void makeBeside(const render::Device& device, const scene::Scene& scene, std::unique_ptr<render::GpuCoverage>& onDevice,
                const std::function<void()>& make) {
    while (true) {
        try {
            return make();
        } catch (const render::OutOfMemory& failure) {
            if (onDevice == nullptr) throw;
            const int levels = onDevice->levels();
            onDevice.reset();
            if (levels > kFewestLevels)
                onDevice = bring(device, *scene.coverage, levels, levels - 1);
            else
                sayIsEmptiness(failure);
        }
    }
}

} // namespace app
