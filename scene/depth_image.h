#pragma once
// The depth image: the scanner's or camera's own samples (x, y, disparity) with colour, flags and the camera that took
// them. Nyland, McAllister, Popescu, McCue, Lastra: "Interactive exploration of acquired 3D data", 1999, sections 4.3
// to 4.5.

#include "scene/camera.h"
#include "scene/image.h"
#include "scene/pose.h"

#include <cstdint>
#include <string>

namespace scene {

/// The flag byte of a sample. The mesh of an image has two triangles in each square of four samples; the sample at its
/// top left carries their skin bits:
///
///     (x, y) ---- (x+1, y)        upper: (x, y), (x+1, y), (x, y+1)
///        |   upper /  |           lower: (x+1, y), (x+1, y+1), (x, y+1)
///        |   /  lower |
///     (x, y+1) -- (x+1, y+1)
enum SampleFlag : std::uint8_t {
    kNoSurface = 1 << 0,    ///< no valid range: the sample is not there
    kSkinUpper = 1 << 1,    ///< the upper triangle bridges a silhouette: a false surface
    kSkinLower = 1 << 2,    ///< the lower triangle does
    kFloating = 1 << 3,     ///< other images saw through this sample: it hangs in empty space (see isOpenSky)
    kRedundant = 1 << 4,    ///< another image keeps this piece of surface
    kInterpolated = 1 << 5, ///< range was not measured here: it follows from the samples about
    kNoColour = 1 << 6,     ///< range alone was taken here; colour is the intensity in grey, or mid-grey
    kDirectional =
        1 << 7, ///< another image keeps this piece of surface, this sample is kept for how it looks from here
};

/// All three images have the camera's size. disparity is 0 where there is no surface or it is infinitely far; where
/// range is a guess (isGuess) it is the guess.
struct DepthImage {
    std::string name; ///< unique within a scene; becomes a file name
    Camera camera;
    Pose worldFromCamera;
    Image<Rgb8> colour;
    Image<float> disparity; ///< 1 / z in 1/m
    Image<std::uint8_t> flags;
};

inline bool isSurface(std::uint8_t flags) {
    return (flags & (kNoSurface | kFloating)) == 0;
}

/// No range was measured here (kNoSurface), but the surroundings suggest one (kInterpolated). It proves nothing to
/// other images; what is drawn of it is of class filled.
inline bool isGuess(std::uint8_t flags) {
    return (flags & (kNoSurface | kFloating | kInterpolated)) == (kNoSurface | kInterpolated);
}

/// The ray of this sample met nothing at all (scene/project/open_sky.h): space along it is open without end. kFloating
/// says so of samples that are not there.
inline constexpr std::uint8_t kOpenSky = kNoSurface | kFloating;
inline bool isOpenSky(std::uint8_t flags) {
    return (flags & kOpenSky) == kOpenSky;
}

/// Surface that was laid over a gap of range, moved to another side of a silhouette, or guessed and confirmed. What is
/// drawn of it is of class filled.
inline bool isClosed(std::uint8_t flags) {
    return isSurface(flags) && (flags & kInterpolated) != 0;
}

inline bool isDrawable(std::uint8_t flags) {
    return isSurface(flags) || isGuess(flags);
}

/// Bytes that the three pictures of such an image take.
inline std::size_t bytesOf(const Camera& camera) {
    return static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height) *
           (sizeof(Rgb8) + sizeof(float) + sizeof(std::uint8_t));
}

} // namespace scene
