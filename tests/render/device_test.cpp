#include "render/check.h"
#include "render/device_choice.h"
#include "render/pipeline.h"
#include "render/target.h"
#include "render/warp/occlusion_pass.h"
#include "scene/errors.h"
#include "tests/render/test_device.h"

#include <array>
#include <cstdlib>
#include <span>

namespace render {
namespace {

Candidate candidate(const char* name, VkPhysicalDeviceType type, std::vector<std::string> lacks = {}) {
    return {VK_NULL_HANDLE, name, type, std::move(lacks)};
}

TEST(DeviceChoice, PrefersDiscreteThenIntegratedThenVirtualThenProcessor) {
    const std::vector<Candidate> all{candidate("Soft Pipe", VK_PHYSICAL_DEVICE_TYPE_CPU),
                                     candidate("Cloud", VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU),
                                     candidate("Laptop", VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU),
                                     candidate("Tower", VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU),
                                     candidate("Old Tower", VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU, {"shaderInt64"})};
    EXPECT_EQ(chooseCandidate(all, ""), 3u);
    EXPECT_EQ(chooseCandidate(std::span(all).first(3), ""), 2u);
    EXPECT_EQ(chooseCandidate(std::span(all).first(2), ""), 1u);
    EXPECT_EQ(chooseCandidate(all, "soft"), 0u) << "whatever the case";
    EXPECT_EQ(chooseCandidate(all, "Old"), std::nullopt);
    EXPECT_EQ(chooseCandidate({}, ""), std::nullopt);
    EXPECT_NE(describe(all, "Old").find("Old Tower lacks shaderInt64"), std::string::npos);
    EXPECT_EQ(describePassedOver(all, 2, ""), "Old Tower lacks shaderInt64");
    EXPECT_EQ(describePassedOver(all, 3, ""), "") << "another is as good";
    EXPECT_EQ(describePassedOver(all, 2, "laptop"), "") << "nobody asked for it";
}

TEST(Device, SaysWhyThereIsNone) {
    const char* before = std::getenv("REVISIT_DEVICE");
    const std::string kept = before != nullptr ? before : "";
    setenv("REVISIT_DEVICE", "no such device", 1);
    try {
        const Device device;
        ADD_FAILURE() << "there should be no such device";
    } catch (const scene::Failure& failure) {
        EXPECT_NE(std::string(failure.what()).find("REVISIT_DEVICE"), std::string::npos) << failure.what();
        EXPECT_NE(std::string(failure.what()).find("not named"), std::string::npos) << failure.what();
    }
    if (before != nullptr)
        setenv("REVISIT_DEVICE", kept.c_str(), 1);
    else
        unsetenv("REVISIT_DEVICE");
}

class PipelineStoreTest : public RenderTest {};

TEST_F(PipelineStoreTest, MakesWhatIsTheSameOnce) {
    const Device& device = testDevice();
    const std::array bindings{Binding::storage, Binding::texels};
    const VkDescriptorSetLayout layout = makeSetLayout(device, bindings);
    EXPECT_EQ(makeSetLayout(device, bindings), layout);
    EXPECT_NE(makeSetLayout(device, std::span(bindings).first(1)), layout);
    EXPECT_NE(makeSetLayout(device, bindings, VK_SHADER_STAGE_FRAGMENT_BIT), layout);

    const VkDescriptorSetLayout eye = makeEyeLayout(device);
    const OcclusionPass one = makeOcclusionPass(device, eye), again = makeOcclusionPass(device, eye);
    EXPECT_EQ(again.cull.handle(), one.cull.handle());
    EXPECT_EQ(again.cull.layout(), one.cull.layout());
    EXPECT_EQ(again.occluders.handle(), one.occluders.handle());
    EXPECT_NE(one.cull.handle(), one.occluders.handle());
    EXPECT_TRUE(again.cull == one.cull && one.cull != one.occluders);
}

TEST(Check, ThrowsWithTheLineThatAsked) {
    EXPECT_NO_THROW(check(VK_SUCCESS));
    try {
        check(VK_ERROR_OUT_OF_DEVICE_MEMORY);
        ADD_FAILURE();
    } catch (const scene::Failure& failure) {
        EXPECT_NE(std::string(failure.what()).find("device_test.cpp, line"), std::string::npos) << failure.what();
    }
}

TEST(Check, TellsALostDeviceFromOneThatIsFull) {
    EXPECT_THROW(check(VK_ERROR_DEVICE_LOST), DeviceLost);
    EXPECT_THROW(check(VK_ERROR_OUT_OF_DEVICE_MEMORY), OutOfMemory);
    EXPECT_THROW(check(VK_ERROR_OUT_OF_HOST_MEMORY), OutOfMemory);
    try {
        check(VK_ERROR_FORMAT_NOT_SUPPORTED);
        ADD_FAILURE();
    } catch (const scene::Failure& failure) {
        EXPECT_EQ(dynamic_cast<const DeviceLost*>(&failure), nullptr);
        EXPECT_EQ(dynamic_cast<const OutOfMemory*>(&failure), nullptr);
    }
}

TEST_F(RenderTest, TheValidationLayersAreHeard) {
    if (!canValidate()) GTEST_SKIP() << "skipped, because VK_LAYER_KHRONOS_validation is not installed";
    const Device& device = testDevice();
    // A device of its own would be cleaner, but the layers listen per instance: this one is made to fall
    // silent again.
    Device other;
    VkBufferCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    info.size = 0;
    info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    VkBuffer buffer = VK_NULL_HANDLE;
    if (vkCreateBuffer(other, &info, nullptr, &buffer) == VK_SUCCESS) vkDestroyBuffer(other, buffer, nullptr);
    EXPECT_FALSE(other.validationMessages().empty());
    EXPECT_TRUE(device.validationMessages().empty());
}

TEST_F(RenderTest, TheDeviceDescribesItself) {
    const Device& device = testDevice();
    EXPECT_FALSE(device.name().empty());
    EXPECT_FALSE(device.driver().empty());
    EXPECT_GE(device.subgroupSize(), 1);
    EXPECT_NE(device.queue(), static_cast<VkQueue>(VK_NULL_HANDLE));
}

TEST_F(RenderTest, AnImageTooLargeForTheDeviceIsRefused) {
    const GpuScene scene(testDevice(), {});
    EXPECT_THROW(Renderer(testDevice(), scene, 65536, 65536, 1), scene::Failure);
}

} // namespace
} // namespace render
