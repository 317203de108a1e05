#pragma once
// Images -> coverage: the tree is grown from the top, image by image; each cell is projected into the image, and only
// cells that an image saw in part are divided. Nyland et al. 1999, section 4.4, asks which volumes no ray pierced; here
// no ray is marched.
//
// Two passes over the images: the first sees what it can in large cells, so that the second, which follows the ends of
// seen space down to the samples' own spacing, finds little left to divide. Whether that would take too many nodes
// is asked of a sixteenth of space before, in a pass of its own: what is too large by three standard errors is not
// grown.

#include "scene/coverage.h"
#include "scene/image_store.h"

#include <cstdint>
#include <functional>

namespace scene {

struct CoverOptions {
    double cellsPerSample = 1;  ///< smallest cells, where seen space ends in the open: so many to a sample's spacing
    double surfaceSamples = 2;  ///< largest cells where it ends at a surface: so many samples wide
    double nearestMetres = 0.5; ///< nearer to a camera, cells do not become smaller
    float tolerance = 0.002f;   ///< relative; how much farther than its sample a surface may be
    /// About a camera space is empty so far, or to its nearest sample, whatever its rays met: there it stood.
    double bodyMetres = 0.2;
    /// What would take more, or twice as many on the way, is kept coarser: half as fine, until it fits.
    std::size_t maxNodes = 2 << 20;
};

struct CoverFigures {
    std::uint64_t nodes = 0;
    double cellsPerSample = 0; ///< as it was in the end
    double finestMetres = 0;   ///< edge of the smallest cell
    double unseenCubicMetres = 0, surfaceCubicMetres = 0,
           emptyCubicMetres = 0; ///< within the box about all samples and cameras
};

/// Bytes that trees take while they grow, at most.
std::uint64_t bytesToCover(const CoverOptions& options);

/// Coverage of the cube about all samples and cameras, from images whose skins are marked (refine/skins.h). advance is
/// called for each image, thrice. The same tree on any number of threads. No image: a cube of a metre that
/// nobody observed, and no figures.
Coverage cover(ImageStore& images, const CoverOptions& options, CoverFigures& figures,
               const std::function<void()>& advance = {});

} // namespace scene
