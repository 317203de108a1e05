#pragma once
// Every knob that trades speed for accuracy while drawing.

#include "render/shaders/shared/hole_fill.h"
#include "scene/blend.h"
#include "scene/preference.h"

namespace render {

enum class Warp {
    points,   ///< each sample a square of pixels
    mesh,     ///< two triangles in each square of four samples
    adaptive, ///< a textured facet wherever samples lie in a plane (scene/facets.h), squares elsewhere
    splats    ///< each sample a circle whose depth falls off from its centre
};

inline constexpr double kMinResolutionScale = 0.1, kMaxResolutionScale = 4;

struct Quality {
    Warp warp = Warp::points;

    /// Points: the widest square of pixels that stands for one sample. 1 is fastest, exactly one pixel per
    /// sample, and leaves holes wherever the eye is nearer than the camera was.
    int maxFootprint = 4;

    /// Points: width of the square over what closes the holes between samples of one disparity. Above 1 closes the
    /// holes of surfaces that the eye sees more squarely than the camera did, and coarsens silhouettes.
    double footprintScale = 1.0;

    /// Splats: greatest radius in pixels, and radius over what closes the holes between samples.
    int maxSplat = 4;
    double splatScale = 1.0;

    /// Points and splats: a pixel is made of the four samples that its centre lies between, by where they stand
    /// (shaders/shared/between_samples.h). Off unless asked for, as the preference is: then it has the colour of its
    /// own.
    bool interpolatesSamples = false;

    /// Points and splats: where a tile's samples are seen farther apart than maxFootprint, or 2 maxSplat, or may be
    /// since its surface slopes (points: three pixels are enough), the mesh's squares are drawn, and of the samples
    /// only those that are in none. Else gaps open in walls right before the eye and in what was scanned at a glance,
    /// and unseen space is shown through them.
    bool drawsSquaresNear = false;

    /// The mesh, adaptive or not: samples that are in none of its squares are drawn as points.
    bool drawsLone = false;

    /// Which of several samples of one surface is shown; directional tiles are drawn only with it. As it stands here:
    /// the nearest in plain z order.
    scene::PreferenceOptions preference{.nearBaseline = 0};

    /// All but the mesh: coarser samples (scene/pyramid.h) stand for finer ones where they are seen no wider than
    /// this, pixels. 0: all that was sampled is drawn.
    double samplePixels = 0;

    /// The same for base samples of images that were taken from far away, which are seen only where nobody stood near.
    double farSamplePixels = 0;

    /// Images of which nothing can be seen past the unseen, where that is shown, are left out (scene/open_ways.h); and
    /// where the processor draws, tiles behind what is drawn already. Pictures are the same, but for what hidden
    /// samples would add: through gaps of a pixel within a surface, where such are filled anyway, and to the colours of
    /// a surface that they stand a little behind, where samples are blended or interpolated. It pays where much is
    /// hidden.
    /// Where a scene is larger than memory, what the unseen hides comes last besides.
    bool leavesOutHidden = true;

    /// Points and splats of two eyes: one pass reads each sample once and warps it to both (render/warp/stereo_pass.h).
    /// Pictures are the same to the byte; docs/performance.md says where it is faster.
    bool isOnePass = false;

    /// Only images of the positions about the walker are drawn (scene/plan/walk_cells.h), in a scene that can be walked
    /// so: a frame's cost then does not grow with the number of positions.
    bool walksByCells = true;

    /// Where no image ever looked is shown as unseen, in a scene that knows (GpuCoverage). False: as emptiness.
    bool showUnseen = true;

    /// Whether what the unseen hides is left out of frames, and comes last where a scene is larger than memory.
    bool leavesOutBehindUnseen() const { return showUnseen && leavesOutHidden; }

    /// What was not measured is told by a tint: filled pixels orange, those where nothing was seen violet.
    bool marksUnmeasured = false;

    /// An eye that stands in unseen space itself looks through as much of it, metres of depth; 0: through none.
    double unseenPocketMetres = 1;

    /// Pixels that no sample reached, between two ends of one surface, are filled from as far as the radius. Off unless
    /// asked for, as the preference is.
    HoleFill holes{.radius = 0, .sameSurface = 0.03f, .sameColour = 64, .pinholeDepth = 0.05f};

    /// Pixels along a side of what the scene is warped into, over those of the eye's picture. Below 1 it is faster and
    /// softer; above 1 each pixel is the mean of several (supersampling), which smooths edges.
    double resolutionScale = 1.0;

    /// Ordinary polygons: samples of each pixel (multisampling): 1, 2, 4 or 8, as many of them as the device has. Their
    /// edges are then mixed with what stands behind by how much of a pixel they cover.
    int edgeSamples = 1;

    /// A second pass shows at every pixel the mean of all samples that stand at the surface `warp` found: the best
    /// pictures, for several times the time.
    bool isBlended = false;
    scene::BlendOptions blend{}; ///< of that pass

    friend bool operator==(const Quality&, const Quality&) = default;
};

/// How wide coarser samples may be seen, in pixels of what is warped; 0: none stand for finer ones. The mesh is all of
/// what was sampled.
inline double detailPixelsOf(const Quality& quality) {
    return quality.warp == Warp::mesh ? 0 : quality.samplePixels;
}

} // namespace render
