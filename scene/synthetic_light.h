#pragma once
// Diffuse light in synthetic scenes: what falls on each surface is gathered once, then a point's colour is
// its own, the same from every view. Sunlight alone is looked up when a point is shaded, so that shadows have
// sharp edges.

#include "scene/image.h"
#include "scene/synthetic_tracer.h"

namespace scene {

/// Fills all light maps of the model: lamps, sky, and light from lit surfaces after two reflections.
void lightModel(SyntheticModel& model, const SyntheticTracer& tracer);

/// Radiance that a surface point of a lit model shows. hit: the ray's that found the point.
glm::dvec3 radianceOf(const SyntheticModel& model, const SyntheticTracer& tracer, const RayHit& hit,
                      const SurfacePoint& point);

/// Radiance of the sky in a direction (any length): horizon to zenith, with clouds.
glm::dvec3 skyRadiance(const Sky& sky, const glm::dvec3& direction);

/// Radiance as a picture shows it: exposed, rolled off before white, still linear in [0, 1).
glm::dvec3 exposed(const glm::dvec3& radiance, double exposure);

} // namespace scene
