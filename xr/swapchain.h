#pragma once
// Images that a runtime shows, one layer or one image for each eye.

#include "xr/runtime.h"
#include "xr/view_source.h"

#include <vector>

namespace xr {

/// The eyes' images of one kind, colour or depth: two layers of one swapchain, or a swapchain each where the runtime
/// refuses layers. They are acquired and released together.
class Swapchain {
  public:
    /// Throws scene::Failure if the runtime refuses such images, Lost if it is gone. The session must outlive it.
    Swapchain(XrSession session, VkFormat format, XrSwapchainUsageFlags usage, int width, int height);
    ~Swapchain();
    Swapchain(const Swapchain&) = delete;
    Swapchain& operator=(const Swapchain&) = delete;

    /// Blocks until the next images may be written.
    void acquire();
    void release();

    /// Of the eye's images, the one acquired last.
    VkImage image(std::size_t eye) const;
    std::uint32_t layer(std::size_t eye) const { return chains_.size() == 1 ? static_cast<std::uint32_t>(eye) : 0; }
    /// Where the runtime finds what was released last: so many rows and columns, the first ones; 0: all.
    XrSwapchainSubImage subImage(std::size_t eye, int width, int height) const;
    bool hasLayers() const { return chains_.size() == 1; }

  private:
    struct Chain {
        XrSwapchain handle = XR_NULL_HANDLE;
        std::vector<VkImage> images;
        std::uint32_t acquired = 0;
    };
    const Chain& chainOf(std::size_t eye) const { return chains_[hasLayers() ? 0 : eye]; }
    void destroy();

    std::vector<Chain> chains_; ///< one, or one for each eye
    int width_, height_;
};

} // namespace xr
