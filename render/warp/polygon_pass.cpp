#include "render/warp/polygon_pass.h"

#include "render/device.h"
#include "render/shaders/shared/polygons.h"

#include "spirv/polygon_merge.comp.h"
#include "spirv/polygon_merge_edges.comp.h"
#include "spirv/polygons.frag.h"
#include "spirv/polygons.vert.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include <glm/matrix.hpp>

namespace render {

namespace {

constexpr VkFormat kColourFormat = VK_FORMAT_R8G8B8A8_UNORM, kDepthFormat = VK_FORMAT_D32_SFLOAT;
constexpr VkImageLayout kReadDepth = VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL;

/// Vulkan's flags are the numbers.
VkSampleCountFlagBits flagOf(int samples) {
    return static_cast<VkSampleCountFlagBits>(samples);
}

/// The picture of the frame before has been merged when this one is cleared, and is whole when it is merged.
RenderPass makePolygonRenderPass(const Device& device, int samples) {
    constexpr VkPipelineStageFlags kDrawing = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT |
                                              VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT |
                                              VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
    constexpr VkAccessFlags kWrites = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT |
                                      VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT |
                                      VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
    RasterTargets targets{.colour = attachmentOf(kColourFormat, flagOf(samples), VK_ATTACHMENT_LOAD_OP_CLEAR,
                                                 VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL),
                          .depth =
                              attachmentOf(kDepthFormat, flagOf(samples), VK_ATTACHMENT_LOAD_OP_CLEAR, kReadDepth)};
    targets.before.srcStageMask = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | kDrawing;
    targets.before.srcAccessMask = VK_ACCESS_SHADER_READ_BIT | kWrites;
    targets.before.dstStageMask = targets.after.srcStageMask = kDrawing;
    targets.before.dstAccessMask = targets.after.srcAccessMask = kWrites;
    targets.after.dstStageMask = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
    targets.after.dstAccessMask = VK_ACCESS_SHADER_READ_BIT;
    return makeRenderPass(device, targets);
}

/// Seen from behind a triangle is drawn as well, as images of it show it.
Pipeline makeDrawingPipeline(const Device& device, VkPipelineLayout layout, VkRenderPass renderPass, int samples) {
    const VkVertexInputBindingDescription binding{0, sizeof(PolygonVertex), VK_VERTEX_INPUT_RATE_VERTEX};
    const std::array<VkVertexInputAttributeDescription, 4> attributes{
        {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(PolygonVertex, position)},
         {1, 0, VK_FORMAT_R8G8B8A8_SNORM, offsetof(PolygonVertex, normal)},
         {2, 0, VK_FORMAT_R32G32_SFLOAT, offsetof(PolygonVertex, texturePlace)},
         {3, 0, VK_FORMAT_R16G16B16A16_SFLOAT, offsetof(PolygonVertex, colour)}}};
    return makeRasterPipeline(device, {.vertexCode = kPolygonsVertexCode,
                                       .fragmentCode = kPolygonsFragmentCode,
                                       .bindings = {&binding, 1},
                                       .attributes = attributes,
                                       .samples = flagOf(samples),
                                       .depthCompare = VK_COMPARE_OP_GREATER,
                                       .layout = layout,
                                       .pass = renderPass});
}

constexpr std::array kPictures{Binding::sampled, Binding::sampled};
constexpr VkShaderStageFlags kDrawingStages = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;

} // namespace

int edgeSamplesOf(const Device& device, int wanted) {
    const VkPhysicalDeviceLimits& limits = device.limits();
    const VkSampleCountFlags there = limits.framebufferColorSampleCounts & limits.framebufferDepthSampleCounts &
                                     limits.sampledImageColorSampleCounts & limits.sampledImageDepthSampleCounts;
    int samples = 1;
    for (int more = 2; more <= std::min(wanted, 8); more *= 2)
        if ((there & flagOf(more)) != 0) samples = more;
    return samples;
}

PolygonPass makePolygonPass(const Device& device, const GpuPolygons& polygons, VkDescriptorSetLayout eyeLayout,
                            int samples) {
    PolygonPass pass;
    pass.samples = samples;
    pass.renderPass = makePolygonRenderPass(device, samples);
    pass.layout =
        makePipelineLayout(device, std::array{polygons.textureLayout()}, {kDrawingStages, 0, sizeof(PolygonConstants)});
    pass.pipeline = makeDrawingPipeline(device, pass.layout, pass.renderPass, samples);
    pass.pictureLayout = makeSetLayout(device, kPictures);
    const std::uint32_t size = device.workgroupSize(128);
    const std::span<const std::uint32_t> merging = samples > 1 ? std::span<const std::uint32_t>(kPolygonMergeEdgesCode)
                                                               : std::span<const std::uint32_t>(kPolygonMergeCode);
    pass.merge =
        makeComputePipeline(device, merging, std::array<VkDescriptorSetLayout, 2>{eyeLayout, pass.pictureLayout},
                            sizeof(PolygonMergeConstants), std::array{size});
    pass.sampler = makePixelSampler(device);
    return pass;
}

