#include "xr/swapchain.h"

#include "xr/check.h"

namespace xr {

namespace {

std::vector<VkImage> imagesOf(XrSwapchain swapchain) {
    std::uint32_t count = 0;
    check(xrEnumerateSwapchainImages(swapchain, 0, &count, nullptr), "xrEnumerateSwapchainImages");
    std::vector<XrSwapchainImageVulkan2KHR> listed(count,
                                                   {XR_TYPE_SWAPCHAIN_IMAGE_VULKAN2_KHR, nullptr, VK_NULL_HANDLE});
    check(xrEnumerateSwapchainImages(swapchain, count, &count,
                                     reinterpret_cast<XrSwapchainImageBaseHeader*>(listed.data())),
          "xrEnumerateSwapchainImages");
    std::vector<VkImage> images;
    for (const XrSwapchainImageVulkan2KHR& image : listed)
        images.push_back(image.image);
    return images;
}

} // namespace

Swapchain::Swapchain(XrSession session, VkFormat format, XrSwapchainUsageFlags usage, int width, int height)
    : width_(width), height_(height) {
    XrSwapchainCreateInfo info{};
    info.type = XR_TYPE_SWAPCHAIN_CREATE_INFO;
    info.usageFlags = usage;
    info.format = format;
    info.sampleCount = info.faceCount = info.mipCount = 1;
    info.width = static_cast<std::uint32_t>(width);
    info.height = static_cast<std::uint32_t>(height);
    info.arraySize = kEyes;
    try {
        XrSwapchain layered = XR_NULL_HANDLE;
        if (XR_SUCCEEDED(xrCreateSwapchain(session, &info, &layered))) {
            chains_.push_back({layered, {}, 0});
        } else {
            info.arraySize = 1;
            for (std::size_t eye = 0; eye < kEyes; ++eye) {
                XrSwapchain single = XR_NULL_HANDLE;
                check(xrCreateSwapchain(session, &info, &single), "xrCreateSwapchain");
                chains_.push_back({single, {}, 0});
            }
        }
        for (Chain& chain : chains_)
            chain.images = imagesOf(chain.handle);
    } catch (...) {
        destroy();
        throw;
    }
}

Swapchain::~Swapchain() {
    destroy();
}

void Swapchain::destroy() {
    for (const Chain& chain : chains_)
        xrDestroySwapchain(chain.handle);
}

void Swapchain::acquire() {
    for (Chain& chain : chains_)
        check(xrAcquireSwapchainImage(chain.handle, nullptr, &chain.acquired), "xrAcquireSwapchainImage");
    XrSwapchainImageWaitInfo wait{};
    wait.type = XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO;
    wait.timeout = XR_INFINITE_DURATION;
    for (const Chain& chain : chains_)
        check(xrWaitSwapchainImage(chain.handle, &wait), "xrWaitSwapchainImage");
}

void Swapchain::release() {
    for (const Chain& chain : chains_)
        check(xrReleaseSwapchainImage(chain.handle, nullptr), "xrReleaseSwapchainImage");
}

VkImage Swapchain::image(std::size_t eye) const {
    const Chain& chain = chainOf(eye);
    return chain.images[chain.acquired];
}

XrSwapchainSubImage Swapchain::subImage(std::size_t eye, int width, int height) const {
    return {chainOf(eye).handle, {{0, 0}, {width > 0 ? width : width_, height > 0 ? height : height_}}, layer(eye)};
}

} // namespace xr
