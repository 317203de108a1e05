#include "xr/runtime.h"

#include "scene/errors.h"
#include "xr/check.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

namespace xr {

namespace {

constexpr const char* kGetARuntime =
    "start the headset's software and make it the active OpenXR runtime, or walk without: --headless";

/// Wanted where offered; the first is needed.
constexpr const char* kExtensions[] = {XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME,
                                       XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME,
                                       XR_KHR_VISIBILITY_MASK_EXTENSION_NAME,
                                       XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME,
                                       "XR_EXT_hand_interaction", // newer than Debian's headers
                                       "XR_EXT_local_floor"};

std::vector<XrExtensionProperties> listExtensions() {
    std::uint32_t count = 0;
    const XrResult result = xrEnumerateInstanceExtensionProperties(nullptr, 0, &count, nullptr);
    if (XR_FAILED(result))
        throw scene::Failure("no OpenXR runtime answers", std::string("OpenXR loader"), kGetARuntime);
    std::vector<XrExtensionProperties> extensions(count, {XR_TYPE_EXTENSION_PROPERTIES, nullptr, {}, 0});
    check(xrEnumerateInstanceExtensionProperties(nullptr, count, &count, extensions.data()),
          "xrEnumerateInstanceExtensionProperties");
    return extensions;
}

} // namespace

void hushLoader() {
    setenv("XR_LOADER_DEBUG", "none", 0);
}

Runtime::Runtime() {
    try {
        makeInstance();
        findSystem();
    } catch (const Lost& lost) {
        if (instance_ != XR_NULL_HANDLE) xrDestroyInstance(instance_);
        throw scene::Failure(lost.what(), std::string("OpenXR runtime"), kGetARuntime);
    } catch (...) {
        if (instance_ != XR_NULL_HANDLE) xrDestroyInstance(instance_);
        throw;
    }
}

Runtime::~Runtime() {
    xrDestroyInstance(instance_);
}

bool Runtime::has(const char* extension) const {
    return std::find(extensions_.begin(), extensions_.end(), extension) != extensions_.end();
}

void Runtime::makeInstance() {
    const std::vector<XrExtensionProperties> offered = listExtensions();
    std::vector<const char*> names;
    for (const char* wanted : kExtensions)
        if (std::any_of(offered.begin(), offered.end(),
                        [&](const XrExtensionProperties& e) { return std::strcmp(e.extensionName, wanted) == 0; })) {
            names.push_back(wanted);
            extensions_.emplace_back(wanted);
        }
    if (!has(XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME))
        throw scene::Failure("the runtime has no Vulkan (XR_KHR_vulkan_enable2)", std::string("OpenXR runtime"),
                             "update the runtime, or make another one active");

    XrInstanceCreateInfo info{};
    info.type = XR_TYPE_INSTANCE_CREATE_INFO;
    std::strncpy(info.applicationInfo.applicationName, "revisit", XR_MAX_APPLICATION_NAME_SIZE - 1);
    info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
    info.enabledExtensionCount = static_cast<std::uint32_t>(names.size());
    info.enabledExtensionNames = names.data();
    check(xrCreateInstance(&info, &instance_), "xrCreateInstance");

    XrInstanceProperties properties{};
    properties.type = XR_TYPE_INSTANCE_PROPERTIES;
    check(xrGetInstanceProperties(instance_, &properties), "xrGetInstanceProperties");
    name_ = properties.runtimeName;
}

void Runtime::findSystem() {
    XrSystemGetInfo get{};
    get.type = XR_TYPE_SYSTEM_GET_INFO;
    get.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
    const XrResult result = xrGetSystem(instance_, &get, &system_);
    if (result == XR_ERROR_FORM_FACTOR_UNAVAILABLE || result == XR_ERROR_FORM_FACTOR_UNSUPPORTED)
        throw scene::Failure("no headset is connected", name_, kGetARuntime);
    check(result, "xrGetSystem");
    XrSystemProperties properties{};
    properties.type = XR_TYPE_SYSTEM_PROPERTIES;
    check(xrGetSystemProperties(instance_, system_, &properties), "xrGetSystemProperties");
    name_ += std::string(", ") + properties.systemName;

    constexpr XrViewConfigurationType kTwoViews = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
    std::uint32_t count = 0;
    if (xrEnumerateViewConfigurationViews(instance_, system_, kTwoViews, 0, &count, nullptr) != XR_SUCCESS ||
        count != 2)
        throw scene::Failure("the headset has no two views, one for each eye", name_,
                             "choose a stereo headset in the runtime's settings");
    std::vector<XrViewConfigurationView> views(count, {XR_TYPE_VIEW_CONFIGURATION_VIEW, nullptr, 0, 0, 0, 0, 0, 0});
    check(xrEnumerateViewConfigurationViews(instance_, system_, kTwoViews, count, &count, views.data()),
          "xrEnumerateViewConfigurationViews");
    for (const XrViewConfigurationView& view : views) {
        width_ = std::max(width_, static_cast<int>(view.recommendedImageRectWidth));
        height_ = std::max(height_, static_cast<int>(view.recommendedImageRectHeight));
    }

    // Must be asked for before a session is made; any version will do that has what the renderer checks itself.
    XrGraphicsRequirementsVulkan2KHR requirements{};
    requirements.type = XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN2_KHR;
    check(load<PFN_xrGetVulkanGraphicsRequirements2KHR>("xrGetVulkanGraphicsRequirements2KHR")(instance_, system_,
                                                                                               &requirements),
          "xrGetVulkanGraphicsRequirements2KHR");
}

PFN_xrVoidFunction Runtime::load(const char* name) const {
    PFN_xrVoidFunction function = nullptr;
    check(xrGetInstanceProcAddr(instance_, name, &function), name);
    return function;
}

VkResult Runtime::makeVulkanInstance(PFN_vkGetInstanceProcAddr loadVulkan, const VkInstanceCreateInfo& info,
                                     VkInstance& made) const {
    XrVulkanInstanceCreateInfoKHR create{};
    create.type = XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR;
    create.systemId = system_;
    create.pfnGetInstanceProcAddr = loadVulkan;
    create.vulkanCreateInfo = &info;
    VkResult result = VK_SUCCESS;
    check(load<PFN_xrCreateVulkanInstanceKHR>("xrCreateVulkanInstanceKHR")(instance_, &create, &made, &result),
          "xrCreateVulkanInstanceKHR");
    return result;
}

VkPhysicalDevice Runtime::findPhysicalDevice(VkInstance vulkan) const {
    XrVulkanGraphicsDeviceGetInfoKHR get{};
    get.type = XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR;
    get.systemId = system_;
    get.vulkanInstance = vulkan;
    VkPhysicalDevice found = VK_NULL_HANDLE;
    check(load<PFN_xrGetVulkanGraphicsDevice2KHR>("xrGetVulkanGraphicsDevice2KHR")(instance_, &get, &found),
          "xrGetVulkanGraphicsDevice2KHR");
    return found;
}

VkResult Runtime::makeVulkanDevice(PFN_vkGetInstanceProcAddr loadVulkan, VkPhysicalDevice physical,
                                   const VkDeviceCreateInfo& info, VkDevice& made) const {
    XrVulkanDeviceCreateInfoKHR create{};
    create.type = XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR;
    create.systemId = system_;
    create.pfnGetInstanceProcAddr = loadVulkan;
    create.vulkanPhysicalDevice = physical;
    create.vulkanCreateInfo = &info;
    VkResult result = VK_SUCCESS;
    check(load<PFN_xrCreateVulkanDeviceKHR>("xrCreateVulkanDeviceKHR")(instance_, &create, &made, &result),
          "xrCreateVulkanDeviceKHR");
    return result;
}

} // namespace xr
