#include "render/post/unseen.h"

#include "render/device.h"
#include "render/post/coverage_texels.h"
#include "scene/coverage_levels.h"
#include "scene/coverage_ray.h"
#include "scene/errors.h"
#include "spirv/unseen.comp.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

namespace render {

namespace {

constexpr std::array kUnseenBindings{Binding::texels, Binding::texels, Binding::texels};

/// A period of the stripes, measured across them. Wide enough to be told apart at the far side of a room.
constexpr double kStripeMetres = 0.12;
/// The stripes' direction in the world: along no axis, so that no wall is without them.
const glm::dvec3 kAcrossStripes{0.669, 0.571, 0.476};
/// Without end, the pattern stands on the sky as wide as at this distance.
constexpr double kSkyMetres = 2;
constexpr float kSkyDepth = 1e6f;

} // namespace

GpuCoverage::GpuCoverage(const Device& device, const scene::Coverage& coverage)
    : GpuCoverage(device, nullptr, &coverage) {}

GpuCoverage::GpuCoverage(const Device& device, scene::Coverage&& coverage)
    : GpuCoverage(device, std::make_unique<const scene::Coverage>(std::move(coverage)), nullptr) {}

GpuCoverage::GpuCoverage(const Device& device, std::unique_ptr<const scene::Coverage> own, const scene::Coverage* lent)
    : own_(std::move(own)), openGrid_(own_ ? *own_ : *lent), layout_(makeSetLayout(device, kUnseenBindings)) {
    const scene::Coverage& coverage = openGrid_.coverage();
    cornerInWorld_ = coverage.cornerInWorld, edgeMetres_ = coverage.edgeMetres;
    levels_ = scene::levelsOf(coverage), finestCellMetres_ = scene::finestCellOf(coverage);
    CoverageTexels made = coverageTexels(coverage);
    grid_ = made.grid, brickLevels_ = made.brickLevels;
    const std::size_t texels = std::max(made.words.size(), made.bricks.size()),
                      most = device.limits().maxTexelBufferElements;
    if (texels > most)
        throw scene::Failure("coverage takes " + std::to_string(texels) + " texels, more than the " +
                                 std::to_string(most) + " a shader can read",
                             device.name(), "choose another device, or draw with --hide-unseen");
    if (brickLevels_ == 0) made.bricks.resize(1), made.bases.resize(1); // there is no empty buffer
    const auto onDevice = [&](std::span<const std::uint32_t> words) {
        return upload(device, std::as_bytes(words), VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT);
    };
    words_ = onDevice(made.words), bricks_ = onDevice(made.bricks), bases_ = onDevice(made.bases);
    const auto viewOf = [&](const Buffer& buffer) { return makeTexelView(device, buffer, VK_FORMAT_R32_UINT); };
    wordsView_ = viewOf(words_), bricksView_ = viewOf(bricks_), basesView_ = viewOf(bases_);
    pool_ = makeSetPool(device, 1, kUnseenBindings);
    set_ = allocateSet(
        device, pool_, layout_,
        std::array<Bound, 3>{
            {{words_.handle(), wordsView_}, {bricks_.handle(), bricksView_}, {bases_.handle(), basesView_}}});
}

ComputePipeline makeUnseenPipeline(const Device& device, const GpuCoverage& coverage, VkDescriptorSetLayout eyeLayout) {
    const std::uint32_t workgroupSize = device.workgroupSize(64);
    return makeComputePipeline(device, kUnseenCode, std::array{eyeLayout, coverage.layout()}, sizeof(UnseenConstants),
                               std::array{workgroupSize, coverage.brickLevels()});
}

UnseenConstants unseenConstants(const glm::dvec3& cornerInWorld, double edgeMetres, const UnseenGrid& grid,
                                const scene::View& eye, const Quality& quality) {
    const scene::Camera& camera = eye.camera;
    const glm::dmat3& rotation = eye.worldFromEye.rotation;
    const auto packed = [](const glm::dvec3& xyz, double w) { return vec4(vec3(xyz), static_cast<float>(w)); };
    const glm::dvec3 eyeInCube = (eye.worldFromEye.translation - cornerInWorld) / edgeMetres;
    const glm::dvec3 phasePerMetre = glm::normalize(kAcrossStripes) / kStripeMetres;
    // The phase counts from the cube's corner, which is the same for both eyes; only its fraction is rounded.
    const double phase = glm::dot(phasePerMetre, eye.worldFromEye.translation - cornerInWorld);
    UnseenConstants c;
    c.eye = packed(eyeInCube, quality.unseenPocketMetres);
    c.base = packed(rotation * scene::rayThrough(camera, 0, 0) / edgeMetres, scene::kSurfaceSlack);
    c.perX = packed(rotation * glm::dvec3(1 / camera.fx, 0, 0) / edgeMetres, camera.width);
    c.perY = packed(rotation * glm::dvec3(0, 1 / camera.fy, 0) / edgeMetres, camera.height);
    c.pattern = packed(phasePerMetre * edgeMetres, phase - std::floor(phase));
    c.fade = {static_cast<float>(1 / kStripeMetres), static_cast<float>(1 / std::min(camera.fx, camera.fy)), kSkyDepth,
              static_cast<float>(kSkyMetres)};
    c.gridFirst = vec4(grid.first, grid.size);
    c.gridCount = vec4(grid.count, 0);
    return c;
}

void recordUnseen(VkCommandBuffer commands, const ComputePipeline& pipeline, const GpuCoverage& coverage,
                  VkDescriptorSet eyeSet, const scene::View& eye, const Quality& quality) {
    const UnseenConstants constants =
        unseenConstants(coverage.cornerInWorld(), coverage.edgeMetres(), coverage.grid(), eye, quality);
    const std::array sets{eyeSet, coverage.set()};
    bind(commands, pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.layout(), 0,
                            static_cast<std::uint32_t>(sets.size()), sets.data(), 0, nullptr);
    vkCmdPushConstants(commands, pipeline.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, &constants);
    const auto blocks = [](int pixels) { return (static_cast<std::uint32_t>(pixels) + kBeamPixels - 1) / kBeamPixels; };
    vkCmdDispatch(commands, blocks(eye.camera.width), blocks(eye.camera.height), 1);
}

} // namespace render
