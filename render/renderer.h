#pragma once
// Scene and views to pixels: cull, warp, resolve, unseen, overlay, submit.

#include "render/command_streams.h"
#include "render/device.h"
#include "render/draw_list.h"
#include "render/gpu_scene.h"
#include "render/output.h"
#include "render/overlay_pass.h"
#include "render/post/mark_pass.h"
#include "render/post/output_pass.h"
#include "render/post/rescale.h"
#include "render/post/resolve_pass.h"
#include "render/post/unseen.h"
#include "render/quality.h"
#include "render/readback.h"
#include "render/target.h"
#include "render/timing.h"
#include "render/warp/blend_pass.h"
#include "render/warp/occlusion_pass.h"
#include "render/warp/polygon_pass.h"
#include "render/warp/stereo_pass.h"
#include "render/warp/warp_pass.h"
#include "scene/view.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace render {

struct EyeCounts {
    std::uint32_t tilesTested = 0, tilesRejected = 0, tilesDrawn = 0;
    std::uint64_t samplesDrawn = 0;   ///< points, or squares of the mesh
    std::uint64_t samplesBlended = 0; ///< of the second pass, if there was one
    std::uint64_t trianglesDrawn = 0; ///< of ordinary polygons
    std::uint32_t overlayStrokes = 0, overlayDropped = 0;
};

struct FrameStats {
    std::uint64_t frame = 0;
    std::vector<StepTime> cpu; ///< wait, ways, cull, choose, unite, list, overlay, record, submit
    /// clear, warp, polygons, blend, resolve, unseen, rescale, mark, overlay, output; of the frame gpuFrame, empty
    /// while none has finished
    std::vector<StepTime> gpu;
    std::uint64_t gpuFrame = 0;
    bool isOnePass = false;  ///< the eyes were warped together; their warp is a step of both
    bool isStanding = false; ///< the scene was not warped anew (Renderer::letFramesStand)
    PictureSize picture;     ///< of what the eyes were given: the renderer's, or less (Renderer::letDisplayEnlarge)
    std::array<EyeCounts, kMaxEyes> eyes{};
};

/// Draws one scene for one or two eyes of one size. Device and scene must outlive it. One thread at a time;
/// inside, the eyes are culled and recorded at the same time.
class Renderer {
  public:
    /// Throws scene::Failure if the device cannot hold or see images of that size.
    /// coverage: what was observed, if that is known; polygons: what stands in the scene besides, or none. Both must
    /// outlive the renderer, too.
    Renderer(const Device& device, const GpuScene& scene, int width, int height, int eyes,
             const GpuCoverage* coverage = nullptr, const GpuPolygons* polygons = nullptr);

    /// Sends a frame to the device. Waits only for the frame two before. The cameras must have the renderer's
    /// size. outputs: whose part the finished eyes become, one each, or none.
    /// overlay: what is drawn over the scene; costs nothing where there is none.
    FrameStats draw(std::span<const scene::View> eyes, const Quality& quality, std::span<const EyeOutput> outputs = {},
                    const Overlay* overlay = nullptr);

    /// Draws a first frame in each of these ways and forgets it: frames are then counted from 0 again. What the device
    /// compiles, reads or makes room for when it first draws so does not hold up a frame in the middle of a walk.
    /// Not what outputs need: that is made with the first frame that has any.
    void warmUp(std::span<const scene::View> eyes, std::span<const Quality> ways);

    /// What unseen space hides is found out anew with the next frame, so that it hangs on that frame's eyes alone.
    void forgetWays() { ways_.forget(); }

    /// Waits for the last frame and tells about it, its own times on the device included.
    FrameStats finish();

    /// Drawn so far: the number of the next one.
    std::uint64_t frames() const { return frames_; }
    int width() const { return width_; }
    int height() const { return height_; }
    int eyes() const { return static_cast<int>(eyes_.size()); }

    /// Pictures that are warped at less than the full resolution are left so, in the first rows and columns of what the
    /// eyes are given: displays enlarge what they show anyway. Except where there are labels: text is read at the full
    /// resolution. Off at first.
    void letDisplayEnlarge(bool lets) { letsDisplayEnlarge_ = lets; }

    /// Where eyes, knobs and what is there of the scene are those of the frame before, that is not warped again: what
    /// stands in the z-buffers is resolved anew, with the unseen and the overlay. For walkers who stand still; off at
    /// first, since who measures or compares frames wants each of them warped.
    void letFramesStand(bool lets) { letsFramesStand_ = lets; }

    /// What was observed, from the next frame on, or null; must outlive the renderer or its use. Waits for the device.
    void useCoverage(const GpuCoverage* coverage);

    /// The pictures of the next frame are kept for takeKept, at the price of a copy on the device.
    void keepNext() { keepsNext_ = true; }

    /// The pictures of the newest frame that was kept, has finished and was not taken yet. Does not wait; false, and
    /// `pictures` as it was, if there is none.
    bool takeKept(FramePictures& pictures);

