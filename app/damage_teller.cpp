#include "app/damage_teller.h"

namespace app {

std::vector<std::string> DamageTeller::news(render::GpuScene& gpuScene, const scene::Scene& scene) {
    std::vector<std::string> sentences;
    for (const std::uint32_t chunk : gpuScene.takeDamaged()) {
        chunks_.insert(chunk);
        const std::uint32_t image = gpuScene.index().chunks[chunk].captured;
        if (told_.insert(image).second)
            sentences.push_back((scene.folder / "tiles.bin").string() + ": what image " + scene.images[image].name +
                                " gave is damaged; it is drawn as unseen: build the scene again");
    }
    return sentences;
}

} // namespace app
