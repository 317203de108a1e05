// A Vulkan layer that makes any device a faulty one, for tests of programs: the loader puts it between the program and
// the driver (VK_LAYER_PATH, VK_INSTANCE_LAYERS). What fails is told by the environment:
//
//   REVISIT_FAULT_LOSE    numbers, with commas: which of the process' submits, from 1 on, lose their device. A lost
//                         device stays lost until it is destroyed
//   REVISIT_FAULT_MEMORY  bytes that a device has in all
//   REVISIT_FAULT_ROOM    bytes that it says it has
//   REVISIT_FAULT_LACKS   set: 64-bit atomics
//   REVISIT_FAULT_TELL    file that is told, when a device is destroyed: submits of the process, most bytes at a time
//
// One device at a time, as the programs have it.

#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <mutex>
#include <set>
#include <sstream>
#include <string>

namespace {

PFN_vkGetInstanceProcAddr nextInstance = nullptr;
PFN_vkGetDeviceProcAddr nextDevice = nullptr;
PFN_vkGetPhysicalDeviceFeatures2 nextFeatures = nullptr;
PFN_vkGetPhysicalDeviceMemoryProperties2 nextMemory = nullptr;
VkInstance instance = VK_NULL_HANDLE;
VkDevice device = VK_NULL_HANDLE;
std::mutex mutex;
bool isLost = false;
std::uint64_t submits = 0, bytes = 0, mostBytes = 0;
std::map<VkDeviceMemory, std::uint64_t> sizes;

template <class Function>
Function ofDevice(const char* name) {
    return reinterpret_cast<Function>(nextDevice(device, name));
}

std::string told(const char* name) {
    const char* const value = std::getenv(name);
    return value != nullptr ? value : "";
}

bool losesAt(std::uint64_t submit) {
    std::istringstream list(told("REVISIT_FAULT_LOSE"));
    std::string number;
    while (std::getline(list, number, ','))
        if (std::stoull(number) == submit) return true;
    return false;
}

/// Nothing may still run when a lost device's buffers go.
VkResult afterIdle(VkResult result) {
    ofDevice<PFN_vkDeviceWaitIdle>("vkDeviceWaitIdle")(device);
    return result;
}

bool isGone() {
    const std::scoped_lock lock(mutex);
    return isLost;
}

VkResult VKAPI_PTR createInstance(const VkInstanceCreateInfo* info, const VkAllocationCallbacks* allocator,
                                  VkInstance* made) {
    auto* link = static_cast<VkLayerInstanceCreateInfo*>(const_cast<void*>(info->pNext));
    while (link != nullptr &&
           (link->sType != VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO || link->function != VK_LAYER_LINK_INFO))
        link = static_cast<VkLayerInstanceCreateInfo*>(const_cast<void*>(link->pNext));
    if (link == nullptr) return VK_ERROR_INITIALIZATION_FAILED;
    nextInstance = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    const auto create = reinterpret_cast<PFN_vkCreateInstance>(nextInstance(VK_NULL_HANDLE, "vkCreateInstance"));
    const VkResult result = create(info, allocator, made);
    if (result != VK_SUCCESS) return result;
    instance = *made;
    // Asked for later, the loader names the first layer's.
    nextFeatures =
        reinterpret_cast<PFN_vkGetPhysicalDeviceFeatures2>(nextInstance(instance, "vkGetPhysicalDeviceFeatures2"));
    nextMemory = reinterpret_cast<PFN_vkGetPhysicalDeviceMemoryProperties2>(
        nextInstance(instance, "vkGetPhysicalDeviceMemoryProperties2"));
    return result;
}

VkResult VKAPI_PTR createDevice(VkPhysicalDevice physical, const VkDeviceCreateInfo* info,
                                const VkAllocationCallbacks* allocator, VkDevice* made) {
    auto* link = static_cast<VkLayerDeviceCreateInfo*>(const_cast<void*>(info->pNext));
    while (link != nullptr &&
           (link->sType != VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO || link->function != VK_LAYER_LINK_INFO))
        link = static_cast<VkLayerDeviceCreateInfo*>(const_cast<void*>(link->pNext));
    if (link == nullptr) return VK_ERROR_INITIALIZATION_FAILED;
    const PFN_vkGetInstanceProcAddr load = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    nextDevice = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    const auto create = reinterpret_cast<PFN_vkCreateDevice>(load(instance, "vkCreateDevice"));
    const VkResult result = create(physical, info, allocator, made);
    if (result != VK_SUCCESS) return result;
    const std::scoped_lock lock(mutex);
    device = *made;
    isLost = false;
    bytes = 0;
    sizes.clear();
    return result;
}

void VKAPI_PTR destroyDevice(VkDevice gone, const VkAllocationCallbacks* allocator) {
    if (const std::string file = told("REVISIT_FAULT_TELL"); !file.empty())
        std::ofstream(file) << submits << " " << mostBytes << "\n";
    ofDevice<PFN_vkDestroyDevice>("vkDestroyDevice")(gone, allocator);
}

void VKAPI_PTR getFeatures(VkPhysicalDevice physical, VkPhysicalDeviceFeatures2* features) {
    nextFeatures(physical, features);
    if (told("REVISIT_FAULT_LACKS").empty()) return;
    for (auto* next = static_cast<VkBaseOutStructure*>(features->pNext); next != nullptr; next = next->pNext)
        if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES)
            reinterpret_cast<VkPhysicalDeviceVulkan12Features*>(next)->shaderBufferInt64Atomics = VK_FALSE;
}

