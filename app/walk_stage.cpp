#include "app/walk_stage.h"

#include "app/coverage_on_device.h"
#include "app/device_trouble.h"

#include <cassert>
#include <cmath>
#include <cstdio>
#include <optional>

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

void WalkStage::makeDevice(const DrawnScene& drawn, const render::DeviceMaker& maker) {
    device_ = std::make_unique<render::Device>(maker);
    sayPassedOver(*device_);
    scene_ = &drawn.scene;
    on_ = bringTo(*device_, drawn);
}

void WalkStage::remakeDevice(const DrawnScene& drawn) {
    assert(headset_ == nullptr);
    renderers_ = {};
    on_ = {};
    device_.reset();
    isCold_ = true;
    makeDevice(drawn, {});
}

WalkStage WalkStage::inHeadset(const DrawnScene& drawn, std::unique_ptr<xr::Runtime> runtime) {
    WalkStage stage;
    stage.runtime_ = std::move(runtime);
    stage.name_ = stage.runtime_->name();
    stage.makeDevice(drawn, makerOf(*stage.runtime_));
    const render::Device& device = *stage.device_;
    stage.headset_ = std::make_unique<xr::Headset>(
        *stage.runtime_, xr::VulkanHandles{device.instance(), device.physical(), device, device.queueFamily()});
    stage.actions_ = std::make_unique<input::Actions>(
        stage.runtime_->instance(), [&](const char* extension) { return stage.runtime_->has(extension); });
    stage.actions_->attach(stage.headset_->session(), stage.headset_->trackingSpace());
    stage.source_ = stage.headset_.get();
    stage.rendererFor(stage.source());
    return stage;
}

WalkStage WalkStage::atDesk(const DrawnScene& drawn, xr::Desktop& desktop) {
    WalkStage stage;
    stage.name_ = "the desk";
    stage.makeDevice(drawn, {});
    stage.source_ = &desktop;
    return stage;
}

WalkStage WalkStage::headless(const DrawnScene& drawn, xr::Headless::Path path, const WalkOptions& options) {
    WalkStage stage;
    stage.name_ = "no display";
    stage.makeDevice(drawn, {});
    xr::HeadlessOptions headless;
    headless.width = options.width, headless.height = options.height;
    headless.eyeDistanceMetres = options.draw.eyeDistanceMetres;
    if (options.framesPerSecond > 0) headless.framesPerSecond = options.framesPerSecond;
    stage.headless_ = std::make_unique<xr::Headless>(std::move(path), headless);
    stage.source_ = stage.headless_.get();
    stage.rendererFor(stage.source());
    return stage;
}

render::Renderer& WalkStage::rendererFor(const xr::ViewSource& source) {
    std::unique_ptr<render::Renderer>& renderer = renderers_[&source == source_ ? 0 : 1];
    if (renderer != nullptr && renderer->width() == source.width() && renderer->height() == source.height() &&
        renderer->eyes() == source.eyes())
        return *renderer;
    renderer.reset(); // before the new one takes as much memory
    makeBeside(*device_, *scene_, on_.coverage, [&] {
        try {
            renderer = makeRenderer(source);
        } catch (const render::OutOfMemory&) {
            std::unique_ptr<render::Renderer>& other = renderers_[&renderer == &renderers_[0] ? 1 : 0];
            if (other == nullptr) throw;
            other.reset(); // it is made anew when it draws next; and it shows the coverage that may have to go
            renderer = makeRenderer(source);
        }
    });
    return *renderer;
}

bool WalkStage::giveUpFinestCoverage(const render::OutOfMemory& failure) {
    if (on_.coverage == nullptr) return false;
    renderers_ = {}; // they show it
    return giveUpFinest(*device_, *scene_, on_.coverage, failure);
}

std::unique_ptr<render::Renderer> WalkStage::makeRenderer(const xr::ViewSource& source) const {
    return std::make_unique<render::Renderer>(*device_, *on_.images, source.width(), source.height(), source.eyes(),
                                              on_.coverage.get(), on_.polygons.get());
}

std::string WalkStage::askForRate(double framesPerSecond) {
    if (headset_ == nullptr || framesPerSecond <= 0) return {};
    const std::optional<double> rate = headset_->askForRate(framesPerSecond);
    const auto inWords = [](double hertz) {
        std::array<char, 32> text{};
        std::snprintf(text.data(), text.size(), "%g Hz", hertz);
        return std::string(text.data());
    };
    if (!rate) return "the headset keeps its own rate: it refuses " + inWords(framesPerSecond);
    constexpr double kSame = 0.5;
    if (std::abs(*rate - framesPerSecond) < kSame) return {};
    return "the headset does not offer " + inWords(framesPerSecond) + "; it shows " + inWords(*rate);
}

std::array<double, xr::kEyes> WalkStage::hiddenShares() const {
    std::array<double, xr::kEyes> shares{};
    for (std::size_t eye = 0; headset_ != nullptr && eye < xr::kEyes; ++eye)
        shares[eye] = headset_->hiddenShareOf(eye);
    return shares;
}

bool WalkStage::requestEnd() {
    if (headset_ != nullptr) headset_->requestExit();
    return headset_ != nullptr;
}

} // namespace app
