#include "xr/headset.h"

#include "scene/errors.h"
#include "xr/check.h"
#include "xr/convert.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <thread>

namespace xr {

namespace {

constexpr XrViewConfigurationType kStereo = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
constexpr XrPosef kHere{{0, 0, 0, 1}, {0, 0, 0}};

/// How often a session that does not run is asked whether it does: OpenXR has no call that waits for an event.
constexpr std::chrono::milliseconds kIdle{5};

/// Where a runtime knows no floor, the head is taken to start so high above it, metres.
constexpr float kStandingHeight = 1.6f;

scene::Pose poseOf(const XrPosef& pose) {
    const auto& [q, p] = pose;
    return scene::poseFromQuaternion({p.x, p.y, p.z}, q.x, q.y, q.z, q.w);
}

XrSpace makeReferenceSpace(XrSession session, XrReferenceSpaceType type, const XrPosef& pose) {
    XrReferenceSpaceCreateInfo info{};
    info.type = XR_TYPE_REFERENCE_SPACE_CREATE_INFO;
    info.referenceSpaceType = type;
    info.poseInReferenceSpace = pose;
    XrSpace space = XR_NULL_HANDLE;
    check(xrCreateReferenceSpace(session, &info, &space), "xrCreateReferenceSpace");
    return space;
}

} // namespace

Headset::Headset(const Runtime& runtime, const VulkanHandles& vulkan) : runtime_(runtime) {
    try {
        makeSession(vulkan);
        makeSpaces();
        makeSwapchain();
    } catch (...) {
        if (session_ != XR_NULL_HANDLE) xrDestroySession(session_);
        throw;
    }
}

Headset::~Headset() {
    xrDestroySession(session_); // and all that was made from it
}

void Headset::makeSession(const VulkanHandles& vulkan) {
    XrGraphicsBindingVulkan2KHR binding{};
    binding.type = XR_TYPE_GRAPHICS_BINDING_VULKAN2_KHR;
    binding.instance = vulkan.instance;
    binding.physicalDevice = vulkan.physical;
    binding.device = vulkan.device;
    binding.queueFamilyIndex = vulkan.queueFamily;
    binding.queueIndex = 0;
    XrSessionCreateInfo info{};
    info.type = XR_TYPE_SESSION_CREATE_INFO;
    info.next = &binding;
    info.systemId = runtime_.system();
    check(xrCreateSession(runtime_.instance(), &info, &session_), "xrCreateSession");
}

void Headset::makeSpaces() {
    std::uint32_t count = 0;
    check(xrEnumerateReferenceSpaces(session_, 0, &count, nullptr), "xrEnumerateReferenceSpaces");
    std::vector<XrReferenceSpaceType> offered(count);
    check(xrEnumerateReferenceSpaces(session_, count, &count, offered.data()), "xrEnumerateReferenceSpaces");
    const bool hasStage = std::find(offered.begin(), offered.end(), XR_REFERENCE_SPACE_TYPE_STAGE) != offered.end();
    XrPosef floor = kHere;
    if (!hasStage) floor.position.y = -kStandingHeight;
    tracking_ =
        makeReferenceSpace(session_, hasStage ? XR_REFERENCE_SPACE_TYPE_STAGE : XR_REFERENCE_SPACE_TYPE_LOCAL, floor);
    head_ = makeReferenceSpace(session_, XR_REFERENCE_SPACE_TYPE_VIEW, kHere);
}

void Headset::makeSwapchain() {
    std::uint32_t count = 0;
    check(xrEnumerateSwapchainFormats(session_, 0, &count, nullptr), "xrEnumerateSwapchainFormats");
    std::vector<std::int64_t> offered(count);
    check(xrEnumerateSwapchainFormats(session_, count, &count, offered.data()), "xrEnumerateSwapchainFormats");
    // Our pictures are coded as sRGB already, so the runtime must read them so.
    if (std::find(offered.begin(), offered.end(), VK_FORMAT_R8G8B8A8_SRGB) == offered.end())
        throw scene::Failure("the runtime takes no pictures of the format R8G8B8A8_SRGB", runtime_.name(),
                             "update the runtime, or make another one active");
    XrSwapchainCreateInfo info{};
    info.type = XR_TYPE_SWAPCHAIN_CREATE_INFO;
    info.usageFlags = XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT | XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT |
                      XR_SWAPCHAIN_USAGE_SAMPLED_BIT | XR_SWAPCHAIN_USAGE_TRANSFER_SRC_BIT;
    info.format = VK_FORMAT_R8G8B8A8_SRGB;
    info.sampleCount = info.faceCount = info.mipCount = 1;
    info.arraySize = kEyes;
    info.width = static_cast<std::uint32_t>(width());
    info.height = static_cast<std::uint32_t>(height());
    check(xrCreateSwapchain(session_, &info, &swapchain_), "xrCreateSwapchain");
    check(xrEnumerateSwapchainImages(swapchain_, 0, &count, nullptr), "xrEnumerateSwapchainImages");
    std::vector<XrSwapchainImageVulkan2KHR> images(count,
                                                   {XR_TYPE_SWAPCHAIN_IMAGE_VULKAN2_KHR, nullptr, VK_NULL_HANDLE});
    check(xrEnumerateSwapchainImages(swapchain_, count, &count,
                                     reinterpret_cast<XrSwapchainImageBaseHeader*>(images.data())),
          "xrEnumerateSwapchainImages");
    for (const XrSwapchainImageVulkan2KHR& image : images)
        images_.push_back(image.image);
}

bool Headset::follow(XrSessionState state) {
    if (state == XR_SESSION_STATE_READY) {
        XrSessionBeginInfo info{};
        info.type = XR_TYPE_SESSION_BEGIN_INFO;
        info.primaryViewConfigurationType = kStereo;
        check(xrBeginSession(session_, &info), "xrBeginSession");
        isRunning_ = true;
    } else if (state == XR_SESSION_STATE_STOPPING) {
        isRunning_ = false;
        check(xrEndSession(session_), "xrEndSession");
    } else if (state == XR_SESSION_STATE_LOSS_PENDING) {
        throw Lost("the session was lost");
    }
    return state != XR_SESSION_STATE_EXITING;
}

bool Headset::handleEvents() {
    while (true) {
        XrEventDataBuffer event{};
        event.type = XR_TYPE_EVENT_DATA_BUFFER;
        const XrResult result = xrPollEvent(runtime_.instance(), &event);
        if (result == XR_EVENT_UNAVAILABLE) return true;
        check(result, "xrPollEvent");
        if (event.type == XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING) throw Lost("the runtime is going away");
        if (event.type != XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) continue;
        const auto& change = *reinterpret_cast<const XrEventDataSessionStateChanged*>(&event);
        if (change.session == session_ && !follow(change.state)) return false;
    }
}

Frame Headset::begin() {
    Frame frame;
    try {
        return beginFrame();
    } catch (const Lost&) {
        isLost_ = true;
        frame.kind = Frame::Kind::lost;
    }
    return frame;
}

Frame Headset::beginFrame() {
    Frame frame;
    if (!handleEvents()) {
        frame.kind = Frame::Kind::end;
        return frame;
    }
    if (!isRunning_) {
        std::this_thread::sleep_for(kIdle);
        return frame;
    }
    XrFrameState state{};
    state.type = XR_TYPE_FRAME_STATE;
    check(xrWaitFrame(session_, nullptr, &state), "xrWaitFrame");
    check(xrBeginFrame(session_, nullptr), "xrBeginFrame");
    displayTime_ = state.predictedDisplayTime;
    if (firstTime_ == 0) firstTime_ = displayTime_;
    if (!state.shouldRender) {
        endFrame(false);
        return frame;
    }
    std::uint32_t index = 0;
    check(xrAcquireSwapchainImage(swapchain_, nullptr, &index), "xrAcquireSwapchainImage");
    XrSwapchainImageWaitInfo wait{};
    wait.type = XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO;
    wait.timeout = XR_INFINITE_DURATION;
    check(xrWaitSwapchainImage(swapchain_, &wait), "xrWaitSwapchainImage");
    // After all that may block, so that the poses are as fresh as can be.
    locate(frame);
    frame.kind = Frame::Kind::draw;
    frame.seconds = static_cast<double>(displayTime_ - firstTime_) * 1e-9;
    for (std::uint32_t eye = 0; eye < kEyes; ++eye)
        frame.images[eye] = {images_[index], eye};
    return frame;
}

void Headset::locate(Frame& frame) {
    XrViewLocateInfo info{};
    info.type = XR_TYPE_VIEW_LOCATE_INFO;
    info.viewConfigurationType = kStereo;
    info.displayTime = displayTime_;
    info.space = tracking_;
    XrViewState state{};
    state.type = XR_TYPE_VIEW_STATE;
    std::array<XrView, kEyes> views{};
    for (XrView& view : views)
        view.type = XR_TYPE_VIEW;
    std::uint32_t count = 0;
    check(xrLocateViews(session_, &info, &state, kEyes, &count, views.data()), "xrLocateViews");
    XrSpaceLocation head{};
    head.type = XR_TYPE_SPACE_LOCATION;
    check(xrLocateSpace(head_, tracking_, displayTime_, &head), "xrLocateSpace");

    constexpr XrViewStateFlags kValid = XR_VIEW_STATE_POSITION_VALID_BIT | XR_VIEW_STATE_ORIENTATION_VALID_BIT;
    constexpr XrSpaceLocationFlags kHeadValid =
        XR_SPACE_LOCATION_POSITION_VALID_BIT | XR_SPACE_LOCATION_ORIENTATION_VALID_BIT;
    const bool isKnown = (state.viewStateFlags & kValid) == kValid && (head.locationFlags & kHeadValid) == kHeadValid;
    // Nothing was ever known: straight ahead, so that there is a picture at all.
    if (isKnown || !wasEverTracked_) {
        views_ = views;
        for (XrView& view : views_)
            if (!isKnown) view.pose = {kHere.orientation, {0, kStandingHeight, 0}};
        lastKnown_.trackingFromHead = isKnown ? poseOf(head.pose) : scene::Pose{glm::dmat3(1), {0, kStandingHeight, 0}};
        wasEverTracked_ = wasEverTracked_ || isKnown;
    }
    frame.isTracked = isKnown;
    frame.trackingFromHead = lastKnown_.trackingFromHead;
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
        const XrFovf& fov = views_[eye].fov;
        const FieldOfView field{static_cast<double>(fov.angleLeft), static_cast<double>(fov.angleRight),
                                static_cast<double>(fov.angleUp), static_cast<double>(fov.angleDown)};
        frame.eyes[eye] = {cameraOf(field, width(), height()), poseOf(views_[eye].pose) * scene::headFromCamera()};
    }
}

