#include "render/post/unseen.h"

#include "render/device.h"
#include "scene/errors.h"
#include "spirv/unseen.comp.h"

#include <array>
#include <cmath>
#include <string>

namespace render {

namespace {

constexpr std::array kBindings{Binding::texels};

/// A period of the stripes, measured across them. Wide enough to be told apart at the far side of a room.
constexpr double kStripeMetres = 0.12;
/// The stripes' direction in the world: along no axis, so that no wall is without them.
const glm::dvec3 kAcrossStripes{0.669, 0.571, 0.476};
/// Without end, the pattern stands on the sky as wide as at this distance.
constexpr double kSkyMetres = 2;
constexpr float kSkyDepth = 1e6f;

/// What is drawn stands on a surface, within its samples' error: its own far side must not count.
constexpr float kSlack = 0.004f;

/// Whether there is any unseen space in a node or below; children come after their parents.
std::vector<std::uint8_t> findUnseen(const std::vector<scene::CoverageNode>& nodes) {
    std::vector<std::uint8_t> hasUnseen(nodes.size());
    for (std::size_t i = nodes.size(); i-- > 0;) {
        hasUnseen[i] = nodes[i].unseen != 0;
        for (int child = 0; child < std::popcount(nodes[i].children); ++child)
            hasUnseen[i] |= hasUnseen[nodes[i].firstChild + static_cast<std::size_t>(child)];
    }
    return hasUnseen;
}

} // namespace

std::vector<std::array<std::uint32_t, 2>> coverageTexels(const scene::Coverage& coverage) {
    const auto words = [](std::uint64_t mask) {
        return std::array{static_cast<std::uint32_t>(mask), static_cast<std::uint32_t>(mask >> 32)};
    };
    const std::vector<std::uint8_t> hasUnseen = findUnseen(coverage.nodes);
    std::vector<std::size_t> kept{0};
    std::vector<std::array<std::uint32_t, 2>> texels;
    for (std::size_t i = 0; i < kept.size(); ++i) {
        const scene::CoverageNode& node = coverage.nodes[kept[i]];
        const auto firstChild = static_cast<std::uint32_t>(kept.size());
        std::uint64_t children = 0;
        for (std::uint64_t left = node.children; left != 0; left &= left - 1) {
            const int bit = std::countr_zero(left);
            const std::size_t child = node.firstChild + scene::childRank(node.children, bit);
            if (hasUnseen[child] == 0) continue;
            children |= scene::coverageMask(bit);
            kept.push_back(child);
        }
        texels.push_back(words(node.unseen));
        texels.push_back(words(children));
        texels.push_back({firstChild, 0});
    }
    return texels;
}

GpuCoverage::GpuCoverage(const Device& device, const scene::Coverage& coverage)
    : cornerInWorld_(coverage.cornerInWorld), edgeMetres_(coverage.edgeMetres),
      layout_(makeSetLayout(device, kBindings)) {
    const std::vector<std::array<std::uint32_t, 2>> texels = coverageTexels(coverage);
    if (texels.size() > device.limits().maxTexelBufferElements)
        throw scene::Failure("coverage takes " + std::to_string(texels.size()) + " texels, more than the " +
                                 std::to_string(device.limits().maxTexelBufferElements) + " a shader can read",
                             device.name(), "choose another device, or draw with --hide-unseen");
    nodes_ = upload(device, std::as_bytes(std::span(texels)), VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT);
    view_ = makeTexelView(device, nodes_);
    pool_ = makeSetPool(device, 1, kBindings);
    set_ = allocateSet(device, pool_, layout_, std::array<Bound, 1>{{{nodes_.handle(), view_}}});
}

ComputePipeline makeUnseenPipeline(const Device& device, const GpuCoverage& coverage, VkDescriptorSetLayout eyeLayout) {
    const std::uint32_t workgroupSize = device.isProcessor() ? static_cast<std::uint32_t>(device.subgroupSize()) : 64;
    return makeComputePipeline(device, kUnseenCode, std::array{eyeLayout, coverage.layout()}, sizeof(UnseenConstants),
                               std::array{workgroupSize});
}

UnseenConstants unseenConstants(const glm::dvec3& cornerInWorld, double edgeMetres, const scene::View& eye,
                                const Quality& quality) {
    const scene::Camera& camera = eye.camera;
    const glm::dmat3& rotation = eye.worldFromEye.rotation;
    const auto packed = [](const glm::dvec3& xyz, double w) { return vec4(vec3(xyz), static_cast<float>(w)); };
    const glm::dvec3 eyeInCube = (eye.worldFromEye.translation - cornerInWorld) / edgeMetres;
    const glm::dvec3 phasePerMetre = glm::normalize(kAcrossStripes) / kStripeMetres;
    // The phase counts from the cube's corner, which is the same for both eyes; only its fraction is rounded.
    const double phase = glm::dot(phasePerMetre, eye.worldFromEye.translation - cornerInWorld);
    UnseenConstants c;
    c.eye = packed(eyeInCube, quality.unseenPocketMetres);
    c.base = packed(rotation * scene::rayThrough(camera, 0, 0) / edgeMetres, kSlack);
    c.perX = packed(rotation * glm::dvec3(1 / camera.fx, 0, 0) / edgeMetres, camera.width);
    c.perY = packed(rotation * glm::dvec3(0, 1 / camera.fy, 0) / edgeMetres, camera.height);
    c.pattern = packed(phasePerMetre * edgeMetres, phase - std::floor(phase));
    c.fade = {static_cast<float>(1 / kStripeMetres), static_cast<float>(1 / std::min(camera.fx, camera.fy)), kSkyDepth,
              static_cast<float>(kSkyMetres)};
    return c;
}

void recordUnseen(VkCommandBuffer commands, const ComputePipeline& pipeline, const GpuCoverage& coverage,
                  VkDescriptorSet eyeSet, const scene::View& eye, const Quality& quality) {
    const UnseenConstants constants = unseenConstants(coverage.cornerInWorld(), coverage.edgeMetres(), eye, quality);
    const std::array sets{eyeSet, coverage.set()};
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.layout, 0,
                            static_cast<std::uint32_t>(sets.size()), sets.data(), 0, nullptr);
    vkCmdPushConstants(commands, pipeline.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, &constants);
    vkCmdDispatch(commands, static_cast<std::uint32_t>(eye.camera.height), 1, 1);
}

} // namespace render
