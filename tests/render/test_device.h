#pragma once
// The device that the tests draw on, with the validation layers listening where they are installed.

#include "render/renderer.h"

#include <gtest/gtest.h>

#include <span>
#include <vector>

namespace render {

/// One for all tests. Before it is made core and synchronisation validation are turned on, unless VK_INSTANCE_LAYERS is
/// set, and looks for hidden tiles however few there are (Device::looksAlways), unless REVISIT_TUNING is.
Device& testDevice();

/// The same as if it were a card, made when first wanted; where it is one, another of its kind.
Device& cardDevice();

/// Whether the validation layer is installed.
bool canValidate();

/// Fails after a test during which the validation layers had anything to say.
class RenderTest : public testing::Test {
  protected:
    void TearDown() override;
};

/// Draws one frame and returns its pictures.
std::vector<EyeImage> drawOnce(const GpuScene& scene, std::span<const scene::View> views, const Quality& quality);
EyeImage drawOnce(const GpuScene& scene, const scene::View& view, const Quality& quality);

/// Draws pictures of one scene and size, one after another: a renderer is dear to make where its shaders are compiled
/// for the processor.
class Painter {
  public:
    /// The scene must outlive it.
    Painter(const GpuScene& scene, const scene::Camera& camera);
    EyeImage operator()(const scene::View& view, const Quality& quality);

  private:
    Renderer renderer_;
};

/// Same bytes in colour, depth and class.
bool isSame(const EyeImage& a, const EyeImage& b);

/// Share of pixels that are not background.
double coverage(const EyeImage& image);

} // namespace render
