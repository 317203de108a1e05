#include "tests/xr/headset_rig.h"

#include <cstdlib>

#include <unistd.h>

namespace xr {

void enter(const Monado& monado) {
    const std::vector<std::string> variables = monado.environment();
    clearenv();
    for (const std::string& variable : variables) {
        const std::size_t equals = variable.find('=');
        setenv(variable.substr(0, equals).c_str(), variable.substr(equals + 1).c_str(), 1);
    }
}

HeadsetRig::HeadsetRig() : runtime_(std::make_unique<Runtime>()) {
    render::DeviceMaker maker;
    maker.makeInstance = [this](PFN_vkGetInstanceProcAddr load, const VkInstanceCreateInfo& info, VkInstance& made) {
        return runtime_->makeVulkanInstance(load, info, made);
    };
    maker.findPhysical = [this](VkInstance instance) { return runtime_->findPhysicalDevice(instance); };
    maker.makeDevice = [this](PFN_vkGetInstanceProcAddr load, VkPhysicalDevice physical, const VkDeviceCreateInfo& info,
                              VkDevice& made) { return runtime_->makeVulkanDevice(load, physical, info, made); };
    device_ = std::make_unique<render::Device>(maker);
    headset_ = std::make_unique<Headset>(
        *runtime_, VulkanHandles{device_->instance(), device_->physical(), *device_, device_->queueFamily()});
}

std::optional<Frame> HeadsetRig::nextDrawn() {
    while (true) {
        const Frame frame = headset_->begin();
        if (frame.kind == Frame::Kind::draw) return frame;
        if (frame.kind != Frame::Kind::skip) return std::nullopt;
    }
}

} // namespace xr
