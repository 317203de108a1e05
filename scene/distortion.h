#pragma once
// How a lens leaves the pinhole.

namespace scene {

/// Radial and tangential distortion as OpenCV has it (k1 k2 p1 p2 k3); all zero: the image is a pinhole's.
struct Distortion {
    double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;
    friend bool operator==(const Distortion&, const Distortion&) = default;
};

} // namespace scene
