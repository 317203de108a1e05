#pragma once
// What a perfect camera with depth sees of a polygon scene.
//
// Antialiased as reference images for warping must be: by further rays where neighbours differ in colour but not in
// depth, and there alone. A colour that was mixed over a silhouette would be wrong on either surface once it is warped.

#include "scene/capture/light.h"
#include "scene/depth_image.h"
#include "scene/view.h"

namespace scene {

struct PolygonViewOptions {
    int raysAcross = 4; ///< an antialiased pixel is the mean over raysAcross x raysAcross rays; 1: none is
    /// Of 255: neighbours whose colours differ by more are antialiased. Of a view of Sponza a sixth of the pixels
    /// then are, which is 42.4 dB from the mean of 8 x 8 rays at every pixel; 6 costs twice the time for 45.2 dB, and
    /// without antialiasing it is 36.7 dB.
    int colourStep = 12;
    double sameDepth = 0.005; ///< relative; what is farther from a surface's plane than this is another surface
};

/// disparity and flags belong to the ray through the pixel's centre, with the intersection computed in double
/// precision. Where it meets nothing: the sky's colour, disparity 0 and kNoSurface. Colours are sRGB and the same from
/// everywhere, but for how much of a texture a pixel covers. On all cores; the bytes do not depend on how many there
/// are.
DepthImage renderPolygons(const PolygonTracer& tracer, const SurfaceLight& light, const View& view,
                          const PolygonViewOptions& options = {});

} // namespace scene