PolygonTarget makePolygonTarget(const Device& device, const PolygonPass& pass, int width, int height) {
    PolygonTarget target;
    target.colours = makeImage(device, width, height, kColourFormat,
                               VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
                               VK_IMAGE_ASPECT_COLOR_BIT, 1, flagOf(pass.samples));
    target.depths = makeImage(device, width, height, kDepthFormat,
                              VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
                              VK_IMAGE_ASPECT_DEPTH_BIT, 1, flagOf(pass.samples));
    const std::array<VkImageView, 2> attachments{target.colours.view, target.depths.view};
    target.framebuffer = makeFramebuffer(device, pass.renderPass, attachments, width, height);
    target.pool = makeSetPool(device, 1, kPictures);
    const std::array bound{Bound{.image = target.colours.view, .sampler = pass.sampler},
                           Bound{.image = target.depths.view, .sampler = pass.sampler, .imageLayout = kReadDepth}};
    target.set = allocateSet(device, target.pool, pass.pictureLayout, bound);
    return target;
}

glm::dmat4 clipFromEye(const scene::Camera& camera) {
    // Columns; clip x = (2 (fx X + cx Z) / width - Z), y likewise, z = near, w = Z.
    glm::dmat4 clip(0.0);
    clip[0][0] = 2 * camera.fx / camera.width;
    clip[1][1] = 2 * camera.fy / camera.height;
    clip[2][0] = 2 * camera.cx / camera.width - 1;
    clip[2][1] = 2 * camera.cy / camera.height - 1;
    clip[2][3] = 1;
    clip[3][2] = kPolygonNear;
    return clip;
}

bool isOutside(const glm::dmat4& clipFromBox, const glm::dvec3& low, const glm::dvec3& high) {
    std::array<int, 5> beyond{};
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p((corner & 1) != 0 ? high.x : low.x, (corner & 2) != 0 ? high.y : low.y,
                           (corner & 4) != 0 ? high.z : low.z);
        const glm::dvec4 clip = clipFromBox * glm::dvec4(p, 1);
        beyond[0] += clip.x<-clip.w, beyond[1] += clip.x> clip.w;
        beyond[2] += clip.y<-clip.w, beyond[3] += clip.y> clip.w;
        beyond[4] += clip.z > clip.w;
    }
    for (const int corners : beyond)
        if (corners == 8) return true;
    return false;
}

std::uint64_t recordPolygons(VkCommandBuffer commands, const PolygonPass& pass, const GpuPolygons& polygons,
                             const PolygonTarget& target, const scene::View& view) {
    beginRaster(commands, pass.renderPass, target.framebuffer, pass.pipeline, view.camera.width, view.camera.height);
    std::uint64_t triangles = 0;
    if (!polygons.parts().empty()) {
        constexpr VkDeviceSize kStart = 0;
        const VkBuffer vertices = polygons.vertices();
        vkCmdBindVertexBuffers(commands, 0, 1, &vertices, &kStart);
        vkCmdBindIndexBuffer(commands, polygons.indices(), 0, VK_INDEX_TYPE_UINT32);
    }
    const glm::dmat4 clipFromTurned = clipFromEye(view.camera) * glm::dmat4(glm::transpose(view.worldFromEye.rotation));
    VkDescriptorSet bound = VK_NULL_HANDLE;
    for (const PolygonPart& part : polygons.parts()) {
        // The positions are subtracted first, which is exact where they are near each other (scene/view.cpp); all is
        // multiplied out in double precision and only then rounded.
        glm::dmat4 aboutEyeFromMesh = part.worldFromMesh;
        aboutEyeFromMesh[3] -= glm::dvec4(view.worldFromEye.translation, 0);
        const glm::dmat4 clipFromMesh = clipFromTurned * aboutEyeFromMesh;
        if (isOutside(clipFromMesh, part.low, part.high)) continue;
        const VkDescriptorSet textures = polygons.texturesOf(part.material);
        if (textures != bound)
            vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pass.layout, 0, 1, &textures, 0,
                                    nullptr);
        bound = textures;
        const PolygonConstants constants{glm::mat4(clipFromMesh), glm::vec4(glm::vec3(part.upFromNormal), 0),
                                         polygons.colourOf(part.material)};
        vkCmdPushConstants(commands, pass.layout, kDrawingStages, 0, sizeof constants, &constants);
        vkCmdDrawIndexed(commands, part.indexCount, 1, part.firstIndex, static_cast<std::int32_t>(part.firstVertex), 0);
        triangles += part.indexCount / 3;
    }
    vkCmdEndRenderPass(commands);
    return triangles;
}

void recordPolygonMerge(VkCommandBuffer commands, const PolygonPass& pass, const PolygonTarget& target,
                        VkDescriptorSet eyeSet, int width, int height) {
    const PolygonMergeConstants constants{width, pass.samples};
    const std::array sets{eyeSet, target.set};
    bind(commands, pass.merge);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pass.merge.layout(), 0, 2, sets.data(), 0,
                            nullptr);
    vkCmdPushConstants(commands, pass.merge.layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof constants, &constants);
    vkCmdDispatch(commands, static_cast<std::uint32_t>(height), 1, 1);
}

} // namespace render
