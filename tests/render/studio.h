#pragma once
// A scene, and every way to draw it: for tests of what all warps must do.

#include "tests/render/test_device.h"
#include "tests/render/test_scenes.h"

#include "render/post/unseen.h"
#include "scene/warp.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace render {

/// One way to draw, with a name for failures.
struct Way {
    std::string name;
    Quality quality;
};

/// With near tiles preferred.
Quality qualityOf(Warp warp);

/// Each warp; the blended one over two of them; holes filled, coarser levels and another resolution where they matter.
std::vector<Way> ways();

inline bool isOfSurfaces(Warp warp) {
    return warp == Warp::mesh || warp == Warp::adaptive;
}

/// Six faces around a place in the room: something is seen wherever an eye near it looks.
CutScene roomAllAround();

CutScene movedBy(CutScene scene, const glm::dvec3& offset);

/// A scene on the device, and an eye of any size on it.
class Studio {
  public:
    explicit Studio(CutScene cut, const scene::Coverage* coverage = nullptr, const Device& device = testDevice());

    EyeImage draw(const scene::View& view, const Quality& quality, const Overlay* overlay = nullptr);

    /// The same by the warps on the processor; nothing where they have no such way.
    std::optional<scene::EyeImage> drawByProcessor(const scene::View& view, const Quality& quality) const;

  private:
    const Device& device_;
    CutScene cut_;
    GpuScene scene_;
    std::optional<GpuCoverage> coverage_;
    std::optional<Renderer> renderer_;
    int width_ = 0, height_ = 0;
};

/// No NaN, nothing behind the eye, and depth where something is drawn.
testing::AssertionResult isSane(const EyeImage& image);

/// The z-buffer's picture with colours interpolated between samples, by the code that shaders share.
scene::EyeImage interpolated(const scene::ZBuffer& zBuffer, const PlaceSteps& places);

/// The same enlarged to width x height pixels by the places of its samples.
scene::EyeImage enlargedByPlaces(const scene::ZBuffer& zBuffer, const PlaceSteps& places, int width, int height);

/// Over all pixels, whatever their class; dB.
double psnrOf(const EyeImage& a, const EyeImage& b);

/// Share of all pixels for which a predicate of (x, y) holds.
template <class Holds>
double shareOf(const EyeImage& image, const Holds& holds) {
    int count = 0;
    for (int y = 0; y < image.colour.height(); ++y)
        for (int x = 0; x < image.colour.width(); ++x)
            count += holds(x, y) ? 1 : 0;
    return count / static_cast<double>(image.colour.size());
}

/// Share of pixels whose class differs, or a channel of whose colour does by more than so much.
double shareThatDiffers(const EyeImage& a, const scene::EyeImage& b, int colour = 6);

} // namespace render