void Headset::end(const Frame&) {
    try {
        check(xrReleaseSwapchainImage(swapchain_, nullptr), "xrReleaseSwapchainImage");
        endFrame(true);
    } catch (const Lost&) {
        isLost_ = true; // the next begin meets the same
    }
}

void Headset::endFrame(bool withLayer) {
    std::array<XrCompositionLayerProjectionView, kEyes> views{};
    for (std::uint32_t eye = 0; eye < kEyes; ++eye) {
        views[eye].type = XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW;
        views[eye].pose = views_[eye].pose;
        views[eye].fov = views_[eye].fov;
        views[eye].subImage = {swapchain_, {{0, 0}, {width(), height()}}, eye};
    }
    XrCompositionLayerProjection layer{};
    layer.type = XR_TYPE_COMPOSITION_LAYER_PROJECTION;
    layer.space = tracking_;
    layer.viewCount = kEyes;
    layer.views = views.data();
    const auto* const header = reinterpret_cast<const XrCompositionLayerBaseHeader*>(&layer);
    XrFrameEndInfo info{};
    info.type = XR_TYPE_FRAME_END_INFO;
    info.displayTime = displayTime_;
    info.environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
    info.layerCount = withLayer ? 1 : 0;
    info.layers = &header;
    check(xrEndFrame(session_, &info), "xrEndFrame");
}

void Headset::requestExit() {
    if (!isRunning_ || isLost_) return;
    xrRequestExitSession(session_); // an error here means that it is over already
}

} // namespace xr
