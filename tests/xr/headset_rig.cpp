#include "tests/xr/headset_rig.h"

#include "render/renderer.h"
#include "tests/render/test_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
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

void HeadsetRig::drawAndCheck(Frame& frame, double scale) {
    constexpr int kFaceSize = 64;
    const render::CutScene room = render::roomFromWithin(kFaceSize);
    const auto blocks = room.blocks();
    const render::GpuScene scene(*device_, blocks);
    render::Renderer renderer(*device_, scene, headset_->width(), headset_->height(), static_cast<int>(kEyes));
    renderer.letDisplayEnlarge(true);
    render::Quality quality;
    quality.resolutionScale = scale;
    std::array<render::EyeOutput, kEyes> outputs;
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
        const EyeImage& image = frame.images[eye];
        outputs[eye].image = image.image, outputs[eye].layer = image.layer;
        outputs[eye].depth = image.depth, outputs[eye].depthLayer = image.depthLayer;
        outputs[eye].nearMetres = static_cast<float>(kDepthNearMetres);
    }
    const auto [width, height] = renderer.draw(frame.eyes, quality, outputs).picture;
    frame.pictureWidth = width, frame.pictureHeight = height;
    EXPECT_EQ(width, render::scaledSide(headset_->width(), scale));
    EXPECT_EQ(height, render::scaledSide(headset_->height(), scale));
    const std::vector<render::EyeImage> own = renderer.readBack();
    EXPECT_NE(own[0].colour, own[1].colour) << "each eye has its own picture";
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
        const auto colours = render::readOutputAndClasses(*device_, outputs[eye], width, height);
        int other = 0;
        for (std::size_t i = 0; i < colours.size(); ++i) {
            const auto [r, g, b] = own[eye].colour.pixels()[i];
            if (colours.pixels()[i] != scene::Rgba8{r, g, b, own[eye].pixelClass.pixels()[i]}) ++other;
        }
        EXPECT_EQ(other, 0) << "eye " << eye;
        EXPECT_EQ(outputs[eye].depth != VK_NULL_HANDLE, headset_->takesDepth());
        if (!headset_->takesDepth()) continue;
        const scene::Image<float> given = render::readDepthOutput(*device_, outputs[eye], width, height);
        int there = 0, wrong = 0;
        for (std::size_t i = 0; i < given.size(); ++i) {
            const double z = static_cast<double>(own[eye].depthMetres.pixels()[i]);
            const double wanted = z > 0 ? std::min(kDepthNearMetres / z, 1.0) : 0;
            if (z > 0) ++there;
            if (std::abs(static_cast<double>(given.pixels()[i]) - wanted) > 1e-6 * wanted) ++wrong;
        }
        EXPECT_GT(there, width * height / 4) << "eye " << eye;
        EXPECT_EQ(wrong, 0) << "eye " << eye << ": not near / z";
    }
}

std::optional<Frame> HeadsetRig::nextDrawn() {
    while (true) {
        const Frame frame = headset_->begin();
        if (frame.kind == Frame::Kind::draw) return frame;
        if (frame.kind != Frame::Kind::skip) return std::nullopt;
    }
}

} // namespace xr
