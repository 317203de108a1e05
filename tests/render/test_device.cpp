#include "tests/render/test_device.h"

#include "tests/render/tuning.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <utility>

namespace render {

namespace {

constexpr const char* kLayer = "VK_LAYER_KHRONOS_validation";

/// Made when first wanted.
std::unique_ptr<Device>& madeCard() {
    static std::unique_ptr<Device> device;
    return device;
}

bool prepare() {
    setenv("REVISIT_TUNING", "looks", 0);
    if (canValidate()) {
        setenv("VK_INSTANCE_LAYERS", kLayer, 0);
        setenv("VK_LAYER_ENABLES", "VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT", 0);
    }
    return true;
}

} // namespace

bool canValidate() {
    if (volkInitialize() != VK_SUCCESS) return false;
    std::uint32_t count = 0;
    if (vkEnumerateInstanceLayerProperties(&count, nullptr) != VK_SUCCESS) return false;
    std::vector<VkLayerProperties> layers(count);
    if (vkEnumerateInstanceLayerProperties(&count, layers.data()) != VK_SUCCESS) return false;
    return std::any_of(layers.begin(), layers.end(),
                       [](const VkLayerProperties& layer) { return std::strcmp(layer.layerName, kLayer) == 0; });
}

Device& testDevice() {
    static const bool isPrepared = prepare();
    static Device device;
    static_cast<void>(isPrepared);
    return device;
}

Device& cardDevice() {
    std::unique_ptr<Device>& device = madeCard();
    if (device) return *device;
    testDevice(); // which makes the layers listen
    const Tuning tuning("card");
    device = std::make_unique<Device>();
    return *device;
}

void RenderTest::TearDown() {
    std::vector<std::string> messages = testDevice().validationMessages();
    if (madeCard())
        for (std::string& message : madeCard()->validationMessages())
            messages.push_back(std::move(message));
    for (const std::string& message : messages)
        ADD_FAILURE() << message;
}

std::vector<EyeImage> drawOnce(const GpuScene& scene, std::span<const scene::View> views, const Quality& quality) {
    const scene::Camera& camera = views[0].camera;
    Renderer renderer(testDevice(), scene, camera.width, camera.height, static_cast<int>(views.size()));
    renderer.draw(views, quality);
    return renderer.readBack();
}

EyeImage drawOnce(const GpuScene& scene, const scene::View& view, const Quality& quality) {
    return drawOnce(scene, std::span(&view, 1), quality)[0];
}

Painter::Painter(const GpuScene& scene, const scene::Camera& camera)
    : renderer_(testDevice(), scene, camera.width, camera.height, 1) {}

EyeImage Painter::operator()(const scene::View& view, const Quality& quality) {
    renderer_.draw({&view, 1}, quality);
    return renderer_.readBack()[0];
}

bool isSame(const EyeImage& a, const EyeImage& b) {
    return a.colour == b.colour && a.pixelClass == b.pixelClass && a.depthMetres == b.depthMetres;
}

double coverage(const EyeImage& image) {
    const auto classes = image.pixelClass.pixels();
    const auto covered = std::count_if(classes.begin(), classes.end(), [](std::uint8_t c) { return c != 0; });
    return static_cast<double>(covered) / static_cast<double>(classes.size());
}

} // namespace render
