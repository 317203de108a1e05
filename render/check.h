#pragma once
// Every answer of Vulkan goes through here: what fails is told with the line that asked.

#include <volk.h>

#include <source_location>

namespace render {

/// Throws scene::Failure unless result is VK_SUCCESS.
void check(VkResult result, std::source_location asked = std::source_location::current());

} // namespace render
