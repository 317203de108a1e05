#pragma once
// The geometry of a panning laser scanner: a mirror that spins about a level shaft, on a pan unit. Nyland et al., "The
// impact of dense range data on computer graphics", 1999, section 3.2.
//
//        pan axis, +Z                 The rangefinder looks along the shaft at the mirror, whose normal leans by the
//            |      / mirror          mirror angle from the shaft. At 45 degrees the beam leaves square to the shaft
//   laser ==>|-----/----- shaft       and sweeps a plane as the mirror spins; at any other angle it sweeps a cone.
//            |    / |                 The place where the beam meets the mirror stands on the pan axis, so that all
//           pan    beam               rays start at one point: the origin of the scanner's frame.
//
// Frame of the scanner: metres, right-handed, +Z up; at pan 0 the shaft points from the laser to the mirror along +Y,
// and the beam of the encoder's horizon leaves along +X. One and the same function serves the simulation (with the true
// constants), the reading of raw records (with those believed) and, for it takes any scalar that automatic
// differentiation has, their calibration.

#include <array>
#include <cmath>
#include <numbers>
#include <optional>

namespace scene {

inline constexpr int kEncoderPositions = 4096; ///< of one turn of the mirror

/// What differs from one instrument to another. The defaults are what its makers say; the paper found 14,039 steps and
/// 44.8 degrees.
template <class T>
struct ScannerConstants {
    T panStepsPerHalfTurn{14000.0};
    T mirrorRadians{std::numbers::pi / 4}; ///< between the mirror's normal and the shaft
    T horizonPosition{0.0};                ///< of the encoder when the beam leaves level, in [0, kEncoderPositions)
    T mirrorMetres{0.12};                  ///< from the rangefinder's zero to the mirror: part of every range
};

/// What a scan's points were computed with, and what its records should have been read with.
struct ScannerReading {
    ScannerConstants<double> believed, constants;
};

/// Where the beam goes, a unit vector in the scanner's frame. encoder in positions and pan in steps, neither needs to
/// be whole: a record that says 17 stands for 17 to 18, on average 17.5.
template <class T>
std::array<T, 3> beamDirection(const ScannerConstants<T>& constants, const T& encoder, const T& pan) {
    using std::cos;
    using std::sin;
    const T turn = (encoder - constants.horizonPosition) * (2.0 * std::numbers::pi / kEncoderPositions);
    const T azimuth = pan * std::numbers::pi / constants.panStepsPerHalfTurn;
    // The reflection of the shaft's direction at the mirror: -cos(2 m) along the shaft, sin(2 m) away from it.
    const T along = -cos(constants.mirrorRadians * 2.0), away = sin(constants.mirrorRadians * 2.0);
    const T level = away * cos(turn);
    return {level * cos(azimuth) - along * sin(azimuth), level * sin(azimuth) + along * cos(azimuth), away * sin(turn)};
}

/// The place that a record speaks of, in the scanner's frame; range in metres as the rangefinder gives it, from its own
/// zero by way of the mirror.
template <class T>
std::array<T, 3> scannedPoint(const ScannerConstants<T>& constants, const T& encoder, const T& pan, const T& range) {
    const std::array<T, 3> beam = beamDirection(constants, encoder, pan);
    const T beyond = range - constants.mirrorMetres;
    return {beam[0] * beyond, beam[1] * beyond, beam[2] * beyond};
}

/// Which half of a turn of the mirror a beam belongs to: above the pan unit's front, or behind it. Every direction can
/// be reached by both, at pans that are half a turn apart.
enum class ScannerFace { front, back };

/// A record as the instrument made it, neither number whole: the middle of what it stands for.
struct ScannerRecord {
    double encoder = 0, pan = 0, rangeMetres = 0;
};

/// The record behind a place that was computed with these constants: scannedPoint turned round. pan is in (-half a
/// turn, half a turn] of steps; whole turns are the caller's to add. Nothing where the cone of the beam never passes.
inline std::optional<ScannerRecord> recordOf(const ScannerConstants<double>& constants, const std::array<double, 3>& p,
                                             ScannerFace face) {
    const double beyond = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    const double along = -std::cos(2 * constants.mirrorRadians), away = std::sin(2 * constants.mirrorRadians);
    if (!(beyond > 0) || !(std::abs(p[2] / beyond) < away)) return std::nullopt;
    const double sine = p[2] / beyond / away, cosine = std::sqrt(1 - sine * sine);
    const double turn = std::atan2(sine, face == ScannerFace::front ? cosine : -cosine);
    const double level = away * (face == ScannerFace::front ? cosine : -cosine);
    const double azimuth = std::remainder(std::atan2(p[1], p[0]) - std::atan2(along, level), 2 * std::numbers::pi);
    return ScannerRecord{constants.horizonPosition + turn * kEncoderPositions / (2 * std::numbers::pi),
                         azimuth * constants.panStepsPerHalfTurn / std::numbers::pi, beyond + constants.mirrorMetres};
}

} // namespace scene
