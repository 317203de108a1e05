#include "render/device_choice.h"

#include "render/check.h"

#include <algorithm>
#include <cctype>

namespace render {

namespace {

std::string inLowerCase(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
    return text;
}

bool isMeant(const Candidate& candidate, const std::string& nameContains) {
    return inLowerCase(candidate.name).find(inLowerCase(nameContains)) != std::string::npos;
}

int rankOf(VkPhysicalDeviceType type) {
    switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
        return 0;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
        return 1;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
        return 2;
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
        return 3;
    default:
        return 4;
    }
}

void findQueues(Candidate& candidate) {
    std::uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(candidate.handle, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(candidate.handle, &count, families.data());
    constexpr VkQueueFlags kWanted = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    const auto family = std::find_if(families.begin(), families.end(), [](const VkQueueFamilyProperties& f) {
        return (f.queueFlags & kWanted) == kWanted;
    });
    if (family == families.end()) {
        candidate.lacks.push_back("a queue for graphics and compute");
        return;
    }
    candidate.queueFamily = static_cast<std::uint32_t>(family - families.begin());
}

void findFeatures(Candidate& candidate) {
    VkPhysicalDeviceVulkan12Features features12{};
    features12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
    VkPhysicalDeviceFeatures2 features{};
    features.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
    features.pNext = &features12;
    vkGetPhysicalDeviceFeatures2(candidate.handle, &features);
    if (!features.features.shaderInt64) candidate.lacks.push_back("shaderInt64");
    if (!features12.shaderBufferInt64Atomics) candidate.lacks.push_back("shaderBufferInt64Atomics");

    VkPhysicalDeviceVulkan11Properties properties11{};
    properties11.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES;
    VkPhysicalDeviceProperties2 properties{};
    properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
    properties.pNext = &properties11;
    vkGetPhysicalDeviceProperties2(candidate.handle, &properties);
    const bool ballots = (properties11.subgroupSupportedOperations & VK_SUBGROUP_FEATURE_BALLOT_BIT) != 0 &&
                         (properties11.subgroupSupportedStages & VK_SHADER_STAGE_COMPUTE_BIT) != 0;
    if (!ballots) candidate.lacks.push_back("subgroup ballot in compute shaders");
}

std::string withLacks(const Candidate& candidate) {
    std::string text = candidate.name;
    for (std::size_t i = 0; i < candidate.lacks.size(); ++i)
        text += (i == 0 ? " lacks " : " and ") + candidate.lacks[i];
    return text;
}

} // namespace

std::vector<Candidate> findCandidates(VkInstance instance) {
    std::uint32_t count = 0;
    check(vkEnumeratePhysicalDevices(instance, &count, nullptr));
    std::vector<VkPhysicalDevice> handles(count);
    check(vkEnumeratePhysicalDevices(instance, &count, handles.data()));

    std::vector<Candidate> candidates;
    for (const VkPhysicalDevice handle : handles) {
        VkPhysicalDeviceProperties properties{};
        vkGetPhysicalDeviceProperties(handle, &properties);
        Candidate candidate{handle, properties.deviceName, properties.deviceType, {}};
        if (properties.apiVersion < VK_API_VERSION_1_2)
            candidate.lacks.push_back("Vulkan 1.2");
        else
            findFeatures(candidate);
        findQueues(candidate);
        candidates.push_back(candidate);
    }
    return candidates;
}

std::optional<std::size_t> chooseCandidate(std::span<const Candidate> candidates, const std::string& nameContains) {
    std::optional<std::size_t> best;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
        if (!candidates[i].lacks.empty() || !isMeant(candidates[i], nameContains)) continue;
        if (!best || rankOf(candidates[i].type) < rankOf(candidates[*best].type)) best = i;
    }
    return best;
}

std::string describePassedOver(std::span<const Candidate> candidates, std::size_t chosen,
                               const std::string& nameContains) {
    std::string text;
    for (const Candidate& candidate : candidates)
        if (!candidate.lacks.empty() && isMeant(candidate, nameContains) &&
            rankOf(candidate.type) < rankOf(candidates[chosen].type))
            text += (text.empty() ? "" : ", ") + withLacks(candidate);
    return text;
}

std::string describe(std::span<const Candidate> candidates, const std::string& nameContains) {
    if (candidates.empty()) return "there is none";
    std::string text;
    for (const Candidate& candidate : candidates) {
        text += (text.empty() ? "" : ", ") + withLacks(candidate);
        if (!isMeant(candidate, nameContains)) text += " (not named \"" + nameContains + "\")";
    }
    return text;
}

} // namespace render
