#include "xr/headset.h"

#include "scene/errors.h"
#include "xr/check.h"
#include "xr/convert.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>
#include <thread>
#include <utility>

namespace xr {

namespace {

constexpr XrViewConfigurationType kStereo = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
constexpr XrPosef kHere{{0, 0, 0, 1}, {0, 0, 0}};

/// How often a session that does not run is asked whether it does: OpenXR has no call that waits for an event.
constexpr std::chrono::milliseconds kIdle{5};

/// Where a runtime knows no floor, the head is taken to start so high above it, metres.
constexpr float kStandingHeight = 1.6f;

/// XR_EXT_local_floor, which Debian's headers do not know yet.
constexpr auto kLocalFloor = static_cast<XrReferenceSpaceType>(1000426000);

FieldOfView fieldOf(const XrFovf& fov) {
    return {static_cast<double>(fov.angleLeft), static_cast<double>(fov.angleRight), static_cast<double>(fov.angleUp),
            static_cast<double>(fov.angleDown)};
}

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
        makeSwapchains();
        fetchMasks();
    } catch (...) {
        destroy();
        throw;
    }
}

Headset::~Headset() {
    destroy();
}

void Headset::destroy() {
    // Not left to the session: some runtimes keep what outlives it. That it was lost changes nothing.
    depth_.reset();
    colour_.reset();
    for (XrSpace* space : {&head_, &tracking_})
        if (*space != XR_NULL_HANDLE) xrDestroySpace(*space);
    if (session_ != XR_NULL_HANDLE) xrDestroySession(session_);
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
    const auto has = [&](XrReferenceSpaceType type) {
        return std::find(offered.begin(), offered.end(), type) != offered.end();
    };
    XrPosef floor = kHere;
    if (has(XR_REFERENCE_SPACE_TYPE_STAGE))
        trackingType_ = XR_REFERENCE_SPACE_TYPE_STAGE;
    else if (has(kLocalFloor))
        trackingType_ = kLocalFloor;
    else
        floor.position.y = -kStandingHeight;
    tracking_ = makeReferenceSpace(session_, trackingType_, floor);
    head_ = makeReferenceSpace(session_, XR_REFERENCE_SPACE_TYPE_VIEW, kHere);
}

void Headset::makeSwapchains() {
    std::uint32_t count = 0;
    check(xrEnumerateSwapchainFormats(session_, 0, &count, nullptr), "xrEnumerateSwapchainFormats");
    std::vector<std::int64_t> offered(count);
    check(xrEnumerateSwapchainFormats(session_, count, &count, offered.data()), "xrEnumerateSwapchainFormats");
    const auto has = [&](VkFormat format) {
        return std::find(offered.begin(), offered.end(), format) != offered.end();
    };
    // Our pictures are coded as sRGB already, so the runtime must read them so.
    if (!has(VK_FORMAT_R8G8B8A8_SRGB))
        throw scene::Failure("the runtime takes no pictures of the format R8G8B8A8_SRGB", runtime_.name(),
                             "update the runtime, or make another one active");
    constexpr XrSwapchainUsageFlags kCopied = XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT | XR_SWAPCHAIN_USAGE_TRANSFER_SRC_BIT;
    colour_ = std::make_unique<Swapchain>(
        session_, VK_FORMAT_R8G8B8A8_SRGB,
        kCopied | XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT | XR_SWAPCHAIN_USAGE_SAMPLED_BIT, width(), height());
    if (!runtime_.has(XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME) || !has(VK_FORMAT_D32_SFLOAT)) return;
    try {
        depth_ =
            std::make_unique<Swapchain>(session_, VK_FORMAT_D32_SFLOAT,
                                        kCopied | XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, width(), height());
    } catch (const scene::Failure&) {
        // It offers depth and takes none that can be drawn into and copied to: a walk is one without.
    }
}

void Headset::fetchMasks() {
    if (!runtime_.has(XR_KHR_VISIBILITY_MASK_EXTENSION_NAME)) return;
    const auto get = runtime_.load<PFN_xrGetVisibilityMaskKHR>("xrGetVisibilityMaskKHR");
    for (std::uint32_t eye = 0; eye < kEyes; ++eye) {
        XrVisibilityMaskKHR mask{};
        mask.type = XR_TYPE_VISIBILITY_MASK_KHR;
        const auto ask = [&] {
            check(get(session_, kStereo, eye, XR_VISIBILITY_MASK_TYPE_HIDDEN_TRIANGLE_MESH_KHR, &mask),
                  "xrGetVisibilityMaskKHR");
        };
        ask();
        std::vector<XrVector2f> vertices(mask.vertexCountOutput);
        masks_[eye].indices.resize(mask.indexCountOutput);
        mask.vertexCapacityInput = mask.vertexCountOutput, mask.vertices = vertices.data();
        mask.indexCapacityInput = mask.indexCountOutput, mask.indices = masks_[eye].indices.data();
        if (!vertices.empty()) ask();
        masks_[eye].vertices.clear();
        for (const XrVector2f& vertex : vertices)
            masks_[eye].vertices.emplace_back(vertex.x, vertex.y);
    }
}

