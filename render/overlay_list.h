#pragma once
// An overlay as one eye sees it: strokes on the screen, sorted into bins. On the processor, in double precision
// relative to the eye; what is left for the device is to colour pixels.

#include "render/overlay.h"
#include "render/shaders/shared/overlay_draw.h"
#include "scene/view.h"

#include <cstdint>
#include <vector>

namespace render {

/// Nothing of an overlay is drawn nearer to the eye than this.
inline constexpr double kOverlayNearMetres = 0.01;

/// What an eye is shown of overlays in one frame at most.
inline constexpr std::size_t kMaxStrokes = std::size_t{1} << 14, kMaxEntries = std::size_t{1} << 18;

struct OverlayList {
    std::vector<OverlayStroke> strokes;
    std::vector<std::uint32_t> entries; ///< strokes, bin by bin, farthest first
    std::vector<OverlayBin> bins;       ///< those with anything to do
    OverlayConstants constants{};
    std::uint32_t dropped = 0; ///< segments and letters' strokes that do not fit, and what has no place (NaN)

    struct Touch { ///< of a bin by a stroke
        std::uint32_t bin, stroke;
        float disparity; ///< of the stroke near the bin's middle
    };
    std::vector<Touch> touches; ///< memory that is used again
    std::vector<std::uint32_t> firstOfBin;
};

/// Bins across a picture of that width, or down one of that height.
inline std::uint32_t binsAlong(int pixels) {
    return (static_cast<std::uint32_t>(pixels) + kBinSide - 1) / kBinSide;
}

/// Makes the list anew. scale: the picture's pixels over those in which the overlay's widths and heights are given.
void listOverlay(const Overlay& overlay, const scene::View& eye, OverlayList& list, double scale = 1);

} // namespace render
