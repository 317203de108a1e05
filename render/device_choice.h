#pragma once
// Which of the machine's devices draws.

#include <volk.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace render {

/// A device of this machine, and what keeps us from using it.
struct Candidate {
    VkPhysicalDevice handle = VK_NULL_HANDLE;
    std::string name;
    VkPhysicalDeviceType type = VK_PHYSICAL_DEVICE_TYPE_OTHER;
    std::vector<std::string> lacks; ///< empty: usable
    std::uint32_t queueFamily = 0;  ///< with graphics and compute, if usable
};

/// Asks all devices of an instance.
std::vector<Candidate> findCandidates(VkInstance instance);

/// Usable and best of its kind: discrete before integrated, virtual, processor; the first among equals. If
/// nameContains is not empty, only devices whose name contains it (whatever the case) count.
std::optional<std::size_t> chooseCandidate(std::span<const Candidate> candidates, const std::string& nameContains);

/// Devices that would have been chosen before `chosen`, were it not for what they lack: "NAME lacks WHAT", one after
/// another; empty if there are none.
std::string describePassedOver(std::span<const Candidate> candidates, std::size_t chosen,
                               const std::string& nameContains);

/// One line for a failure: every candidate and what it lacks.
std::string describe(std::span<const Candidate> candidates, const std::string& nameContains);

} // namespace render
