#pragma once
// How well a depth image samples what it sees: samples per square metre of surface, from range and viewing angle.

#include "scene/depth_image.h"

namespace scene {

/// For each sample, samples per square metre on its surface: fx fy |r| d^2 cos(angle between the surface's normal and
/// the ray), r the ray at depth 1. The normal comes from the slope of disparity, which is constant on a plane: d = a X
/// + b Y + c over X/Z and Y/Z means the plane a x + b y + c z = 1. 0 where there is no surface. This is the quality of
/// Nyland et al. 1999, section 4.6 (range and obliqueness in one number).
Image<float> computeDensity(const DepthImage& image);

} // namespace scene
