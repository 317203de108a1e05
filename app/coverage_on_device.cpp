#include "app/coverage_on_device.h"

#include "app/say.h"
#include "render/device.h"
#include "render/post/coverage_texels.h"
#include "scene/coverage_levels.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace app {

namespace {

using render::kFewestLevels;

std::string millimetresOf(double metres) {
    char text[32];
    std::snprintf(text, sizeof text, "%.1f mm", 1e3 * metres);
    return text;
}

void sayIsEmptiness(const std::string& why) {
    say("what nobody saw is shown as emptiness: the device cannot hold it (" + why + ")");
}

void sayIsCoarser(const scene::Coverage& coverage, const CoverageForm& form) {
    say("what nobody saw is told by cells of " + millimetresOf(scene::cellOfLevels(coverage, form.levels)) +
        " instead of " + millimetresOf(scene::cellOfLevels(coverage, form.wished)) + " (" + form.why + ")");
}

} // namespace

CoverageForm formOf(const scene::Coverage& coverage, std::size_t mostTexels, const CoverageWish& wish) {
    const std::vector<render::CoverageSize> sizes = render::coverageSizesByLevels(coverage);
    CoverageForm form{.wished = static_cast<int>(sizes.size()) - 1};
    while (form.wished > 1 && scene::cellOfLevels(coverage, form.wished) < wish.leastCellMetres)
        --form.wished;
    const auto finest = [&](const auto& isTooLarge) {
        int levels = form.wished;
        while (levels > kFewestLevels && isTooLarge(sizes[static_cast<std::size_t>(levels)]))
            --levels;
        return levels;
    };
    const int readable = finest([&](const render::CoverageSize& size) { return size.mostTexels() > mostTexels; });
    const int affordable = finest([&](const render::CoverageSize& size) { return size.bytes() > wish.mostBytes; });
    form.levels = std::min(readable, affordable);
    form.bytes = sizes[static_cast<std::size_t>(form.levels)].bytes();
    if (form.levels < form.wished)
        form.why = readable < affordable ? "the device's shaders read no larger buffer" : wish.whyNoMore;
    return form;
}

std::unique_ptr<render::GpuCoverage> bringCoverage(const render::Device& device, const scene::Coverage& coverage,
                                                   const CoverageForm& form) {
    for (CoverageForm now = form;; --now.levels) {
        try {
            auto brought = now.levels < scene::levelsOf(coverage)
                               ? std::make_unique<render::GpuCoverage>(device, scene::coarsened(coverage, now.levels))
                               : std::make_unique<render::GpuCoverage>(device, coverage);
            if (now.levels < now.wished) sayIsCoarser(coverage, now);
            return brought;
        } catch (const render::DeviceLost&) {
            throw;
        } catch (const scene::Failure& failure) {
            now.why = failure.what();
        }
        if (now.levels <= kFewestLevels) {
            sayIsEmptiness(now.why);
            return nullptr;
        }
    }
}

bool giveUpFinest(const render::Device& device, const scene::Scene& scene,
                  std::unique_ptr<render::GpuCoverage>& onDevice, const render::OutOfMemory& failure) {
    if (onDevice == nullptr) return false;
    const int levels = onDevice->levels();
    onDevice.reset();
    if (levels > kFewestLevels)
        onDevice =
            bringCoverage(device, *scene.coverage, {.wished = levels, .levels = levels - 1, .why = failure.what()});
    else
        sayIsEmptiness(failure.what());
    return true;
}

void makeBeside(const render::Device& device, const scene::Scene& scene, std::unique_ptr<render::GpuCoverage>& onDevice,
                const std::function<void()>& make) {
    while (true) {
        try {
            return make();
        } catch (const render::OutOfMemory& failure) {
            if (!giveUpFinest(device, scene, onDevice, failure)) throw;
        }
    }
}

} // namespace app
