#pragma once
// A headset as a source of views: one OpenXR session, its whole life.
//
//   idle -> ready (begin) -> synchronised -> visible -> focused -> stopping (end) -> idle -> exiting
//                any of these -> loss pending, or an error that says lost

#include "xr/runtime.h"
#include "xr/swapchain.h"
#include "xr/view_source.h"
#include "xr/visibility_mask.h"

#include <memory>
#include <optional>
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
    /// Blocks in xrWaitFrame, which paces the frames; while the session does not run, for some milliseconds. The poses
    /// are asked for last, after all that may block: pictures must be drawn for the poses they are handed over with, so
    /// later would be too late.
    Frame begin() override;
    void end(const Frame& frame) override;

    /// For whoever asks the runtime about controllers.
    XrSession session() const { return session_; }
    XrSpace trackingSpace() const { return tracking_; }
    XrTime displayTime() const { return displayTime_; } ///< of the frame begun last
    /// Whether the session runs: somebody wears it, or soon will.
    bool isRunning() const { return isRunning_; }

    /// Asks for the offered rate that is nearest to so many frames a second. The rate that was asked for; none if the
    /// runtime offers no choice or refuses.
    std::optional<double> askForRate(double framesPerSecond);
    bool takesDepth() const { return depth_ != nullptr; }
    /// The share of the eye's picture that no lens shows, as the runtime says; 0 where it says nothing.
    double hiddenShareOf(std::size_t eye) const;

    /// Asks the runtime to end the session; Frame::Kind::end follows.
    void requestExit();

  private:
    void makeSession(const VulkanHandles& vulkan);
    void makeSpaces();
    void makeSwapchains();
    void fetchMasks();
    void destroy();
    /// Nothing to draw yet, or the frame.
    Frame beginFrame();
    /// Follows the session's state. False when it is over.
    bool handleEvents();
    bool handle(const XrEventDataBuffer& event);
    bool follow(XrSessionState state);
    /// frame: what is shown; null: nothing.
    void endFrame(const Frame* frame);
    void fetchRate();
    /// Refreshes of the display between two frames of ours, by the times that the runtime foretells. Not by its
    /// periods: those may be the application's own pace.
    std::optional<int> missedBefore(XrTime displayTime);
    void locate(Frame& frame);
    /// What is not known stays as it was last.
    void keep(const XrViewState& state, const std::array<XrView, kEyes>& views, const XrSpaceLocation& head);

    const Runtime& runtime_;
    XrSession session_ = XR_NULL_HANDLE;
    XrReferenceSpaceType trackingType_ = XR_REFERENCE_SPACE_TYPE_LOCAL;
    XrSpace tracking_ = XR_NULL_HANDLE, head_ = XR_NULL_HANDLE;
    std::unique_ptr<Swapchain> colour_, depth_; ///< depth_ is null where the runtime does not take any
    std::array<VisibilityMask, kEyes> masks_;
    bool isRunning_ = false, isLost_ = false;
    XrTime displayTime_ = 0, firstTime_ = 0;
    bool isFirstOfSession_ = true;       ///< the next frame
    std::optional<double> refreshHertz_; ///< of the display, where the runtime says it
    std::optional<XrTime> recentredAt_;  ///< from when on the tracking space is another
    std::array<XrView, kEyes> views_{};  ///< located last
    XrPosef trackingFromHead_{};         ///< likewise
    bool isTracked_ = false;
    bool wasEverTracked_ = false;
};

} // namespace xr