double Headset::hiddenShareOf(std::size_t eye) const {
    const FieldOfView field = fieldOf(views_[eye].fov);
    return field.right > field.left && field.up > field.down ? hiddenShare(masks_[eye], field) : 0;
}

std::optional<double> Headset::askForRate(double framesPerSecond) {
    if (!runtime_.has(XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME)) return std::nullopt;
    try {
        const auto list = runtime_.load<PFN_xrEnumerateDisplayRefreshRatesFB>("xrEnumerateDisplayRefreshRatesFB");
        std::uint32_t count = 0;
        check(list(session_, 0, &count, nullptr), "xrEnumerateDisplayRefreshRatesFB");
        std::vector<float> offered(count);
        check(list(session_, count, &count, offered.data()), "xrEnumerateDisplayRefreshRatesFB");
        const auto distance = [&](float rate) { return std::abs(static_cast<double>(rate) - framesPerSecond); };
        const auto nearest = std::min_element(offered.begin(), offered.end(),
                                              [&](float a, float b) { return distance(a) < distance(b); });
        if (nearest == offered.end()) return std::nullopt;
        const auto request = runtime_.load<PFN_xrRequestDisplayRefreshRateFB>("xrRequestDisplayRefreshRateFB");
        if (XR_FAILED(request(session_, *nearest))) return std::nullopt;
        return static_cast<double>(*nearest);
    } catch (const Lost&) {
        isLost_ = true; // the next begin says so
        return std::nullopt;
    }
}

void Headset::fetchRate() {
    refreshHertz_.reset();
    if (!runtime_.has(XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME)) return;
    const auto get = runtime_.load<PFN_xrGetDisplayRefreshRateFB>("xrGetDisplayRefreshRateFB");
    float hertz = 0;
    if (XR_SUCCEEDED(get(session_, &hertz)) && hertz > 0) refreshHertz_ = static_cast<double>(hertz);
}

bool Headset::follow(XrSessionState state) {
    if (state == XR_SESSION_STATE_READY) {
        XrSessionBeginInfo info{};
        info.type = XR_TYPE_SESSION_BEGIN_INFO;
        info.primaryViewConfigurationType = kStereo;
        check(xrBeginSession(session_, &info), "xrBeginSession");
        isRunning_ = isFirstOfSession_ = true;
        fetchRate();
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
        if (!handle(event)) return false;
    }
}

bool Headset::handle(const XrEventDataBuffer& event) {
    if (event.type == XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING) throw Lost("the runtime is going away");
    if (event.type == XR_TYPE_EVENT_DATA_VISIBILITY_MASK_CHANGED_KHR) fetchMasks();
    if (event.type == XR_TYPE_EVENT_DATA_DISPLAY_REFRESH_RATE_CHANGED_FB) fetchRate();
    if (event.type == XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING) {
        const auto& change = reinterpret_cast<const XrEventDataReferenceSpaceChangePending&>(event);
        if (change.session == session_ && change.referenceSpaceType == trackingType_) recentredAt_ = change.changeTime;
    }
    if (event.type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) {
        const auto& change = reinterpret_cast<const XrEventDataSessionStateChanged&>(event);
        return change.session != session_ || follow(change.state);
    }
    return true;
}

Frame Headset::begin() {
    Frame frame;
    try {
        if (isLost_) throw Lost("the runtime was lost before");
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
    frame.refreshesMissed = missedBefore(state.predictedDisplayTime);
    displayTime_ = state.predictedDisplayTime;
    if (firstTime_ == 0) firstTime_ = displayTime_;
    if (!state.shouldRender) {
        endFrame(nullptr);
        return frame;
    }
    colour_->acquire();
    if (depth_ != nullptr) depth_->acquire();
    locate(frame);
    frame.kind = Frame::Kind::draw;
    frame.seconds = static_cast<double>(displayTime_ - firstTime_) * 1e-9;
    frame.wasRecentred = recentredAt_ && *recentredAt_ <= displayTime_;
    if (frame.wasRecentred) recentredAt_.reset();
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
        frame.images[eye] = {colour_->image(eye), colour_->layer(eye), VK_NULL_HANDLE, 0};
        if (depth_ == nullptr) continue;
        frame.images[eye].depth = depth_->image(eye);
        frame.images[eye].depthLayer = depth_->layer(eye);
    }
    return frame;
}

