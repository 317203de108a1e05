#pragma once
// The graphics device: instance, the physical device chosen, its queue, and the ear for the validation layers.

#include <volk.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace render {

inline constexpr int kMaxEyes = 2;

/// Who makes the Vulkan objects where it is not us: an OpenXR runtime wants to add to them, and knows which device its
/// headset hangs on. Each function is given what we would have made ourselves.
struct DeviceMaker {
    std::function<VkResult(PFN_vkGetInstanceProcAddr, const VkInstanceCreateInfo&, VkInstance&)> makeInstance;
    std::function<VkPhysicalDevice(VkInstance)> findPhysical;
    std::function<VkResult(PFN_vkGetInstanceProcAddr, VkPhysicalDevice, const VkDeviceCreateInfo&, VkDevice&)>
        makeDevice;
    std::vector<const char*> instanceExtensions, deviceExtensions; ///< further ones, for windows
};

class PipelineStore;

/// Stays where it is: everything it makes points back at it, and must be gone before it.
class Device {
  public:
    /// Chooses discrete before integrated, virtual, processor; the environment variable REVISIT_DEVICE (part
    /// of a name) overrules. Throws scene::Failure if Vulkan or a fitting device is missing, naming each
    /// candidate and what it lacks. Functions that the maker leaves empty are Vulkan's own.
    explicit Device(const DeviceMaker& maker = {});
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    VkInstance instance() const { return instance_; }
    VkPhysicalDevice physical() const { return physical_; }
    VkDevice handle() const { return device_; }
    // It goes where Vulkan wants its own handle. NOLINTNEXTLINE(google-explicit-constructor)
    operator VkDevice() const { return device_; }

    std::uint32_t queueFamily() const { return queueFamily_; }
    /// All is submitted here, by one thread at a time. Eyes with a queue each are no faster: cards take turns between
    /// them, and what turns they take is not ours to say (docs/performance.md, A graphics card).
    VkQueue queue() const { return queue_; }

    const std::string& name() const { return name_; }
    /// Better devices that lack something: "NAME lacks WHAT"; empty if there are none.
    const std::string& passedOver() const { return passedOver_; }
    const std::string& driver() const { return driver_; } ///< name and version
    /// Whether the processor draws, and work is dealt out as suits it. With REVISIT_TUNING=card in the environment none
    /// does, so that what suits graphics cards can be tested without one.
    bool isProcessor() const { return isProcessor_; }
    /// Whether a processor looks for hidden tiles however few there are to draw (kLeastItemsToLook): with
    /// REVISIT_TUNING=looks, so that it can be tested in small scenes.
    bool looksAlways() const { return looksAlways_; }
    const VkPhysicalDeviceLimits& limits() const { return properties_.limits; }
    int subgroupSize() const { return subgroupSize_; }
    /// Invocations of a workgroup. A processor runs one vector by vector, and starts each anew: one vector that loops
    /// is cheapest. onCards: as many as a graphics card does well with, if it allows them.
    std::uint32_t workgroupSize(std::uint32_t onCards) const;
    bool hasTimestamps() const { return timestampBits_ > 0; }

    /// A memory type allowed by typeBits with all of wanted; the first that also has all of liked, if there
    /// is one.
    std::uint32_t memoryType(std::uint32_t typeBits, VkMemoryPropertyFlags wanted, VkMemoryPropertyFlags liked) const;
    VkMemoryPropertyFlags memoryFlags(std::uint32_t type) const { return memory_.memoryTypes[type].propertyFlags; }

    /// Bytes of the memory that is fast for the device which this program may take now: what the driver grants it
    /// (VK_EXT_memory_budget), or all there is where the driver does not say.
    std::size_t roomBytes() const;

    /// What it has compiled so far: pipelines live as long as the device, whoever draws by them.
    PipelineStore& pipelines() const { return *pipelines_; }

    /// Warnings and errors of the validation layers so far; always empty without them (VK_INSTANCE_LAYERS).
    std::vector<std::string> validationMessages() const;

  private:
    void createInstance(const DeviceMaker& maker);
    void createDevice(const DeviceMaker& maker);
    void choosePhysical(const DeviceMaker& maker);
    void describeDevice();
    void destroy();
    static VkBool32 VKAPI_PTR hear(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                   VkDebugUtilsMessageTypeFlagsEXT types,
                                   const VkDebugUtilsMessengerCallbackDataEXT* message, void* device);

    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    std::uint32_t queueFamily_ = 0, timestampBits_ = 0;
    VkPhysicalDeviceProperties properties_{};
    VkPhysicalDeviceMemoryProperties memory_{};
    std::string name_, driver_, passedOver_;
    int subgroupSize_ = 1;
    bool isProcessor_ = false, looksAlways_ = false;
    std::unique_ptr<PipelineStore> pipelines_;
    mutable std::mutex heardMutex_; ///< the layers may call from any thread
    std::vector<std::string> heard_;
};

} // namespace render
