#pragma once
// The scene that benchmarks of whole scenes draw: the one that ./dev demo builds, or another that REVISIT_BENCH_SCENE
// names.

#include "scene/scene_file.h"

#include <benchmark/benchmark.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace render {

/// Null where there is none: the benchmark is then skipped and says why.
inline const scene::Scene* givenScene(benchmark::State& state) {
    const char* const given = std::getenv("REVISIT_BENCH_SCENE");
    const std::string folder = given != nullptr ? given : "demo/room.revisit";
    if (!std::filesystem::exists(folder)) {
        state.SkipWithError(("no scene at " + folder + ": run ./dev demo first").c_str());
        return nullptr;
    }
    static const scene::Scene scene = scene::openScene(folder);
    return &scene;
}

} // namespace render
