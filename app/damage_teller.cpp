#include "app/damage_teller.h"

namespace app {

std::vector<std::string> DamageTeller::lost(const scene::Scene& scene) {
    std::vector<std::string> sentences;
    for (const std::size_t image : scene.damaged)
        sentences.push_back((scene.folder / "tiles.bin").string() + ": nothing of image " + scene.images[image].name +
                            " can be read any more, and nothing of it is drawn: build the scene again");
    return sentences;
}

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
