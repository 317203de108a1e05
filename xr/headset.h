#pragma once
// A headset as a source of views: one OpenXR session, its whole life.
//
//   idle -> ready (begin) -> synchronised -> visible -> focused -> stopping (end) -> idle -> exiting
//                any of these -> loss pending, or an error that says lost

#include "xr/runtime.h"
#include "xr/view_source.h"

#include <vector>

namespace xr {

/// The Vulkan objects that Runtime's functions helped to make.
struct VulkanHandles {
    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    std::uint32_t queueFamily = 0;
};

class Headset final : public ViewSource {
  public:
    /// Runtime and device must outlive it. Throws scene::Failure or Lost.
    Headset(const Runtime& runtime, const VulkanHandles& vulkan);
    ~Headset() override;

    int width() const override { return runtime_.recommendedWidth(); }
    int height() const override { return runtime_.recommendedHeight(); }
    /// Blocks in xrWaitFrame, which paces the frames; while the session does not run, for some milliseconds.
    Frame begin() override;
    void end(const Frame& frame) override;

    /// For whoever asks the runtime about controllers.
    XrSession session() const { return session_; }
    XrSpace trackingSpace() const { return tracking_; }
    XrTime displayTime() const { return displayTime_; } ///< of the frame begun last
    /// Whether the session runs: somebody wears it, or soon will.
    bool isRunning() const { return isRunning_; }

    /// Asks the runtime to end the session; Frame::Kind::end follows.
    void requestExit();

  private:
    void makeSession(const VulkanHandles& vulkan);
    void makeSpaces();
    void makeSwapchain();
    /// Nothing to draw yet, or the frame.
    Frame beginFrame();
    /// Follows the session's state. False when it is over.
    bool handleEvents();
    bool follow(XrSessionState state);
    void endFrame(bool withLayer);
    void locate(Frame& frame);

    const Runtime& runtime_;
    XrSession session_ = XR_NULL_HANDLE;
    XrSpace tracking_ = XR_NULL_HANDLE, head_ = XR_NULL_HANDLE;
    XrSwapchain swapchain_ = XR_NULL_HANDLE; ///< one layer for each eye
    std::vector<VkImage> images_;
    bool isRunning_ = false, isLost_ = false;
    XrTime displayTime_ = 0, firstTime_ = 0;
    std::array<XrView, kEyes> views_{}; ///< located last
    Frame lastKnown_;
    bool wasEverTracked_ = false;
};

} // namespace xr
