#include "render/device.h"

#include "render/check.h"
#include "render/device_choice.h"
#include "render/pipeline.h"
#include "scene/errors.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <string_view>

namespace render {

namespace {

constexpr const char* kGetADevice =
    "install a Vulkan 1.2 driver; without a graphics card the processor will do (Debian: "
    "mesa-vulkan-drivers)";

bool instanceHas(const char* extension) {
    std::uint32_t count = 0;
    check(vkEnumerateInstanceExtensionProperties(nullptr, &count, nullptr));
    std::vector<VkExtensionProperties> extensions(count);
    check(vkEnumerateInstanceExtensionProperties(nullptr, &count, extensions.data()));
    return std::any_of(extensions.begin(), extensions.end(),
                       [&](const VkExtensionProperties& e) { return std::strcmp(e.extensionName, extension) == 0; });
}

} // namespace

Device::Device(const DeviceMaker& maker) : pipelines_(std::make_unique<PipelineStore>()) {
    try {
        createInstance(maker);
        choosePhysical(maker);
        createDevice(maker);
        describeDevice();
    } catch (...) {
        destroy();
        throw;
    }
}

Device::~Device() {
    destroy();
}

void Device::destroy() {
    pipelines_.reset();
    if (device_ != VK_NULL_HANDLE) vkDestroyDevice(device_, nullptr);
    if (messenger_ != VK_NULL_HANDLE) vkDestroyDebugUtilsMessengerEXT(instance_, messenger_, nullptr);
    if (instance_ != VK_NULL_HANDLE) vkDestroyInstance(instance_, nullptr);
}

void Device::createInstance(const DeviceMaker& maker) {
    if (volkInitialize() != VK_SUCCESS)
        throw scene::Failure("there is no Vulkan on this machine", std::string("Vulkan loader"), kGetADevice);

    VkApplicationInfo application{};
    application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
    application.pApplicationName = "revisit";
    application.apiVersion = VK_API_VERSION_1_2;

    const bool canHear = instanceHas(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    std::vector<const char*> extensions = maker.instanceExtensions;
    if (canHear) extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    VkInstanceCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
    info.pApplicationInfo = &application;
    info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
    info.ppEnabledExtensionNames = extensions.data();
    const VkResult result = maker.makeInstance ? maker.makeInstance(vkGetInstanceProcAddr, info, instance_)
                                               : vkCreateInstance(&info, nullptr, &instance_);
    if (result != VK_SUCCESS) {
        if (result == VK_ERROR_INCOMPATIBLE_DRIVER)
            throw scene::Failure("no Vulkan driver was found", std::string("Vulkan loader"), kGetADevice);
        check(result);
    }
    volkLoadInstance(instance_);

    if (!canHear) return;
    VkDebugUtilsMessengerCreateInfoEXT ear{};
    ear.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT;
    ear.messageSeverity =
        VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    ear.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    ear.pfnUserCallback = hear;
    ear.pUserData = this;
    check(vkCreateDebugUtilsMessengerEXT(instance_, &ear, nullptr, &messenger_));
}

void Device::choosePhysical(const DeviceMaker& maker) {
    const char* environment = std::getenv("REVISIT_DEVICE");
    const std::string nameContains = environment != nullptr ? environment : "";
    std::vector<Candidate> candidates = findCandidates(instance_);
    if (maker.findPhysical) {
        // The runtime's word is final: what is not on that device cannot reach the headset.
        const VkPhysicalDevice wanted = maker.findPhysical(instance_);
        std::erase_if(candidates, [&](const Candidate& candidate) { return candidate.handle != wanted; });
    }
    const std::optional<std::size_t> chosen = chooseCandidate(candidates, nameContains);
    if (!chosen)
        throw scene::Failure("no graphics device can draw: " + describe(candidates, nameContains),
                             std::string("Vulkan"),
                             nameContains.empty() ? kGetADevice : "change or unset REVISIT_DEVICE");
    passedOver_ = describePassedOver(candidates, *chosen, nameContains);
    physical_ = candidates[*chosen].handle;
    queueFamily_ = candidates[*chosen].queueFamily;
}

void Device::createDevice(const DeviceMaker& maker) {
    const float priority = 1;
    VkDeviceQueueCreateInfo queues{};
    queues.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
    queues.queueFamilyIndex = queueFamily_;
    queues.queueCount = 1;
    queues.pQueuePriorities = &priority;

    // Not all of Vulkan 1.2's features in one: runtimes of headsets add structures of their own for single ones, and
    // both together are not allowed.
    VkPhysicalDeviceShaderAtomicInt64Features atomics{};
    atomics.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_ATOMIC_INT64_FEATURES;
    atomics.shaderBufferInt64Atomics = VK_TRUE;
    VkPhysicalDeviceFeatures2 features{};
    features.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
    features.pNext = &atomics;
    features.features.shaderInt64 = VK_TRUE;

    VkDeviceCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
    info.pNext = &features;
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queues;
    info.enabledExtensionCount = static_cast<std::uint32_t>(maker.deviceExtensions.size());
    info.ppEnabledExtensionNames = maker.deviceExtensions.data();
    check(maker.makeDevice ? maker.makeDevice(vkGetInstanceProcAddr, physical_, info, device_)
                           : vkCreateDevice(physical_, &info, nullptr, &device_));
    vkGetDeviceQueue(device_, queueFamily_, 0, &queue_);
}

void Device::describeDevice() {
    VkPhysicalDeviceVulkan12Properties properties12{};
    properties12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_PROPERTIES;
    VkPhysicalDeviceVulkan11Properties properties11{};
    properties11.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES;
    properties11.pNext = &properties12;
    VkPhysicalDeviceProperties2 properties{};
    properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
    properties.pNext = &properties11;
    vkGetPhysicalDeviceProperties2(physical_, &properties);
    properties_ = properties.properties;
    name_ = properties_.deviceName;
    driver_ = std::string(properties12.driverName) + " " + properties12.driverInfo;
    subgroupSize_ = static_cast<int>(properties11.subgroupSize);
    const char* set = std::getenv("REVISIT_TUNING");
    const std::string_view tuning = set != nullptr ? set : "";
    isProcessor_ = properties_.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU && tuning != "card";
    looksAlways_ = tuning == "looks";
    vkGetPhysicalDeviceMemoryProperties(physical_, &memory_);

    std::uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(physical_, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(physical_, &count, families.data());
    timestampBits_ = families[queueFamily_].timestampValidBits;
}

std::uint32_t Device::workgroupSize(std::uint32_t onCards) const {
    if (isProcessor_) return static_cast<std::uint32_t>(subgroupSize_);
    return std::min({onCards, limits().maxComputeWorkGroupInvocations, limits().maxComputeWorkGroupSize[0]});
}

std::uint32_t Device::memoryType(std::uint32_t typeBits, VkMemoryPropertyFlags wanted,
                                 VkMemoryPropertyFlags liked) const {
    for (const VkMemoryPropertyFlags flags : {wanted | liked, wanted})
        for (std::uint32_t type = 0; type < memory_.memoryTypeCount; ++type)
            if ((typeBits >> type & 1u) != 0 && (memoryFlags(type) & flags) == flags) return type;
    throw scene::Failure("the device has no memory of the kind needed", name_, "update the graphics driver");
}

std::size_t Device::roomBytes() const {
    std::uint32_t count = 0;
    check(vkEnumerateDeviceExtensionProperties(physical_, nullptr, &count, nullptr));
    std::vector<VkExtensionProperties> extensions(count);
    check(vkEnumerateDeviceExtensionProperties(physical_, nullptr, &count, extensions.data()));
    const bool isTold = std::any_of(extensions.begin(), extensions.end(), [](const VkExtensionProperties& e) {
        return std::strcmp(e.extensionName, VK_EXT_MEMORY_BUDGET_EXTENSION_NAME) == 0;
    });
    VkPhysicalDeviceMemoryBudgetPropertiesEXT budget{};
    budget.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_BUDGET_PROPERTIES_EXT;
    VkPhysicalDeviceMemoryProperties2 memory{};
    memory.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_PROPERTIES_2;
    if (isTold) memory.pNext = &budget;
    vkGetPhysicalDeviceMemoryProperties2(physical_, &memory);
    VkDeviceSize room = 0;
    for (std::uint32_t heap = 0; heap < memory.memoryProperties.memoryHeapCount; ++heap) {
        if ((memory.memoryProperties.memoryHeaps[heap].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) == 0) continue;
        const VkDeviceSize size = memory.memoryProperties.memoryHeaps[heap].size, granted = budget.heapBudget[heap],
                           used = budget.heapUsage[heap];
        room = std::max(room, isTold ? granted - std::min(granted, used) : size);
    }
    return room;
}

std::vector<std::string> Device::validationMessages() const {
    const std::scoped_lock lock(heardMutex_);
    return heard_;
}

VkBool32 Device::hear(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                      const VkDebugUtilsMessengerCallbackDataEXT* message, void* device) {
    auto& self = *static_cast<Device*>(device);
    const std::scoped_lock lock(self.heardMutex_);
    self.heard_.emplace_back(message->pMessage);
    return VK_FALSE;
}

} // namespace render
