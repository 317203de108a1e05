#pragma once
// What a synthetic scene is made of: exact planes, spheres, tubes and triangle meshes, each with a procedural
// material and, once lit, the diffuse light that falls on it.
//
// Coordinates are world coordinates: metres, right-handed, +Z up, floor or road at z = 0.

#include "scene/pose.h"
#include "scene/synthetic_texture.h"

#include <array>
#include <cstdint>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace scene {

inline constexpr double kTwoPi = 2 * std::numbers::pi;

/// Light that falls on a surface, on a regular grid over its two parameters in [0, 1]; the colour that a
/// white surface would show. Sun is not in it.
struct LightMap {
    int columns = 1, rows = 1;
    std::vector<glm::dvec3> nodes; ///< rows x columns; empty: not lit yet
};

struct Rectangle {
    glm::dvec2 low{0.0}, high{0.0};
};

/// A planar piece: a convex outline, or a rectangle with rectangular holes. u and v are orthonormal and
/// normal = u x v.
struct Patch {
    glm::dvec3 origin{0.0}, u{1, 0, 0}, v{0, 1, 0}, normal{0, 0, 1};
    std::vector<glm::dvec2> outline; ///< metres along u and v, counter-clockwise
    std::vector<Rectangle> holes;    ///< only where the outline is a rectangle
    Rectangle extent;                ///< of the outline
    int material = 0;
    bool twoSided = false;   ///< thin: looks the same from behind
    double lightSpacing = 0; ///< metres between nodes of its light map; 0: the model's
    LightMap light;
};

enum class RoundKind : std::uint8_t { sphere, tube, disc };

/// A sphere about the origin, a tube from it along the axis (its wall only), or a disc around it facing the
/// axis.
struct Round {
    RoundKind kind = RoundKind::sphere;
    glm::dvec3 origin{0.0}, axis{0, 0, 1}, side{1, 0, 0}, up{0, 1, 0}; ///< orthonormal: axis = side x up
    double radius = 0, length = 0;                                     ///< metres; length is the tube's
    int material = 0;
    LightMap light;
};

/// Curved things as triangles with smooth shading. The geometry is the triangles'.
struct Mesh {
    std::vector<glm::dvec3> positions, normals;
    std::vector<glm::dvec3> texturePlaces; ///< where the material is looked up: dents carry their paint with them
    std::vector<glm::dvec3> light;         ///< for each vertex, as LightMap
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<int> materials; ///< for each triangle
};

/// A lamp, or an opening to the sky: a rectangle that shines towards edgeU x edgeV. A model with openings
/// gets light from the sky through them only, which costs fewer rays than to look for them.
struct AreaLight {
    glm::dvec3 corner{0.0}, edgeU{0.0}, edgeV{0.0};
    glm::dvec3 radiance{0.0};
    bool isOpening = false; ///< the radiance is the sky's
};

struct Sky {
    glm::dvec3 towardsSun{0, 0, 1}; ///< unit
    glm::dvec3 sun{0.0};            ///< colour of a white surface that faces the sun
    glm::dvec3 zenith{0.25, 0.45, 0.9}, horizon{0.8, 0.88, 1.0};
    double clouds = 0.5; ///< how much of the sky they cover, in [0, 1]
    std::uint32_t seed = 0;
};

/// A place to look from and the way to look, for paths.
struct Waypoint {
    glm::dvec3 position{0.0};
    glm::dvec3 lookAt{0.0};
};

struct SyntheticModel {
    std::string name;
    std::vector<Material> materials;
    std::vector<Patch> patches;
    std::vector<Round> rounds;
    Mesh mesh;
    std::vector<AreaLight> lamps;
    Sky sky;
    double exposure = 1.0;
    double lightSpacing = 0.1;  ///< metres between nodes of light maps
    std::vector<Waypoint> walk; ///< a round walk: the last is followed by the first if walkIsLoop
    bool walkIsLoop = true;
    std::vector<glm::dvec3> tripods; ///< where a scanner would be set up
};

int addMaterial(SyntheticModel& model, const Material& material);

/// A rectangle: origin and two orthogonal edges; it faces edgeU x edgeV. Holes in metres along the edges.
Patch& addRectangle(SyntheticModel& model, const glm::dvec3& origin, const glm::dvec3& edgeU, const glm::dvec3& edgeV,
                    int material, std::vector<Rectangle> holes = {});

/// A convex planar polygon, counter-clockwise seen from the side it faces; u runs along its first edge.
Patch& addPolygon(SyntheticModel& model, const std::vector<glm::dvec3>& corners, int material);

/// The six faces of a box between two corners, in the coordinates of a place. A face's texture begins at its
/// lower left.
void addBox(SyntheticModel& model, const Pose& worldFromBox, const glm::dvec3& low, const glm::dvec3& high,
            int material);

Round& addSphere(SyntheticModel& model, const glm::dvec3& centre, double radius, int material);

Round& addTube(SyntheticModel& model, const glm::dvec3& from, const glm::dvec3& to, double radius, int material);

Round& addDisc(SyntheticModel& model, const glm::dvec3& centre, const glm::dvec3& normal, double radius, int material);

/// A tube with a disc at both ends.
void addRod(SyntheticModel& model, const glm::dvec3& from, const glm::dvec3& to, double radius, int material);

/// A sheet of columns x rows squares over two parameters in [0, 1]; it faces the way that place turns from s
/// to t. Its texture lies at texture(s, t).
void addSheet(SyntheticModel& model, int columns, int rows, const std::function<glm::dvec3(double s, double t)>& place,
              const std::function<glm::dvec3(double s, double t)>& texture, int material);

/// Standing at a point, turned about the vertical.
Pose standing(const glm::dvec3& at, double yawRadians);

} // namespace scene
