#pragma once
// How far a drawn picture is from what a camera took from the same place.

#include "render/readback.h"
#include "scene/depth_image.h"

namespace app {

/// What a camera took. Depth is metres along z, infinite for sky, 0 where it is not known; without any, empty.
struct Truth {
    scene::Image<scene::Rgb8> colour;
    scene::Image<float> depthMetres;
};

/// Guesses of range, and surface that was closed or moved (scene::isClosed), are not truth.
Truth truthOf(const scene::DepthImage& image);

/// A mean square error of 0 counts as this many decibels, so that means over pictures stay finite.
inline constexpr double kMostDecibels = 100;

/// Decibels over the pixels that are not 0 in `where`; 0 if there are none.
double psnrOf(const scene::Image<scene::Rgb8>& a, const scene::Image<scene::Rgb8>& b,
              const scene::Image<std::uint8_t>& where);

/// The mean structural similarity of the luma over the pixels that are not 0 in `where`: Wang, Bovik, Sheikh and
/// Simoncelli, "Image quality assessment: from error visibility to structural similarity", 2004, eq. 13, with its
/// constants (11 x 11 Gaussian window of 1.5 pixels, K1 = 0.01, K2 = 0.03, L = 255). What is not in `where`, or
/// outside the picture, has no share in the windows either: a hole does not spoil its neighbours. 0 if there are none.
double ssimOf(const scene::Image<scene::Rgb8>& a, const scene::Image<scene::Rgb8>& b,
              const scene::Image<std::uint8_t>& where);

struct PictureError {
    double psnrCovered = 0;  ///< dB over pixels of class seen or filled
    double psnrSeen = 0;     ///< dB over pixels of class seen
    double psnrAll = 0;      ///< dB over all pixels, holes as they are drawn
    double ssim = 0;         ///< over pixels of class seen or filled
    double coveredShare = 0; ///< of all pixels
    /// Of the pixels where the camera measured a surface, those that are neither seen nor filled; of all pixels where
    /// no depth is known at all.
    double holeShare = 0;
    double unseenShare = 0; ///< of those same pixels, those that are told to be unseen: part of the holes
    /// Of the pixels where the camera measured depth, those where something stands in front of all that it measured
    /// about there (3 x 3 pixels, so that an edge may be off by one), by more than kSolidTolerance of the distance.
    /// Not a number where no depth is known.
    double wronglySolidShare = 0;
};
inline constexpr double kSolidTolerance = 0.05;

/// Both of one size.
PictureError errorOf(const render::EyeImage& drawn, const Truth& truth);

} // namespace app
