#pragma once
// Procedural reflectance of synthetic surfaces: a function of the place on the surface alone, so that a point
// has the same colour from every view. Details are no finer than about a centimetre and have soft edges, so
// that pictures show texture and not aliasing.

#include <cstdint>

#include <glm/vec3.hpp>

namespace scene {

enum class Pattern : std::uint8_t {
    plain,
    mottled, ///< slow noise between base and accent
    plaster, ///< faint grain
    planks,  ///< wooden boards along x, scale wide
    grain,   ///< one piece of wood along x
    tiles,   ///< squares of side scale with joints in accent
    slabs,   ///< as tiles, twice as long as wide and shifted row by row
    bricks,  ///< running bond, scale long
    checker, ///< squares of side scale
    rug,     ///< an ornament within scale metres around the origin
    picture, ///< a painted landscape, scale wide, from the origin
    chart,   ///< rings, bars and a checker of fine detail, scale wide, from the origin
    weave,   ///< cloth
    spine,   ///< the back of a book: bands across y
    asphalt, ///< grit, patches, cracks
    road,    ///< asphalt with the markings of the street corner, in world coordinates
    pane,    ///< dark window glass with bars in accent, from the origin, sashes scale wide
    door,    ///< a panelled door with a handle, from the origin, scale wide
    number,  ///< a plate with the number seed, from the origin, scale wide
    leaf,    ///< a leaf with veins, around the origin
    carBody, ///< paint, glass, lamps and seams of a car, in the car's coordinates
    wheel,   ///< tyre and rim around the origin, radius scale
    dial,    ///< a clock's face around the origin, radius scale
    stripes, ///< bars of width scale across x
};

/// Colours are linear reflectances in [0, 1]; emission is radiance that the surface shows by itself.
struct Material {
    Pattern pattern = Pattern::plain;
    glm::dvec3 base{0.5}, accent{0.5};
    double scale = 1.0; ///< metres; see Pattern
    std::uint32_t seed = 0;
    glm::dvec3 emission{0.0};
};

/// Linear reflectance of a colour as pictures write it: 0xRRGGBB in sRGB.
glm::dvec3 reflectance(std::uint32_t rgb);

/// Smooth noise in [0, 1] with features of size 1, band-limited to about two features.
double smoothNoise(const glm::dvec3& p, std::uint32_t seed);

/// Octaves of smoothNoise, each half as large and half as strong; in [0, 1].
double layeredNoise(const glm::dvec3& p, int octaves, std::uint32_t seed);

/// 0 below edge - softness, 1 above edge + softness.
double softStep(double edge, double softness, double value);

/// Reflectance at a place, metres in the surface's own coordinates.
glm::dvec3 reflectanceAt(const Material& material, const glm::dvec3& place);

/// Patterns of made things (windows, doors, cars, ...); reflectanceAt calls it.
glm::dvec3 objectReflectanceAt(const Material& material, const glm::dvec3& place);

} // namespace scene
