#include "app/walk_stage.h"

namespace app {

namespace {

/// Vulkan as the runtime wants it. xr and render do not know each other; here they meet.
render::DeviceMaker makerOf(const xr::Runtime& runtime) {
    render::DeviceMaker maker;
    maker.makeInstance = [&runtime](PFN_vkGetInstanceProcAddr load, const VkInstanceCreateInfo& info,
                                    VkInstance& made) { return runtime.makeVulkanInstance(load, info, made); };
    maker.findPhysical = [&runtime](VkInstance instance) { return runtime.findPhysicalDevice(instance); };
    maker.makeDevice = [&runtime](PFN_vkGetInstanceProcAddr load, VkPhysicalDevice physical,
                                  const VkDeviceCreateInfo& info,
                                  VkDevice& made) { return runtime.makeVulkanDevice(load, physical, info, made); };
    return maker;
}

} // namespace

WalkStage WalkStage::inHeadset(const scene::Scene& scene) {
    WalkStage stage;
    stage.runtime_ = std::make_unique<xr::Runtime>();
    stage.name_ = stage.runtime_->name();
    stage.device_ = std::make_unique<render::Device>(makerOf(*stage.runtime_));
    const render::Device& device = *stage.device_;
    auto headset = std::make_unique<xr::Headset>(
        *stage.runtime_, xr::VulkanHandles{device.instance(), device.physical(), device, device.queueFamily()});
    stage.headset_ = headset.get();
    stage.source_ = std::move(headset);
    stage.makeRenderer(scene);
    return stage;
}

WalkStage WalkStage::headless(const scene::Scene& scene, xr::Headless::Path path, const WalkOptions& options) {
    WalkStage stage;
    stage.name_ = "no display";
    stage.device_ = std::make_unique<render::Device>();
    xr::HeadlessOptions headless;
    headless.width = options.width, headless.height = options.height;
    headless.eyeDistanceMetres = options.draw.eyeDistanceMetres;
    headless.framesPerSecond = options.framesPerSecond;
    stage.source_ = std::make_unique<xr::Headless>(std::move(path), headless);
    stage.makeRenderer(scene);
    return stage;
}

void WalkStage::makeRenderer(const scene::Scene& scene) {
    gpuScene_ = std::make_unique<render::GpuScene>(*device_, scene.blocks);
    renderer_ = std::make_unique<render::Renderer>(*device_, *gpuScene_, source_->width(), source_->height(),
                                                   static_cast<int>(xr::kEyes));
}

bool WalkStage::requestEnd() {
    if (headset_ != nullptr) headset_->requestExit();
    return headset_ != nullptr;
}

} // namespace app
