#pragma once
// What a laser saw of surfaces' own brightness: intensity without its fall with range.

#include "scene/scan.h"

namespace scene {

/// Greys as a picture of the scan: the logarithm of intensity over the median of what came back from that range, since
/// some scanners have taken the fall with range out themselves and others have not; a factor of kGreyOctaves octaves
/// from black to white, 128 in the middle. All 128 where the scan has no intensity.
std::vector<Rgb8> evenedReflectance(const ScanWithIntensity& scan);

inline constexpr double kGreyOctaves = 6;

} // namespace scene
