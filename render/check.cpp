#include "render/check.h"

#include <string>

namespace render {

namespace {

const char* nameOf(VkResult result) {
    switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
        return "out of host memory";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
        return "out of device memory";
    case VK_ERROR_INITIALIZATION_FAILED:
        return "initialisation failed";
    case VK_ERROR_DEVICE_LOST:
        return "device lost";
    case VK_ERROR_MEMORY_MAP_FAILED:
        return "memory map failed";
    case VK_ERROR_LAYER_NOT_PRESENT:
        return "layer not present";
    case VK_ERROR_EXTENSION_NOT_PRESENT:
        return "extension not present";
    case VK_ERROR_FEATURE_NOT_PRESENT:
        return "feature not present";
    case VK_ERROR_INCOMPATIBLE_DRIVER:
        return "incompatible driver";
    case VK_ERROR_OUT_OF_POOL_MEMORY:
        return "out of pool memory";
    default:
        return "failed";
    }
}

const char* remedyFor(VkResult result) {
    switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
    case VK_ERROR_MEMORY_MAP_FAILED:
        return "close other programs that use the device, or show a smaller scene";
    case VK_ERROR_DEVICE_LOST:
        return "update the driver, or choose another device with REVISIT_DEVICE";
    case VK_ERROR_LAYER_NOT_PRESENT:
        return "install the layer or unset VK_INSTANCE_LAYERS";
    default:
        return "update the graphics driver";
    }
}

} // namespace

void check(VkResult result, std::source_location asked) {
    if (result == VK_SUCCESS) return;
    const std::string file = asked.file_name();
    const std::string where = file.substr(file.find_last_of('/') + 1) + ", line " + std::to_string(asked.line());
    const std::string what =
        "Vulkan: " + std::string(nameOf(result)) + " (VkResult " + std::to_string(static_cast<int>(result)) + ")";
    switch (result) {
    case VK_ERROR_DEVICE_LOST:
        throw DeviceLost(what, where, remedyFor(result));
    case VK_ERROR_OUT_OF_HOST_MEMORY:
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
    case VK_ERROR_OUT_OF_POOL_MEMORY:
        throw OutOfMemory(what, where, remedyFor(result));
    default:
        throw scene::Failure(what, where, remedyFor(result));
    }
}

} // namespace render
