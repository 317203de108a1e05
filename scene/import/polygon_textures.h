#pragma once
// The pictures on polygons: each file is read once, and what cannot be read is told once.

#include "scene/polygon_scene.h"

#include <map>

struct aiScene;

namespace scene {

/// Fills scene.textures, scene.files and scene.remarks as textures are asked for.
class PolygonTextures {
  public:
    PolygonTextures(const aiScene& source, std::filesystem::path folder, PolygonScene& scene)
        : source_(source), folder_(std::move(folder)), scene_(scene) {}

    /// The index of a texture by the name that the file has for it; kNoTexture, with a remark, if it cannot be had.
    int find(const std::string& named);

    /// A texture whose alpha is the opacity: the picture's alpha, or its brightness if it has none.
    int findOpacity(const std::string& named);

  private:
    struct Picture {
        Image<Rgba8> pixels;
        bool hasAlpha = false;
    };
    Picture read(const std::string& named);
    int keep(const std::string& named, Image<Rgba8> pixels);

    const aiScene& source_;
    std::filesystem::path folder_;
    PolygonScene& scene_;
    std::map<std::string, int> colours_, opacities_;
    std::map<std::string, bool> alphaOf_;
};

} // namespace scene
