#pragma once
// The photographs of one scan: found how they are turned against it, and given its range. Nyland et al. 1999, sections
// 4.2 and 4.3: 3D photographs.

#include "scene/align/joint_turns.h"
#include "scene/import/straighten.h"
#include "scene/project/dropouts.h"
#include "scene/project/planar_projection.h"

#include <span>
#include <vector>

namespace scene {

/// A scan as its photographs need it.
struct ScanForPhotographs {
    Scan scan;
    std::vector<Rgb8> reflectance; ///< evened (align/reflectance.h), one for each point
    ScanTraits traits;
    PlanarOptions planar; ///< with the noise that the scan shows
};

ScanForPhotographs forPhotographs(ScanWithIntensity scan);

/// A photograph as it lies on its scan: without distortion, no finer than the scan can fill.
struct PhotographForScan {
    StraightPicture straight;
    Camera camera;
    Pose scannerFromGiven;
};

/// A photograph's pixels are no finer than half of the scan's spacing: range between samples is interpolated, so that
/// finer pixels would cost four times as much for each halving and add colour alone.
PhotographForScan forScan(const Image<Rgb8>& picture, const CameraFile& lens, const Pose& scannerFromGiven,
                          const ScanForPhotographs& scan);

/// How all photographs of a scan are turned. They are laid on it one after another, and of each only what its
/// neighbours ask for is kept (align/small_photograph.h). The scan's own colours are not looked at. The same on any
/// number of threads.
class PhotographsOnScan {
  public:
    /// Lends the scan.
    explicit PhotographsOnScan(ScanForPhotographs& scan);

    void add(const PhotographForScan& photograph);

    /// One for each that was added: the scan and its neighbours together (align/joint_turns.h).
    std::vector<ColourFit> fits() const;

  private:
    ScanForPhotographs& scan_;
    ColourToRangeOptions options_;
    std::vector<ColourFit> alone_;
    std::vector<PhotographOnScan> small_;
};

/// The same of photographs that are all in memory.
std::vector<ColourFit> layOnScan(ScanForPhotographs& scan, std::span<const PhotographForScan> photographs);

/// The photograph with the range of the scan, in the scanner's frame: worldFromCamera is scannerFromCamera. Where the
/// photograph's lens does not reach there is no surface.
DepthImage withRange(const ScanForPhotographs& scan, const PhotographForScan& photograph, const Pose& scannerFromCamera,
                     const DropoutOptions& dropouts = {});

} // namespace scene
