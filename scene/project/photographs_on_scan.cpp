#include "scene/project/photographs_on_scan.h"

#include "scene/align/reflectance.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace scene {

namespace {

constexpr double kLeastPixelSpacings = 0.5;
constexpr int kMostPixelsAcross = 4096;
/// Edges of a scan lie anywhere between two samples; a turn whose deviation is this share of their spacing is known as
/// well as the scan can tell.
constexpr double kMostDeviationSpacings = 0.275;
constexpr double kLeastMostDeviationRadians = 5e-4; ///< 0.03 degrees: what is asked of the densest scans
/// What all edges of a scan together leave open, and with the densest scans lenses that are not quite known.
constexpr double kLeastDeviationSpacings = 0.055, kLeastDeviationRadians = 7e-5;

/// The scan has its reflectance for colours while this lives.
class InReflectance {
  public:
    explicit InReflectance(ScanForPhotographs& scan) : scan_(scan) { swap(); }
    ~InReflectance() { swap(); }
    InReflectance(const InReflectance&) = delete;
    InReflectance& operator=(const InReflectance&) = delete;

  private:
    void swap() {
        std::swap(scan_.scan.colours, scan_.reflectance);
        std::swap(scan_.scan.isColoured, isColoured_); // all have a reflectance
    }
    ScanForPhotographs& scan_;
    std::vector<bool> isColoured_;
};

} // namespace

ScanForPhotographs forPhotographs(ScanWithIntensity from) {
    ScanForPhotographs scan;
    scan.reflectance = evenedReflectance(from);
    scan.scan = std::move(from.scan);
    scan.traits = traitsOf(scan.scan);
    const double noise = rangeNoiseOf(scan.scan);
    if (noise > 0) scan.planar.noiseMetres = noise;
    return scan;
}

PhotographForScan forScan(const Image<Rgb8>& picture, const CameraFile& lens, const Pose& scannerFromGiven,
                          const ScanForPhotographs& scan) {
    const Camera& camera = lens.camera;
    const double least = std::max(camera.width, camera.height) / static_cast<double>(kMostPixelsAcross);
    const double scale =
        std::max({kLeastPixelSpacings * scan.traits.spacingRadians() * std::min(camera.fx, camera.fy), least, 1.0});
    const auto sizeOf = [&](int pixels) { return std::max(1, static_cast<int>(std::lround(pixels / scale))); };
    const Camera pinhole = resized(camera, sizeOf(camera.width), sizeOf(camera.height));
    return {straightened(picture, lens, pinhole), pinhole, scannerFromGiven};
}

PhotographsOnScan::PhotographsOnScan(ScanForPhotographs& scan) : scan_(scan) {
    const double spacing = scan.traits.spacingRadians();
    options_.leastDeviationRadians = std::hypot(kLeastDeviationRadians, kLeastDeviationSpacings * spacing);
    options_.mostDeviationRadians = std::max(kLeastMostDeviationRadians, kMostDeviationSpacings * spacing);
}

void PhotographsOnScan::add(const PhotographForScan& photograph) {
    const Camera wide = widened(photograph.camera, options_.reachRadians, 1 / photograph.camera.fx);
    DepthImage seen;
    {
        const InReflectance grey(scan_);
        seen = projectToCamera(scan_.scan, scan_.traits, inverse(photograph.scannerFromGiven), wide, scan_.planar);
    }
    fillDropouts(seen);
    const ColourFit fit = findTurn(seen, photograph.straight.colour, photograph.camera, options_);
    small_.push_back({smallPhotograph(photograph.straight.colour, photograph.camera), photograph.scannerFromGiven});
    alone_.push_back(fit);
}

std::vector<ColourFit> PhotographsOnScan::fits() const {
    std::vector<ColourFit> fits = alone_;
    joinTurns(small_, fits, options_);
    return fits;
}

std::vector<ColourFit> layOnScan(ScanForPhotographs& scan, std::span<const PhotographForScan> photographs) {
    PhotographsOnScan onScan(scan);
    for (const PhotographForScan& photograph : photographs)
        onScan.add(photograph);
    return onScan.fits();
}

DepthImage withRange(const ScanForPhotographs& scan, const PhotographForScan& photograph, const Pose& scannerFromCamera,
                     const DropoutOptions& dropouts) {
    DepthImage image =
        projectToCamera(scan.scan, scan.traits, inverse(scannerFromCamera), photograph.camera, scan.planar);
    image.worldFromCamera = scannerFromCamera;
    image.colour = photograph.straight.colour;
    for (std::uint8_t& flags : image.flags.pixels())
        flags = static_cast<std::uint8_t>(flags & ~kNoColour);
    fillDropouts(image, dropouts);
    for (std::size_t i = 0; i < image.flags.size(); ++i)
        if (!photograph.straight.isSeen.pixels()[i])
            image.flags.pixels()[i] = kNoSurface | kNoColour, image.disparity.pixels()[i] = 0;
    return image;
}

} // namespace scene