void VKAPI_PTR getMemory(VkPhysicalDevice physical, VkPhysicalDeviceMemoryProperties2* memory) {
    nextMemory(physical, memory);
    if (told("REVISIT_FAULT_ROOM").empty()) return;
    const std::uint64_t room = std::stoull(told("REVISIT_FAULT_ROOM"));
    for (std::uint32_t heap = 0; heap < memory->memoryProperties.memoryHeapCount; ++heap)
        memory->memoryProperties.memoryHeaps[heap].size = room;
    for (auto* next = static_cast<VkBaseOutStructure*>(memory->pNext); next != nullptr; next = next->pNext)
        if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_BUDGET_PROPERTIES_EXT)
            for (VkDeviceSize& budget : reinterpret_cast<VkPhysicalDeviceMemoryBudgetPropertiesEXT*>(next)->heapBudget)
                budget = room;
}

VkResult VKAPI_PTR submit(VkQueue queue, std::uint32_t count, const VkSubmitInfo* infos, VkFence fence) {
    {
        const std::scoped_lock lock(mutex);
        isLost = losesAt(++submits) || isLost;
    }
    if (isGone()) return afterIdle(VK_ERROR_DEVICE_LOST);
    return ofDevice<PFN_vkQueueSubmit>("vkQueueSubmit")(queue, count, infos, fence);
}

VkResult VKAPI_PTR waitForFences(VkDevice, std::uint32_t count, const VkFence* fences, VkBool32 all,
                                 std::uint64_t timeout) {
    if (isGone()) return afterIdle(VK_ERROR_DEVICE_LOST);
    return ofDevice<PFN_vkWaitForFences>("vkWaitForFences")(device, count, fences, all, timeout);
}

VkResult VKAPI_PTR getFenceStatus(VkDevice, VkFence fence) {
    if (isGone()) return afterIdle(VK_ERROR_DEVICE_LOST);
    return ofDevice<PFN_vkGetFenceStatus>("vkGetFenceStatus")(device, fence);
}

VkResult VKAPI_PTR waitIdle(VkDevice) {
    return afterIdle(isGone() ? VK_ERROR_DEVICE_LOST : VK_SUCCESS);
}

