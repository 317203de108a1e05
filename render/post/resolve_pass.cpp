#include "render/post/resolve_pass.h"

#include "render/command_streams.h"
#include "render/device.h"

#include "spirv/fill_holes.comp.h"
#include "spirv/list_holes.comp.h"
#include "spirv/resolve.comp.h"

#include <array>
#include <cassert>
#include <initializer_list>
#include <span>

namespace render {

namespace {

constexpr Barrier kBetween{kCompute, VK_ACCESS_SHADER_WRITE_BIT, kCompute,
                           VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT};

/// Of a row, on graphics cards. A processor takes a row as one workgroup of a vector.
constexpr std::uint32_t kResolvedTogether = 128, kWordsListedTogether = 128, kHolesFilledTogether = 64;
/// So many holes of a row wait for one another: one hole takes long, and few rows have many.
constexpr std::uint32_t kHolesInTurn = 4;
/// Of a row, for a workgroup on a processor: lavapipe lets none go through loops for too long.
constexpr std::uint32_t kPixelsFilledByProcessor = 1024;

std::uint32_t groupsOf(int pixels, std::uint32_t size) {
    return (static_cast<std::uint32_t>(pixels) + size - 1) / size;
}

void dispatch(VkCommandBuffer commands, const ComputePipeline& pipeline, VkDescriptorSet eyeSet,
              const ResolveConstants& constants, std::uint32_t groupsOfRow) {
    bind(commands, pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.layout(), 0, 1, &eyeSet, 0, nullptr);
    vkCmdPushConstants(commands, pipeline.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, &constants);
    vkCmdDispatch(commands, groupsOfRow, static_cast<std::uint32_t>(constants.height), 1);
}

} // namespace

ResolvePass makeResolvePass(const Device& device, VkDescriptorSetLayout eyeLayout) {
    const std::array<VkDescriptorSetLayout, 1> sets{eyeLayout};
    const auto make = [&](std::span<const std::uint32_t> code, std::initializer_list<std::uint32_t> constants) {
        return makeComputePipeline(device, code, sets, sizeof(ResolveConstants),
                                   std::span(constants.begin(), constants.size()));
    };
    constexpr std::uint32_t kMarksHoles = 1;
    const std::uint32_t size = device.workgroupSize(kResolvedTogether), byWords = device.isProcessor() ? 1 : 0;
    constexpr std::uint32_t kInterpolates = 1;
    return {.plain = {make(kResolveCode, {size, 0, byWords, 0}), make(kResolveCode, {size, 0, byWords, kInterpolates})},
            .marking = {make(kResolveCode, {size, kMarksHoles, byWords, 0}),
                        make(kResolveCode, {size, kMarksHoles, byWords, kInterpolates})},
            .listing = make(kListHolesCode, {device.workgroupSize(kWordsListedTogether)}),
            .filling = make(kFillHolesCode, {device.workgroupSize(kHolesFilledTogether)}),
            .isByRows = device.isProcessor()};
}

void recordResolve(VkCommandBuffer commands, const ResolvePass& pass, VkDescriptorSet eyeSet, int width, int height,
                   const HoleFill& holes, PlaceUse use, const PlaceSteps& places) {
    assert(holes.radius <= kMostHoleRadius);
    const ResolveConstants constants{width, height, holes, use == PlaceUse::none ? PlaceSteps{} : places};
    const std::size_t how = use == PlaceUse::interpolated ? 1 : 0;
    const std::uint32_t groups = pass.isByRows ? 1 : groupsOf(width, kResolvedTogether);
    if (holes.radius <= 0) {
        dispatch(commands, pass.plain.at(how), eyeSet, constants, groups);
        return;
    }
    dispatch(commands, pass.marking.at(how), eyeSet, constants, groups);
    record(commands, kBetween);
    dispatch(commands, pass.listing, eyeSet, constants, 1);
    record(commands, kBetween);
    dispatch(commands, pass.filling, eyeSet, constants,
             groupsOf(width, pass.isByRows ? kPixelsFilledByProcessor : kHolesFilledTogether * kHolesInTurn));
}

} // namespace render
