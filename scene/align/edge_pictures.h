#pragma once
// Edges of a photograph and of what a scan saw, as pictures that can be laid on each other. Nyland et al. 1999, section
// 4.2: the two are lit too differently to be compared themselves, so their edges are.
//
// What we changed: an edge has a direction, too. A pixel holds (e, e cos 2a, e sin 2a): strength e in [0, 1), and the
// angle a of the edge's normal against the image's x axis, doubled so that bright to dark and dark to bright are the
// same. The product of two pixels is then e e' (1 + cos 2(a - a')): edges that cross each other at right angles do not
// count.

#include "scene/depth_image.h"

#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace scene {

using EdgeImage = Image<glm::vec3>;

/// Edges that stand out of texture and of the sensor's noise: after variable conductance diffusion (Perona and Malik,
/// "Scale-space and edge detection using anisotropic diffusion", 1990; Yoo and Coggins 1993), which smooths within
/// surfaces and not across their edges. Strengths are by how many times an edge is as strong as the picture's usual
/// slopes.
EdgeImage photographEdges(const Image<Rgb8>& photograph);

/// Its texture, too, down to the sensor's noise: for other photographs from the same place, which see the same.
EdgeImage textureEdges(const Image<Rgb8>& photograph);

/// Silhouettes and creases of range, where disparity has a second difference (a plane has none), and edges of
/// reflectance (the colours of scan, grey). What gave no range counts as infinitely far.
EdgeImage scanEdges(const DepthImage& scan);

/// The same without those beside which the scan has no range: a sample that a part of the beam came back from is one as
/// well, so that surfaces reach beyond themselves there, by what nobody knows.
EdgeImage withoutOpenRims(const EdgeImage& edges, const DepthImage& scan);

/// The picture blurred by a Gaussian less what a much broader one leaves, in units of its own standard deviation; one
/// pixel for every so many.
struct EdgeLevel {
    Image<glm::vec4> edges; ///< the fourth is 0: a pixel is read by one load, which searches for turns spend most on
    int pixelsPerPixel = 1;
    double sigmaPixels = 0; ///< of the full picture
};
EdgeLevel blurredEdges(const EdgeImage& edges, double sigmaPixels);

/// An edge's place in pixels, and its direction.
struct EdgePoint {
    float x = 0, y = 0;
    float strength = 0;
    float cosine = 1, sine = 0; ///< of twice the angle of its normal
};

/// Crests of edges, to a fraction of a pixel; the strongest of each part of the picture, so that clutter in one does
/// not outvote the others. Sorted by part, row by row.
std::vector<EdgePoint> edgePoints(const EdgeImage& edges, int columns, int rows, int mostInPart);

/// For eyes: strength as grey, direction as hue.
Image<Rgb8> pictureOfEdges(const EdgeImage& edges);

} // namespace scene
