#pragma once
// Where the eyes are, frame by frame: a headset, a window or nothing at all. Whoever draws cannot tell which.
//
//   tracking space   metres, right-handed, +Y up, -Z forward, floor at Y = 0: the room of the wearer

#include "scene/view.h"

#include <array>
#include <cstdint>
#include <optional>

#include <volk.h>

namespace xr {

inline constexpr std::size_t kEyes = 2;

/// Depth goes to runtimes as near / z: 1 there and nearer, 0 infinitely far (reversed infinite depth). Metres of the
/// tracking space; nearer than this nobody's eyes meet.
inline constexpr double kDepthNearMetres = 0.01;

/// A place in an image that the eye's picture is to be copied to; image is null where nobody wants one. So is depth, of
/// the format D32_SFLOAT: runtimes draw better in between two frames if they know it.
struct EyeImage {
    VkImage image = VK_NULL_HANDLE;
    std::uint32_t layer = 0;
    VkImage depth = VK_NULL_HANDLE;
    std::uint32_t depthLayer = 0;
};

struct Frame {
    enum class Kind {
        draw, ///< draw the eyes and call end
        skip, ///< nothing is shown now; nothing need be drawn, and end not be called
        end,  ///< it is over: the path has ended, the wearer has left
        lost  ///< the runtime is gone: this source is of no more use, another may come
    };
    Kind kind = Kind::skip;
    double seconds = 0; ///< when the frame is shown, since the first one
    scene::Pose trackingFromHead;
    std::array<scene::View, kEyes> eyes; ///< worldFromEye is trackingFromEye here; left, right
    std::array<EyeImage, kEyes> images{};
    /// For end(): of what was drawn, in the images' first rows and columns; 0: all of them.
    int pictureWidth = 0, pictureHeight = 0;
    bool isTracked = true;     ///< false: the poses are the last ones known, or in part
    bool wasRecentred = false; ///< the wearer moved the tracking space: the poses jump
    /// The display showed something older so many times since the frame before; none where nobody knows.
    std::optional<int> refreshesMissed;
};

class ViewSource {
  public:
    virtual ~ViewSource() = default;
    ViewSource() = default;
    ViewSource(const ViewSource&) = delete;
    ViewSource& operator=(const ViewSource&) = delete;

    /// Pixels of each eye's picture; begin() alone may change it, and only at the desk.
    virtual int width() const = 0;
    virtual int height() const = 0;
    /// How many of a frame's eyes are to be drawn, the first ones.
    virtual int eyes() const { return static_cast<int>(kEyes); }

    /// Waits until it is time to begin the next frame. Throws scene::Failure where going on is impossible.
    virtual Frame begin() = 0;
    /// Hands over the frame begun last; its commands must have been submitted.
    virtual void end(const Frame& frame) = 0;
};

} // namespace xr
