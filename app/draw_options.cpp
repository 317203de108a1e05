#include "app/draw_options.h"

#include "scene/errors.h"

namespace app {

render::Quality qualityOf(const DrawOptions& o) {
    render::Quality quality = readQuality(o.quality);
    for (const auto& [name, value] : o.turned)
        turnKnob(quality, name, value, "the command line");
    quality.showUnseen = !o.hideUnseen;
    return quality;
}

void checkMemory(const scene::Scene& scene, const DrawOptions& o) {
    std::size_t bytes = 0;
    for (const scene::TileBlock& block : scene.blocks)
        bytes += block.vertices.size_bytes() + block.quads.size_bytes();
    if (bytes > o.memoryBytes)
        throw scene::Failure("needs " + std::to_string((bytes >> 20) + 1) + " MiB but --memory allows " +
                                 std::to_string(o.memoryBytes >> 20),
                             scene.folder, "allow more with --memory, or build it with a larger --cull-baseline");
}

} // namespace app
