#pragma once
// A laser scanner in a world that is known: what a real one would have recorded there, with its noise and its faults.
//
// Mirror and pan unit run at their own speeds and samples are taken at a third, so that no two columns sample the same
// elevations. While a sample is taken the mirror goes on: its range is the mean over what the beam swept, weighed by
// what came back, and floats in space where that is a silhouette (Nyland et al. 1999, section 4.3). What comes back
// falls as the cosine at the surface and the square of the range (Lambert); noise rises as that falls, and below a
// threshold nothing is recorded.

#include "scene/capture/light.h"
#include "scene/capture/tracer.h"
#include "scene/capture/write_scans.h"
#include "scene/scan.h"
#include "scene/scanner_model.h"
#include "scene/synthetic.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace scene {

/// What a beam meets first.
struct Echo {
    double rangeMetres = 0; ///< from the ray's origin
    double cosine = 1;      ///< between the ray and the surface's normal
    double reflectance = 0; ///< of the surface, in [0, 1]
};

/// Anything that can be scanned. Directions are unit vectors. Functions must be good for any number of threads.
struct ScannedWorld {
    std::function<std::optional<Echo>(const glm::dvec3& origin, const glm::dvec3& direction)> echo;
    std::function<Rgb8(const glm::dvec3& origin, const glm::dvec3& direction)> colour; ///< empty: none is recorded
};

/// They lend what they are given.
ScannedWorld worldOf(const SyntheticScene& scene, bool withColour);
ScannedWorld worldOf(const PolygonTracer& tracer, const SurfaceLight& light, bool withColour);

struct ScannerOptions {
    ScannerConstants<double> constants; ///< the true ones
    double samplesPerSecond = 16000;    ///< the paper's scanner gives 16,000 to 25,000
    double mirrorTurnsPerSecond = 4;
    double panStepsPerSecond = 14;
    double panDegrees = 180; ///< as the true constants have it; both halves of the mirror's turn see: 180 is all round
    double lowestRadians = -1.0471975511965976; ///< elevation; below stands the tripod
    double farthestMetres = 15;
    double noiseMetres = 0.005;     ///< standard deviation of range where as much comes back as from kReferenceMetres
    double beamRadians = 0.0006;    ///< half of the beam's divergence
    int apertureRays = 7;           ///< over the beam and its sweep; 1: a point sample in the middle
    double leastIntensity = 0.0008; ///< what comes back from a white surface square to the beam at 1 m is 1; less than
                                    ///< about this is lost
    std::uint32_t seed = 1;
};

/// Where half of the light that falls on a surface square to the beam comes back, noise is noiseMetres at this range.
inline constexpr double kReferenceMetres = 3.0;

/// Bounds of noise, in units of noiseMetres: electronics on one side, what is recorded at all on the other.
inline constexpr double kLeastNoise = 0.5, kMostNoise = 4.0;

/// Speeds for a scan of about as many samples a degree both ways, at the same samples a second. The ratios are none of
/// whole numbers.
void setDensity(ScannerOptions& options, double samplesPerDegree);

/// One record: what a scanner streams to disk.
struct RawSample {
    std::uint16_t encoder = 0; ///< position of the mirror, 0 to kEncoderPositions - 1
    std::int32_t panStep = 0;
    float rangeMetres = 0; ///< from the rangefinder's zero; 0: nothing came back
    float intensity = 0;   ///< see ScannerOptions::leastIntensity
    Rgb8 colour;
    friend bool operator==(const RawSample&, const RawSample&) = default;
};

struct RawScan {
    std::vector<RawSample> samples; ///< in the order of time
    bool hasColour = false;
};

/// Records of a scan from a place whose +Z is up. The same bytes on any number of threads.
RawScan simulateRawScan(const ScannedWorld& world, const Pose& worldFromScanner, const ScannerOptions& options);

/// The records as points, as the constants that one believes in have it, with the intensity of each. A column is half a
/// turn of the mirror, first those before the scanner, then those behind it; rows are counted from the zenith. Name
/// and pose are left to the caller.
ScanWithIntensity readRawScan(const RawScan& raw, const ScannerConstants<double>& believed);

} // namespace scene
