#pragma once
// Every answer of Vulkan goes through here: what fails is told with the line that asked.

#include "scene/errors.h"

#include <volk.h>

#include <source_location>

namespace render {

/// The device is gone, and all that was made on it of no more use: both are to be destroyed. Another may be made.
class DeviceLost : public scene::Failure {
  public:
    using Failure::Failure;
};

/// There is no memory left, on the device or for it. What was there before is as it was.
class OutOfMemory : public scene::Failure {
  public:
    using Failure::Failure;
};

/// Throws DeviceLost, OutOfMemory or any other scene::Failure unless result is VK_SUCCESS.
void check(VkResult result, std::source_location asked = std::source_location::current());

} // namespace render
