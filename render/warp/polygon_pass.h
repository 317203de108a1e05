#pragma once
// Draws ordinary polygons and puts them into the z-buffer of the warped samples (shaders/shared/polygons.h).

#include "render/gpu_polygons.h"
#include "render/pipeline.h"
#include "render/raster.h"
#include "scene/view.h"

#include <cstdint>

namespace render {

/// As many samples of a pixel as the device has, and no more than were wanted: 1, 2, 4 or 8.
int edgeSamplesOf(const Device& device, int wanted);

struct PolygonPass {
    int samples = 1; ///< of a pixel
    RenderPass renderPass;
    PipelineLayout layout;
    Pipeline pipeline;
    VkDescriptorSetLayout pictureLayout = VK_NULL_HANDLE; ///< 0 colours, 1 depths
    ComputePipeline merge;
    Sampler sampler;
};

/// samples: of edgeSamplesOf.
PolygonPass makePolygonPass(const Device& device, const GpuPolygons& polygons, VkDescriptorSetLayout eyeLayout,
                            int samples);

/// What an eye's polygons are drawn into. One serves all frames in flight: they follow one another on the queue.
struct PolygonTarget {
    DeviceImage colours, depths;
    Framebuffer framebuffer;
    DescriptorPool pool;
    VkDescriptorSet set = VK_NULL_HANDLE;
};

PolygonTarget makePolygonTarget(const Device& device, const PolygonPass& pass, int width, int height);

/// Draws what may be seen, part by part. The view's camera must not be larger than the target. Returns the number of
/// triangles that were drawn.
std::uint64_t recordPolygons(VkCommandBuffer commands, const PolygonPass& pass, const GpuPolygons& polygons,
                             const PolygonTarget& target, const scene::View& view);

/// Of the eye's z-buffer and the picture; after a barrier for both.
void recordPolygonMerge(VkCommandBuffer commands, const PolygonPass& pass, const PolygonTarget& target,
                        VkDescriptorSet eyeSet, int width, int height);

/// Clip space of a camera, of points in eye coordinates: reversed depth without end, near / z.
glm::dmat4 clipFromEye(const scene::Camera& camera);

/// Whether a box stands wholly beside, above, below or behind what is seen.
bool isOutside(const glm::dmat4& clipFromBox, const glm::dvec3& low, const glm::dvec3& high);

} // namespace render