    /// Waits for the last frame and returns its pictures, an eye each. At least one frame must have been
    /// drawn.
    std::vector<EyeImage> readBack();

  private:
    /// What one eye keeps to itself, so that the eyes need not wait for one another.
    struct Eye {
        EyeTarget target;
        std::optional<ScaledTarget> scaled{}; ///< made when first wanted
        bool isScaled = false;                ///< in this frame
        int warpWidth = 0, warpHeight = 0;    ///< what the scene is warped into in this frame
        /// Where the scene is warped and resolved.
        const EyeTarget& warped() const { return isScaled ? scaled->target : target; }
        std::array<StepTimer, kFramesInFlight> timers;
        SourceViews sources{};
        VisibleTiles visible{};
        DrawList list{};
        BlendList blendList{};
        std::optional<BlendTarget> blend{};      ///< made when first wanted
        std::optional<PolygonTarget> polygons{}; ///< where there are any
        std::uint64_t trianglesDrawn = 0;
        std::vector<StepTime> times{};
        std::array<Buffer, kFramesInFlight> kept{}; ///< copies of the colours; made when first wanted
        std::optional<OutputPass> output{};         ///< made when first wanted
        OverlayList overlay{};
        std::array<OverlayBuffers, kFramesInFlight> overlayBuffers{}; ///< made when first wanted
    };
    /// What decides which keys stand in the z-buffers.
    struct Warped {
        std::vector<scene::View> eyes;
        Quality quality;
        PictureSize picture;
        std::uint64_t sceneChanges = 0;
        friend bool operator==(const Warped&, const Warped&) = default;
    };
    void chooseResolution(const Quality& quality, bool hasLabels);
    void chooseEdgeSamples(const Quality& quality);
    /// What is warped into has room for so many pixels a side.
    void makeTargets(Eye& eye, const Quality& quality, int roomWidth, int roomHeight);
    void recordPolygonsInto(VkCommandBuffer commands, Eye& eye, const scene::View& view, VkDescriptorSet eyeSet);
    bool leavesOutHidden(const Quality& quality) const;
    void findWays(std::span<const scene::View> views, const Quality& quality);
    void choose(Eye& eye, const scene::View& view, const Quality& quality, int index);
    /// For what was chosen; waits for the device where there is not enough.
    void makeRoom(const Quality& quality);
    /// Whether the eyes are warped together in this frame; then their lists are united.
    bool unite(const Quality& quality, std::size_t slot, FrameStats& stats);
    void list(Eye& eye, const Quality& quality, std::size_t slot, int index);
    void prepareOutputs(std::span<const EyeOutput> outputs);
    std::span<const SourceView> capturedOf(const Eye& eye) const;
    void prepareOverlay(Eye& eye, const scene::View& view, const Overlay& overlay, std::size_t slot, int index);
    void recordCommands(Eye& eye, const scene::View& view, const Quality& quality, const EyeOutput& output,
                        std::size_t slot, int index);
    void recordScene(VkCommandBuffer commands, Eye& eye, const scene::View& view, const Quality& quality,
                     std::size_t slot, int index);
    void recordClearAndWarp(VkCommandBuffer commands, Eye& eye, const Quality& quality, std::size_t slot);
    void recordOnePass(VkCommandBuffer commands, const Quality& quality, std::size_t slot);
    void recordKeeping(VkCommandBuffer commands, Eye& eye, std::size_t slot) const;
    void readTimes(std::size_t slot, std::vector<StepTime>& times) const;

    const Device& device_;
    const GpuScene& scene_;
    int width_, height_;
    bool letsDisplayEnlarge_ = false, letsFramesStand_ = false;
    PictureSize picture_{width_, height_}; ///< of this frame
    VkDescriptorSetLayout eyeLayout_ = VK_NULL_HANDLE;
    WarpPasses warps_{};
    OcclusionPass occlusion_;
    BlendPass blend_;
    ResolvePass resolve_;
    RescalePass rescale_;
    ComputePipeline mark_;
    OverlayPass overlay_;
    const GpuCoverage* coverage_;
    scene::OpenWays ways_;   ///< of all eyes
    ComputePipeline unseen_; ///< where there is coverage
    const GpuPolygons* polygons_;
    std::optional<PolygonPass> polygonPass_;
    std::vector<Eye> eyes_;
    std::optional<StereoPass> stereo_; ///< made when first wanted, as its target
    std::optional<StereoTarget> stereoTarget_;
    PairList pairs_;
    bool isOnePass_ = false;   ///< in this frame
    bool isStanding_ = false;  ///< in this frame
    Warped lastWarped_;        ///< no eyes before the first frame
    std::uint64_t frames_ = 0; ///< drawn so far
    bool keepsNext_ = false;
    struct Kept {
        std::uint64_t frame = 0;
        PictureSize size;
        std::vector<glm::dvec3> places; ///< of the eyes, world
    };
    std::array<std::optional<Kept>, kFramesInFlight> kept_; ///< by slot; not taken yet
    FrameStats last_;
    CommandStreams streams_; ///< goes first: it waits for the device
};

} // namespace render
