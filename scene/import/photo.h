#pragma once
// Photographs with registered depth: picture files -> depth images.

#include "scene/depth_image.h"
#include "scene/import/capture.h"

namespace scene {

/// Reads colour (8 bit, any layout OpenCV knows) and depth (16 bit steps or 32 bit floats, both
/// in depthUnitMetres; along z; 0, negative, NaN and infinite mean no return) and removes lens distortion. Depth of a
/// lower resolution is brought to the colour's, never across a silhouette.
/// Throws Failure: missing or unreadable file, sizes that do not fit.
DepthImage readPhoto(const PhotoSource& source);

/// Takes range back, guessed from what is beside, from where the picture shows nothing: beyond its borders once its
/// lens is straightened, and where that would fold it over itself.
void keepWithinPicture(DepthImage& image, const PhotoSource& source);

} // namespace scene