VkResult VKAPI_PTR allocate(VkDevice, const VkMemoryAllocateInfo* info, const VkAllocationCallbacks* allocator,
                            VkDeviceMemory* made) {
    const std::string limit = told("REVISIT_FAULT_MEMORY");
    const std::scoped_lock lock(mutex);
    if (!limit.empty() && bytes + info->allocationSize > std::stoull(limit)) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    const VkResult result = ofDevice<PFN_vkAllocateMemory>("vkAllocateMemory")(device, info, allocator, made);
    if (result != VK_SUCCESS) return result;
    sizes[*made] = info->allocationSize;
    bytes += info->allocationSize;
    mostBytes = std::max(mostBytes, bytes);
    return result;
}

void VKAPI_PTR freeMemory(VkDevice, VkDeviceMemory memory, const VkAllocationCallbacks* allocator) {
    const std::scoped_lock lock(mutex);
    if (const auto found = sizes.find(memory); found != sizes.end()) {
        bytes -= found->second;
        sizes.erase(found);
    }
    ofDevice<PFN_vkFreeMemory>("vkFreeMemory")(device, memory, allocator);
}

PFN_vkVoidFunction VKAPI_PTR getDeviceFunction(VkDevice of, const char* name);
PFN_vkVoidFunction VKAPI_PTR getInstanceFunction(VkInstance of, const char* name);

PFN_vkVoidFunction ours(const char* name) {
    static const std::map<std::string, PFN_vkVoidFunction> functions{
        {"vkCreateInstance", reinterpret_cast<PFN_vkVoidFunction>(createInstance)},
        {"vkCreateDevice", reinterpret_cast<PFN_vkVoidFunction>(createDevice)},
        {"vkDestroyDevice", reinterpret_cast<PFN_vkVoidFunction>(destroyDevice)},
        {"vkGetPhysicalDeviceFeatures2", reinterpret_cast<PFN_vkVoidFunction>(getFeatures)},
        {"vkGetPhysicalDeviceMemoryProperties2", reinterpret_cast<PFN_vkVoidFunction>(getMemory)},
        {"vkQueueSubmit", reinterpret_cast<PFN_vkVoidFunction>(submit)},
        {"vkWaitForFences", reinterpret_cast<PFN_vkVoidFunction>(waitForFences)},
        {"vkGetFenceStatus", reinterpret_cast<PFN_vkVoidFunction>(getFenceStatus)},
        {"vkDeviceWaitIdle", reinterpret_cast<PFN_vkVoidFunction>(waitIdle)},
        {"vkAllocateMemory", reinterpret_cast<PFN_vkVoidFunction>(allocate)},
        {"vkFreeMemory", reinterpret_cast<PFN_vkVoidFunction>(freeMemory)},
        {"vkGetDeviceProcAddr", reinterpret_cast<PFN_vkVoidFunction>(getDeviceFunction)},
        {"vkGetInstanceProcAddr", reinterpret_cast<PFN_vkVoidFunction>(getInstanceFunction)}};
    const auto found = functions.find(name);
    return found != functions.end() ? found->second : nullptr;
}

PFN_vkVoidFunction VKAPI_PTR getDeviceFunction(VkDevice of, const char* name) {
    const PFN_vkVoidFunction own = ours(name);
    if (own != nullptr) return own;
    return nextDevice != nullptr ? nextDevice(of, name) : nullptr;
}

PFN_vkVoidFunction VKAPI_PTR getInstanceFunction(VkInstance of, const char* name) {
    const PFN_vkVoidFunction own = ours(name);
    if (own != nullptr) return own;
    return nextInstance != nullptr ? nextInstance(of, name) : nullptr;
}

} // namespace

extern "C" __attribute__((visibility("default"))) VkResult VKAPI_PTR
vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface* versions) {
    versions->loaderLayerInterfaceVersion = std::min<std::uint32_t>(versions->loaderLayerInterfaceVersion, 2);
    versions->pfnGetInstanceProcAddr = getInstanceFunction;
    versions->pfnGetDeviceProcAddr = getDeviceFunction;
    versions->pfnGetPhysicalDeviceProcAddr = nullptr;
    return VK_SUCCESS;
}
