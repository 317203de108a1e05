#pragma once
// A polygon scene as plain values: meshes of textured triangles that stand in a world, once or several times.
//
//   unit      the metre
//   winding   counter-clockwise seen from the front; a mirroring instance turns it over
//   textures  sRGB, the first row is the top; texture coordinates have v = 0 at the bottom

#include "scene/image.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace scene {

struct Rgba8 {
    std::uint8_t r = 0, g = 0, b = 0, a = 255;
    friend bool operator==(const Rgba8&, const Rgba8&) = default;
};

struct PolygonTexture {
    std::string name;
    Image<Rgba8> pixels;
};

inline constexpr int kNoTexture = -1;

struct PolygonMaterial {
    std::string name;
    glm::vec3 baseColour{0.8f}; ///< linear; times the texture's colour where there is one
    int colourTexture = kNoTexture;
    int alphaTexture = kNoTexture; ///< where its alpha is below alphaCut there is no surface
    float alphaCut = 0.5f;
    bool isGlass = false; ///< less than half opaque: light and looks go through, nothing is seen of it
};

/// Triangles of one material. The lists for corners are as long as positions, or empty where the file has none.
struct PolygonMesh {
    std::string name;
    std::vector<glm::vec3> positions, normals;
    std::vector<glm::vec2> texturePlaces;
    std::vector<glm::vec3> colours; ///< linear, times the material's
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::uint32_t material = 0;
};

/// A mesh as it stands in the world: any invertible affine map.
struct PolygonInstance {
    std::uint32_t mesh = 0;
    glm::dmat4 worldFromMesh{1.0};
};

struct PolygonScene {
    std::vector<PolygonTexture> textures;
    std::vector<PolygonMaterial> materials;
    std::vector<PolygonMesh> meshes;
    std::vector<PolygonInstance> instances;
    std::vector<std::filesystem::path> files; ///< that it was read from
    std::vector<std::string> remarks;         ///< what was left out or guessed, in whole sentences for the user
};

/// Over all instances, glass included.
std::int64_t countTriangles(const PolygonScene& scene);

struct PolygonBounds {
    glm::dvec3 low{0.0}, high{0.0}; ///< world
};
PolygonBounds boundsOf(const PolygonScene& scene);

} // namespace scene