std::optional<int> Headset::missedBefore(XrTime displayTime) {
    if (!refreshHertz_) return std::nullopt;
    if (std::exchange(isFirstOfSession_, false)) return 0;
    const double seconds = static_cast<double>(displayTime - displayTime_) * 1e-9;
    return std::max(0, static_cast<int>(std::lround(seconds * *refreshHertz_)) - 1);
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
    keep(state, views, head);

    frame.isTracked = isTracked_;
    frame.trackingFromHead = poseOf(trackingFromHead_);
    for (std::size_t eye = 0; eye < kEyes; ++eye)
        frame.eyes[eye] = {cameraOf(fieldOf(views_[eye].fov), width(), height()),
                           poseOf(views_[eye].pose) * scene::headFromCamera()};
}

void Headset::keep(const XrViewState& state, const std::array<XrView, kEyes>& views, const XrSpaceLocation& head) {
    const bool isPlaced = (state.viewStateFlags & XR_VIEW_STATE_POSITION_VALID_BIT) != 0 &&
                          (head.locationFlags & XR_SPACE_LOCATION_POSITION_VALID_BIT) != 0;
    const bool isTurned = (state.viewStateFlags & XR_VIEW_STATE_ORIENTATION_VALID_BIT) != 0 &&
                          (head.locationFlags & XR_SPACE_LOCATION_ORIENTATION_VALID_BIT) != 0;
    isTracked_ = isPlaced && isTurned;
    if (!wasEverTracked_) {
        // Nothing was ever known: straight ahead, so that there is a picture at all.
        views_ = views;
        trackingFromHead_ = {kHere.orientation, {0, kStandingHeight, 0}};
        for (XrView& view : views_)
            view.pose = trackingFromHead_;
    }
    wasEverTracked_ = wasEverTracked_ || isTracked_;
    if (isTracked_) {
        views_ = views;
        trackingFromHead_ = head.pose;
    } else if (isTurned) {
        // Where it is, is lost, but not where it looks: a picture that does not turn with the head makes one ill. The
        // eyes turn about the head's last place; they keep their distance from it.
        const scene::Pose last = poseOf(trackingFromHead_);
        trackingFromHead_.orientation = head.pose.orientation;
        const scene::Pose turned = poseOf(trackingFromHead_) * inverse(last);
        for (std::size_t eye = 0; eye < kEyes; ++eye) {
            const glm::dvec3 place = turned * poseOf(views_[eye].pose).translation;
            views_[eye].pose = {
                views[eye].pose.orientation,
                {static_cast<float>(place.x), static_cast<float>(place.y), static_cast<float>(place.z)}};
        }
    }
}

void Headset::end(const Frame& frame) {
    try {
        colour_->release();
        if (depth_ != nullptr) depth_->release();
        endFrame(&frame);
    } catch (const Lost&) {
        isLost_ = true; // the next begin says so
    }
}

void Headset::endFrame(const Frame* frame) {
    std::array<XrCompositionLayerProjectionView, kEyes> views{};
    std::array<XrCompositionLayerDepthInfoKHR, kEyes> depths{};
    for (std::uint32_t eye = 0; eye < kEyes && frame != nullptr; ++eye) {
        views[eye].type = XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW;
        views[eye].pose = views_[eye].pose;
        views[eye].fov = views_[eye].fov;
        views[eye].subImage = colour_->subImage(eye, frame->pictureWidth, frame->pictureHeight);
        if (depth_ == nullptr) continue;
        // 0 in the image is infinitely far, 1 is near.
        depths[eye].type = XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR;
        depths[eye].subImage = depth_->subImage(eye, frame->pictureWidth, frame->pictureHeight);
        depths[eye].minDepth = 0;
        depths[eye].maxDepth = 1;
        depths[eye].nearZ = std::numeric_limits<float>::infinity(); // of minDepth
        depths[eye].farZ = static_cast<float>(kDepthNearMetres);    // of maxDepth
        views[eye].next = &depths[eye];
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
    info.layerCount = frame != nullptr ? 1 : 0;
    info.layers = &header;
    check(xrEndFrame(session_, &info), "xrEndFrame");
}

void Headset::requestExit() {
    if (!isRunning_ || isLost_) return;
    xrRequestExitSession(session_); // an error here means that it is over already
}

} // namespace xr
