#pragma once
// The OpenXR runtime of this machine, its headset, and how it wants Vulkan to be set up (XR_KHR_vulkan_enable2).

#include <volk.h>

#define XR_USE_GRAPHICS_API_VULKAN
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include <string>
#include <vector>

namespace xr {

/// OpenXR's loader tells each failure on stderr, in several lines, even where ours follows or none is due. From here on
/// it says nothing, unless the environment variable XR_LOADER_DEBUG wants it to. To be called before there are other
/// threads.
void hushLoader();

class Runtime {
  public:
    /// Throws scene::Failure if there is no runtime, it has no Vulkan, or no headset with two views.
    Runtime();
    ~Runtime();
    Runtime(const Runtime&) = delete;
    Runtime& operator=(const Runtime&) = delete;

    XrInstance instance() const { return instance_; }
    XrSystemId system() const { return system_; }
    const std::string& name() const { return name_; } ///< of runtime and headset
    bool has(const char* extension) const;
    /// What the runtime thinks good for each eye: the larger of the two where they differ.
    int recommendedWidth() const { return width_; }
    int recommendedHeight() const { return height_; }

    /// For whoever makes the Vulkan objects; as the runtime wants them. Throw as xr::check does.
    VkResult makeVulkanInstance(PFN_vkGetInstanceProcAddr load, const VkInstanceCreateInfo& info,
                                VkInstance& made) const;
    VkPhysicalDevice findPhysicalDevice(VkInstance instance) const;
    VkResult makeVulkanDevice(PFN_vkGetInstanceProcAddr load, VkPhysicalDevice physical, const VkDeviceCreateInfo& info,
                              VkDevice& made) const;

    /// A function of an extension that it has.
    template <class Function>
    Function load(const char* name) const {
        return reinterpret_cast<Function>(load(name));
    }

  private:
    PFN_xrVoidFunction load(const char* name) const;
    void makeInstance();
    void findSystem();

    XrInstance instance_ = XR_NULL_HANDLE;
    XrSystemId system_ = XR_NULL_SYSTEM_ID;
    std::vector<std::string> extensions_; ///< enabled
    std::string name_;
    int width_ = 0, height_ = 0;
};

} // namespace xr
