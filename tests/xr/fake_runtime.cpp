// An OpenXR runtime that does what a test says, for what Monado never does: refuse, lose, forget. It has two eyes and
// shows nothing. The environment variable REVISIT_FAKE holds words, asked at every call:
//
//   no-vulkan no-headset no-srgb no-arrays no-depth   what it does not offer or refuses
//   views=N                                           views of the headset, if not 2
//   rate                                              it says the display's, 100 Hz
//   late                                              from frame to frame 29 ms pass instead of 10
//   untracked                                         the head is nowhere
//   recentred                                         the space of reference changes with the next event
//   lose=CALL:session, lose=CALL:instance             what that call answers from now on
//
// fakeRuntimeAlive() says how many of its objects were made and not destroyed.

#include <volk.h>

#define XR_NO_PROTOTYPES // they are ours
#define XR_USE_GRAPHICS_API_VULKAN
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace {

// What the loader and a runtime agree on; Debian has no header of it (OpenXR's loader specification, version 1).
struct NegotiateLoaderInfo;
struct NegotiateRuntimeRequest {
    std::uint32_t structType, structVersion;
    std::size_t structSize;
    std::uint32_t runtimeInterfaceVersion;
    XrVersion runtimeApiVersion;
    PFN_xrGetInstanceProcAddr getInstanceProcAddr;
};

constexpr std::uint32_t kWidth = 64, kHeight = 48, kImages = 2;

struct FakeSwapchain {
    VkDevice device = VK_NULL_HANDLE;
    std::array<VkImage, kImages> images{};
    std::array<VkDeviceMemory, kImages> memories{};
    std::uint32_t next = 0;
};

/// One session at a time is enough.
struct State {
    int alive = 0;
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    XrSession session = XR_NULL_HANDLE;
    std::deque<XrSessionState> states;
    bool hasRecentred = false;
    XrTime time = 1000000000;
    XrRect2Di shown{}; ///< of the right eye's picture, in the last frame
} state;

bool says(const std::string& wanted) {
    const char* const text = std::getenv("REVISIT_FAKE");
    std::istringstream words(text != nullptr ? text : "");
    for (std::string word; words >> word;)
        if (word == wanted) return true;
    return false;
}

std::uint32_t viewCount() {
    for (const auto& [word, count] : {std::pair{"views=1", 1u}, {"views=4", 4u}})
        if (says(word)) return count;
    return 2;
}

/// What a call answers before it does anything.
XrResult asked(const char* call) {
    if (says(std::string("lose=") + call + ":session")) return XR_ERROR_SESSION_LOST;
    if (says(std::string("lose=") + call + ":instance")) return XR_ERROR_INSTANCE_LOST;
    return XR_SUCCESS;
}

#define REVISIT_ASK                                                                                                    \
    if (const XrResult answer = asked(__func__); answer != XR_SUCCESS) return answer

template <class Handle>
Handle made() {
    ++state.alive;
    return reinterpret_cast<Handle>(new char);
}

template <class Handle>
XrResult destroyed(Handle handle) {
    --state.alive;
    delete reinterpret_cast<char*>(handle);
    return XR_SUCCESS;
}

template <class T>
XrResult list(const std::vector<T>& all, std::uint32_t capacity, std::uint32_t* count, T* out) {
    *count = static_cast<std::uint32_t>(all.size());
    if (capacity == 0) return XR_SUCCESS;
    if (capacity < all.size()) return XR_ERROR_SIZE_INSUFFICIENT;
    std::copy(all.begin(), all.end(), out);
    return XR_SUCCESS;
}

XrResult xrEnumerateInstanceExtensionProperties(const char*, std::uint32_t capacity, std::uint32_t* count,
                                                XrExtensionProperties* out) {
    std::vector<XrExtensionProperties> all;
    std::vector<const char*> names;
    if (!says("no-vulkan")) names.push_back(XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME);
    if (!says("no-depth")) names.push_back(XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME);
    if (says("rate")) names.push_back(XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME);
    for (const char* name : names) {
        XrExtensionProperties extension{};
        extension.type = XR_TYPE_EXTENSION_PROPERTIES;
        std::strncpy(extension.extensionName, name, XR_MAX_EXTENSION_NAME_SIZE - 1);
        extension.extensionVersion = 1;
        all.push_back(extension);
    }
    return list(all, capacity, count, out);
}

XrResult xrCreateInstance(const XrInstanceCreateInfo*, XrInstance* instance) {
    REVISIT_ASK;
    *instance = made<XrInstance>();
    return XR_SUCCESS;
}

XrResult xrDestroyInstance(XrInstance instance) {
    return destroyed(instance);
}

XrResult xrGetInstanceProperties(XrInstance, XrInstanceProperties* properties) {
    properties->runtimeVersion = XR_MAKE_VERSION(1, 0, 0);
    std::strcpy(properties->runtimeName, "Fake");
    return XR_SUCCESS;
}

XrResult xrGetSystem(XrInstance, const XrSystemGetInfo*, XrSystemId* system) {
    *system = 1;
    return says("no-headset") ? XR_ERROR_FORM_FACTOR_UNAVAILABLE : XR_SUCCESS;
}

XrResult xrGetSystemProperties(XrInstance, XrSystemId, XrSystemProperties* properties) {
    std::strcpy(properties->systemName, "Eyes");
    return XR_SUCCESS;
}

XrResult xrEnumerateViewConfigurationViews(XrInstance, XrSystemId, XrViewConfigurationType, std::uint32_t capacity,
                                           std::uint32_t* count, XrViewConfigurationView* out) {
    const XrViewConfigurationView view{
        XR_TYPE_VIEW_CONFIGURATION_VIEW, nullptr, kWidth, kWidth, kHeight, kHeight, 1, 1};
    return list(std::vector<XrViewConfigurationView>(viewCount(), view), capacity, count, out);
}

XrResult xrGetVulkanGraphicsRequirements2KHR(XrInstance, XrSystemId, XrGraphicsRequirementsVulkan2KHR* requirements) {
    requirements->minApiVersionSupported = XR_MAKE_VERSION(1, 0, 0);
    requirements->maxApiVersionSupported = XR_MAKE_VERSION(1, 9, 0);
    return XR_SUCCESS;
}

XrResult xrCreateVulkanInstanceKHR(XrInstance, const XrVulkanInstanceCreateInfoKHR* info, VkInstance* instance,
                                   VkResult* result) {
    REVISIT_ASK;
    volkInitializeCustom(info->pfnGetInstanceProcAddr);
    *result = vkCreateInstance(info->vulkanCreateInfo, nullptr, instance);
    if (*result == VK_SUCCESS) volkLoadInstanceOnly(*instance);
    return XR_SUCCESS;
}

XrResult xrGetVulkanGraphicsDevice2KHR(XrInstance, const XrVulkanGraphicsDeviceGetInfoKHR* info,
                                       VkPhysicalDevice* physical) {
    std::uint32_t count = 1;
    vkEnumeratePhysicalDevices(info->vulkanInstance, &count, &state.physical);
    *physical = state.physical;
    return XR_SUCCESS;
}

XrResult xrCreateVulkanDeviceKHR(XrInstance, const XrVulkanDeviceCreateInfoKHR* info, VkDevice* device,
                                 VkResult* result) {
    *result = vkCreateDevice(info->vulkanPhysicalDevice, info->vulkanCreateInfo, nullptr, device);
    if (*result == VK_SUCCESS) volkLoadDevice(*device);
    return XR_SUCCESS;
}

XrResult xrCreateSession(XrInstance, const XrSessionCreateInfo* info, XrSession* session) {
    REVISIT_ASK;
    state.device = static_cast<const XrGraphicsBindingVulkan2KHR*>(info->next)->device;
    state.states = {XR_SESSION_STATE_IDLE, XR_SESSION_STATE_READY};
    state.hasRecentred = false;
    state.session = *session = made<XrSession>();
    return XR_SUCCESS;
}

XrResult xrDestroySession(XrSession session) {
    return destroyed(session);
}

XrResult xrEnumerateReferenceSpaces(XrSession, std::uint32_t capacity, std::uint32_t* count,
                                    XrReferenceSpaceType* out) {
    REVISIT_ASK;
    return list<XrReferenceSpaceType>({XR_REFERENCE_SPACE_TYPE_VIEW, XR_REFERENCE_SPACE_TYPE_LOCAL}, capacity, count,
                                      out);
}

XrResult xrCreateReferenceSpace(XrSession, const XrReferenceSpaceCreateInfo*, XrSpace* space) {
    REVISIT_ASK;
    *space = made<XrSpace>();
    return XR_SUCCESS;
}

XrResult xrDestroySpace(XrSpace space) {
    return destroyed(space);
}

XrResult xrEnumerateSwapchainFormats(XrSession, std::uint32_t capacity, std::uint32_t* count, std::int64_t* out) {
    REVISIT_ASK;
    std::vector<std::int64_t> formats{VK_FORMAT_R16G16B16A16_SFLOAT, VK_FORMAT_D32_SFLOAT};
    if (!says("no-srgb")) formats.push_back(VK_FORMAT_R8G8B8A8_SRGB);
    return list(formats, capacity, count, out);
}

XrResult xrCreateSwapchain(XrSession, const XrSwapchainCreateInfo* info, XrSwapchain* swapchain) {
    REVISIT_ASK;
    if (says("no-arrays") && info->arraySize > 1) return XR_ERROR_FEATURE_UNSUPPORTED;
    auto* const chain = new FakeSwapchain;
    chain->device = state.device;
    VkPhysicalDeviceMemoryProperties memory{};
    vkGetPhysicalDeviceMemoryProperties(state.physical, &memory);
    for (std::uint32_t i = 0; i < kImages; ++i) {
        VkImageCreateInfo image{};
        image.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO;
        image.imageType = VK_IMAGE_TYPE_2D;
        image.format = static_cast<VkFormat>(info->format);
        image.extent = {info->width, info->height, 1};
        image.mipLevels = 1;
        image.arrayLayers = info->arraySize;
        image.samples = VK_SAMPLE_COUNT_1_BIT;
        image.tiling = VK_IMAGE_TILING_OPTIMAL;
        image.usage = VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
        image.usage |= image.format == VK_FORMAT_D32_SFLOAT ? VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT
                                                            : VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
        vkCreateImage(state.device, &image, nullptr, &chain->images[i]);
        VkMemoryRequirements needs{};
        vkGetImageMemoryRequirements(state.device, chain->images[i], &needs);
        VkMemoryAllocateInfo allocate{};
        allocate.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
        allocate.allocationSize = needs.size;
        while ((needs.memoryTypeBits >> allocate.memoryTypeIndex & 1) == 0)
            ++allocate.memoryTypeIndex;
        vkAllocateMemory(state.device, &allocate, nullptr, &chain->memories[i]);
        vkBindImageMemory(state.device, chain->images[i], chain->memories[i], 0);
    }
    ++state.alive;
    *swapchain = reinterpret_cast<XrSwapchain>(chain);
    return XR_SUCCESS;
}

XrResult xrDestroySwapchain(XrSwapchain swapchain) {
    auto* const chain = reinterpret_cast<FakeSwapchain*>(swapchain);
    for (std::uint32_t i = 0; i < kImages; ++i) {
        vkDestroyImage(chain->device, chain->images[i], nullptr);
        vkFreeMemory(chain->device, chain->memories[i], nullptr);
    }
    delete chain;
    --state.alive;
    return XR_SUCCESS;
}

XrResult xrEnumerateSwapchainImages(XrSwapchain swapchain, std::uint32_t capacity, std::uint32_t* count,
                                    XrSwapchainImageBaseHeader* out) {
    REVISIT_ASK;
    *count = kImages;
    const auto& images = reinterpret_cast<FakeSwapchain*>(swapchain)->images;
    for (std::uint32_t i = 0; capacity > 0 && i < kImages; ++i)
        reinterpret_cast<XrSwapchainImageVulkan2KHR*>(out)[i].image = images[i];
    return XR_SUCCESS;
}

XrResult xrAcquireSwapchainImage(XrSwapchain swapchain, const XrSwapchainImageAcquireInfo*, std::uint32_t* index) {
    REVISIT_ASK;
    std::uint32_t& next = reinterpret_cast<FakeSwapchain*>(swapchain)->next;
    *index = next;
    next = (next + 1) % kImages;
    return XR_SUCCESS;
}

XrResult xrWaitSwapchainImage(XrSwapchain, const XrSwapchainImageWaitInfo*) {
    REVISIT_ASK;
    return XR_SUCCESS;
}

XrResult xrReleaseSwapchainImage(XrSwapchain, const XrSwapchainImageReleaseInfo*) {
    REVISIT_ASK;
    return XR_SUCCESS;
}

XrResult xrPollEvent(XrInstance, XrEventDataBuffer* event) {
    REVISIT_ASK;
    if (says("recentred") && !state.hasRecentred) {
        state.hasRecentred = true;
        auto& change = *reinterpret_cast<XrEventDataReferenceSpaceChangePending*>(event);
        change = {};
        change.type = XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING;
        change.session = state.session;
        change.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
        change.changeTime = state.time;
        return XR_SUCCESS;
    }
    if (state.states.empty()) return XR_EVENT_UNAVAILABLE;
    auto& change = *reinterpret_cast<XrEventDataSessionStateChanged*>(event);
    const XrSessionState next = state.states.front();
    state.states.pop_front();
    change = {XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED, nullptr, state.session, next, state.time};
    return XR_SUCCESS;
}

XrResult xrBeginSession(XrSession, const XrSessionBeginInfo*) {
    REVISIT_ASK;
    state.states = {XR_SESSION_STATE_SYNCHRONIZED, XR_SESSION_STATE_VISIBLE, XR_SESSION_STATE_FOCUSED};
    return XR_SUCCESS;
}

XrResult xrRequestExitSession(XrSession) {
    state.states.push_back(XR_SESSION_STATE_STOPPING);
    return XR_SUCCESS;
}

XrResult xrEndSession(XrSession) {
    REVISIT_ASK;
    state.states = {XR_SESSION_STATE_IDLE, XR_SESSION_STATE_EXITING};
    return XR_SUCCESS;
}

XrResult xrWaitFrame(XrSession, const XrFrameWaitInfo*, XrFrameState* frame) {
    REVISIT_ASK;
    state.time += says("late") ? 29000000 : 10000000;
    frame->predictedDisplayTime = state.time;
    frame->predictedDisplayPeriod = says("late") ? 20000000 : 10000000; // some tell of their own pace then
    frame->shouldRender = XR_TRUE;
    return XR_SUCCESS;
}

XrResult xrGetDisplayRefreshRateFB(XrSession, float* hertz) {
    *hertz = 100;
    return XR_SUCCESS;
}

XrResult xrBeginFrame(XrSession, const XrFrameBeginInfo*) {
    REVISIT_ASK;
    return XR_SUCCESS;
}

XrResult xrEndFrame(XrSession, const XrFrameEndInfo* info) {
    REVISIT_ASK;
    if (info->layerCount > 0)
        state.shown =
            reinterpret_cast<const XrCompositionLayerProjection*>(info->layers[0])->views[1].subImage.imageRect;
    return XR_SUCCESS;
}

/// The head rises with time, so that another place is another time.
XrPosef headNow() {
    return {{0, 0, 0, 1}, {0, static_cast<float>(state.time) * 1e-10f, 0}};
}

XrResult xrLocateViews(XrSession, const XrViewLocateInfo*, XrViewState* view, std::uint32_t capacity,
                       std::uint32_t* count, XrView* views) {
    REVISIT_ASK;
    *count = viewCount();
    if (capacity < *count) return capacity == 0 ? XR_SUCCESS : XR_ERROR_SIZE_INSUFFICIENT;
    view->viewStateFlags =
        says("untracked") ? 0 : XR_VIEW_STATE_POSITION_VALID_BIT | XR_VIEW_STATE_ORIENTATION_VALID_BIT;
    for (std::uint32_t i = 0; i < *count; ++i) {
        views[i].pose = headNow();
        views[i].pose.position.x = (static_cast<float>(i) - 0.5f) * 0.063f;
        views[i].fov = {-0.7f, 0.7f, 0.6f, -0.6f};
    }
    return XR_SUCCESS;
}

XrResult xrLocateSpace(XrSpace, XrSpace, XrTime, XrSpaceLocation* location) {
    REVISIT_ASK;
    location->locationFlags =
        says("untracked") ? 0 : XR_SPACE_LOCATION_POSITION_VALID_BIT | XR_SPACE_LOCATION_ORIENTATION_VALID_BIT;
    location->pose = headNow();
    return XR_SUCCESS;
}

// Hands that never have the focus.

XrResult xrStringToPath(XrInstance, const char*, XrPath* path) {
    *path = 1;
    return XR_SUCCESS;
}

XrResult xrCreateActionSet(XrInstance, const XrActionSetCreateInfo*, XrActionSet* set) {
    REVISIT_ASK;
    *set = made<XrActionSet>();
    return XR_SUCCESS;
}

XrResult xrDestroyActionSet(XrActionSet set) {
    return destroyed(set);
}

/// Goes with its set.
XrResult xrCreateAction(XrActionSet, const XrActionCreateInfo*, XrAction* action) {
    static char one;
    *action = reinterpret_cast<XrAction>(&one);
    return XR_SUCCESS;
}

XrResult xrSuggestInteractionProfileBindings(XrInstance, const XrInteractionProfileSuggestedBinding*) {
    return XR_SUCCESS;
}

XrResult xrAttachSessionActionSets(XrSession, const XrSessionActionSetsAttachInfo*) {
    REVISIT_ASK;
    return XR_SUCCESS;
}

XrResult xrCreateActionSpace(XrSession, const XrActionSpaceCreateInfo*, XrSpace* space) {
    REVISIT_ASK;
    *space = made<XrSpace>();
    return XR_SUCCESS;
}

XrResult xrSyncActions(XrSession, const XrActionsSyncInfo*) {
    REVISIT_ASK;
    return XR_SESSION_NOT_FOCUSED;
}

XrResult xrGetInstanceProcAddr(XrInstance, const char* name, PFN_xrVoidFunction* function) {
#define REVISIT_ROW(call)                                                                                              \
    { #call, reinterpret_cast < PFN_xrVoidFunction>(call) }
    // clang-format off
    static const std::map<std::string, PFN_xrVoidFunction> all{
        REVISIT_ROW(xrEnumerateInstanceExtensionProperties), REVISIT_ROW(xrGetInstanceProcAddr),
        REVISIT_ROW(xrCreateInstance), REVISIT_ROW(xrDestroyInstance), REVISIT_ROW(xrGetInstanceProperties),
        REVISIT_ROW(xrGetSystem), REVISIT_ROW(xrGetSystemProperties), REVISIT_ROW(xrEnumerateViewConfigurationViews),
        REVISIT_ROW(xrGetVulkanGraphicsRequirements2KHR), REVISIT_ROW(xrCreateVulkanInstanceKHR),
        REVISIT_ROW(xrGetVulkanGraphicsDevice2KHR), REVISIT_ROW(xrCreateVulkanDeviceKHR),
        REVISIT_ROW(xrCreateSession), REVISIT_ROW(xrDestroySession), REVISIT_ROW(xrEnumerateReferenceSpaces),
        REVISIT_ROW(xrCreateReferenceSpace), REVISIT_ROW(xrDestroySpace), REVISIT_ROW(xrEnumerateSwapchainFormats),
        REVISIT_ROW(xrCreateSwapchain), REVISIT_ROW(xrDestroySwapchain), REVISIT_ROW(xrEnumerateSwapchainImages),
        REVISIT_ROW(xrAcquireSwapchainImage), REVISIT_ROW(xrWaitSwapchainImage), REVISIT_ROW(xrReleaseSwapchainImage),
        REVISIT_ROW(xrPollEvent), REVISIT_ROW(xrGetDisplayRefreshRateFB), REVISIT_ROW(xrBeginSession),
        REVISIT_ROW(xrRequestExitSession), REVISIT_ROW(xrEndSession), REVISIT_ROW(xrWaitFrame),
        REVISIT_ROW(xrBeginFrame), REVISIT_ROW(xrEndFrame), REVISIT_ROW(xrLocateViews), REVISIT_ROW(xrStringToPath),
        REVISIT_ROW(xrCreateActionSet), REVISIT_ROW(xrDestroyActionSet), REVISIT_ROW(xrCreateAction),
        REVISIT_ROW(xrSuggestInteractionProfileBindings), REVISIT_ROW(xrAttachSessionActionSets),
        REVISIT_ROW(xrCreateActionSpace), REVISIT_ROW(xrSyncActions), REVISIT_ROW(xrLocateSpace)};
    // clang-format on
#undef REVISIT_ROW
    const auto found = all.find(name);
    *function = found == all.end() ? nullptr : found->second;
    return found == all.end() ? XR_ERROR_FUNCTION_UNSUPPORTED : XR_SUCCESS;
}

} // namespace

extern "C" {

__attribute__((visibility("default"))) XrResult xrNegotiateLoaderRuntimeInterface(const NegotiateLoaderInfo*,
                                                                                  NegotiateRuntimeRequest* request) {
    request->runtimeInterfaceVersion = 1;
    request->runtimeApiVersion = XR_CURRENT_API_VERSION;
    request->getInstanceProcAddr = xrGetInstanceProcAddr;
    return XR_SUCCESS;
}

__attribute__((visibility("default"))) void fakeRuntimeShown(XrRect2Di* shown) {
    *shown = state.shown;
}

__attribute__((visibility("default"))) int fakeRuntimeAlive() {
    return state.alive;
}
}
