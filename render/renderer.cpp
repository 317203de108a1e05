#include "render/renderer.h"

#include "render/draw_needs.h"
#include "render/shaders/shared/large_part.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>

namespace render {

namespace {

constexpr std::size_t kFirstBlendDraws = 4096;

constexpr Barrier kAfterLastFrame{kCompute | kTransfer, kRead | kWrite | VK_ACCESS_TRANSFER_READ_BIT,
                                  kTransfer | kCompute, VK_ACCESS_TRANSFER_WRITE_BIT | kRead | kWrite};
constexpr Barrier kAfterClear{kTransfer, VK_ACCESS_TRANSFER_WRITE_BIT, kCompute, kRead | kWrite};
constexpr Barrier kAfterWarp{kCompute, kRead | kWrite, kCompute, kRead | kWrite};
constexpr Barrier kBeforeMerge{kCompute, kRead | kWrite, kCompute, kRead | kWrite};
constexpr Barrier kAfterResolve{kCompute, kWrite, VK_PIPELINE_STAGE_HOST_BIT | kTransfer,
                                VK_ACCESS_HOST_READ_BIT | VK_ACCESS_TRANSFER_READ_BIT};

/// The resolved picture is drawn over.
constexpr Barrier kBetweenPictures{kCompute, kWrite, kCompute, kRead | kWrite};
constexpr Barrier kAfterKeeping{kTransfer, VK_ACCESS_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_HOST_BIT,
                                VK_ACCESS_HOST_READ_BIT};

std::size_t pixelsOf(const PictureSize& size) {
    return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
}

std::uint32_t mostPointsOf(const GpuScene& scene) {
    std::uint32_t most = 0;
    for (const ResidentTile& tile : scene.tiles())
        most = std::max(most, tile.pointCount);
    return most;
}

void recordClear(VkCommandBuffer commands, const EyeTarget& target, int width, int height) {
    const VkDeviceSize pixels = static_cast<VkDeviceSize>(width) * static_cast<VkDeviceSize>(height);
    vkCmdFillBuffer(commands, target.zBuffer.handle(), 0, pixels * sizeof(std::uint64_t), 0);
    vkCmdFillBuffer(commands, target.holes.handle(), 0, kLargePartsHead * sizeof(std::uint32_t), 0);
}

/// Of what is interpolated; nothing if the picture is not. Points that stand in for splats, while finer ones are read,
/// count as standing half as far again from their pixels' centres: they are wider than that is.
std::optional<PlaceSteps> placeStepsOf(const Quality& quality) {
    if (!quality.interpolatesSamples || quality.isBlended) return std::nullopt;
    if (quality.warp == Warp::points) return placeStepsOfPoints();
    if (quality.warp == Warp::splats) return placeStepsOfSplats();
    return std::nullopt;
}

} // namespace

Renderer::Renderer(const Device& device, const GpuScene& scene, int width, int height, int eyes,
                   const GpuCoverage* coverage, const GpuPolygons* polygons)
    : device_(device), scene_(scene), width_(width), height_(height), eyeLayout_(makeEyeLayout(device)),
      occlusion_(makeOcclusionPass(device, eyeLayout_)),
      blend_(makeBlendPass(device, scene.pageLayout(), eyeLayout_, mostPointsOf(scene))),
      resolve_(makeResolvePass(device, eyeLayout_)), rescale_(makeRescalePass(device)),
      mark_(makeMarkPass(device, eyeLayout_)), overlay_(makeOverlayPass(device, eyeLayout_)), coverage_(coverage),
      unseen_(coverage != nullptr ? makeUnseenPipeline(device, *coverage, eyeLayout_) : ComputePipeline{}),
      polygons_(polygons), streams_(device, eyes) {
    assert(width > 0 && height > 0 && eyes >= 1 && eyes <= kMaxEyes);
    for (const Warp warp : {Warp::points, Warp::mesh, Warp::adaptive, Warp::splats})
        warps_[static_cast<std::size_t>(warp)] = makeWarpPass(device, warp, scene.pageLayout(), eyeLayout_);
    if (polygons != nullptr) polygonPass_ = makePolygonPass(device, *polygons, eyeLayout_, 1);
    for (int eye = 0; eye < eyes; ++eye)
        eyes_.push_back({.target = makeEyeTarget(device, eyeLayout_, width, height),
                         .timers = {StepTimer(device), StepTimer(device)}});
}

FrameStats Renderer::draw(std::span<const scene::View> views, const Quality& quality,
                          std::span<const EyeOutput> outputs, const Overlay* overlay) {
    assert(views.size() == eyes_.size() && (outputs.empty() || outputs.size() == eyes_.size()));
    const std::size_t slot = frames_ % kFramesInFlight;
    FrameStats stats;
    stats.frame = frames_;
    timed(stats.cpu, "wait", kWholeFrame, [&] { streams_.wait(slot); });
    if (frames_ >= kFramesInFlight) {
        stats.gpuFrame = frames_ - kFramesInFlight;
        readTimes(slot, stats.gpu);
    }

    chooseResolution(quality, overlay != nullptr && !overlay->labels.empty());
    Warped warped{{views.begin(), views.end()}, quality, picture_, scene_.changes()};
    isStanding_ = letsFramesStand_ && warped == lastWarped_;
    lastWarped_ = {}; // until the device has been told to
    if (!isStanding_) timed(stats.cpu, "ways", kWholeFrame, [&] { findWays(views, quality); });
    tbb::parallel_for(std::size_t{0}, eyes_.size(), [&](std::size_t i) {
        eyes_[i].times.clear();
        if (!isStanding_) choose(eyes_[i], views[i], quality, static_cast<int>(i));
    });
    if (!isStanding_) makeRoom(quality);
    isOnePass_ = !isStanding_ && unite(quality, slot, stats);
    prepareOutputs(outputs);
    tbb::parallel_for(std::size_t{0}, eyes_.size(), [&](std::size_t i) {
        const int index = static_cast<int>(i);
        if (!isStanding_) list(eyes_[i], quality, slot, index);
        prepareOverlay(eyes_[i], views[i], overlay != nullptr ? *overlay : Overlay{}, slot, index);
        recordCommands(eyes_[i], views[i], quality, outputs.empty() ? EyeOutput{} : outputs[i], slot, index);
    });
    kept_[slot].reset();
    if (keepsNext_) {
        kept_[slot] = Kept{frames_, picture_, {}};
        for (const scene::View& view : views)
            kept_[slot]->places.push_back(view.worldFromEye.translation);
    }
    keepsNext_ = false;
    timed(stats.cpu, "submit", kWholeFrame, [&] { streams_.submit(slot); });
    lastWarped_ = std::move(warped);

    stats.isOnePass = isOnePass_;
    stats.isStanding = isStanding_;
    stats.picture = picture_;
    for (std::size_t i = 0; i < eyes_.size(); ++i) {
        const Eye& eye = eyes_[i];
        stats.cpu.insert(stats.cpu.end(), eye.times.begin(), eye.times.end());
        EyeCounts& counts = stats.eyes[i];
        counts.tilesTested = static_cast<std::uint32_t>(scene_.tiles().size());
        counts.tilesRejected = counts.tilesTested;
        for (const std::uint32_t count : eye.visible.counts)
            counts.tilesRejected -= count;
        counts.tilesDrawn = eye.list.tiles;
        counts.samplesDrawn = eye.list.items;
        counts.samplesBlended = quality.isBlended ? eye.blendList.items : 0;
        counts.trianglesDrawn = eye.trianglesDrawn;
        counts.overlayStrokes = static_cast<std::uint32_t>(eye.overlay.strokes.size());
        counts.overlayDropped = eye.overlay.dropped;
    }
    ++frames_;
    last_ = stats;
    return stats;
}

void Renderer::warmUp(std::span<const scene::View> views, std::span<const Quality> ways) {
    const bool keeps = std::exchange(keepsNext_, false);
    const auto forget = [&] { frames_ = 0, lastWarped_ = {}, keepsNext_ = keeps; };
    try {
        for (const Quality& way : ways) {
            draw(views, way);
            for (const Warp warp : warpsFor(way, scene_.isStreamed()))
                compile(warps_[static_cast<std::size_t>(warp)]);
        }
        streams_.waitForAll();
    } catch (...) {
        forget();
        throw;
    }
    forget();
}

void Renderer::useCoverage(const GpuCoverage* coverage) {
    streams_.waitForAll(); // what goes may be in use
    coverage_ = coverage;
    // What it hid is not in the z-buffers.
    if (std::any_of(eyes_.begin(), eyes_.end(), [](const Eye& eye) { return eye.sources.behindUnseen > 0; }))
        lastWarped_ = {};
    ways_.forget();
    unseen_ = coverage != nullptr ? makeUnseenPipeline(device_, *coverage, eyeLayout_) : ComputePipeline{};
}

void Renderer::chooseResolution(const Quality& quality, bool hasLabels) {
    assert(quality.resolutionScale >= kMinResolutionScale && quality.resolutionScale <= kMaxResolutionScale);
    const int width = scaledSide(width_, quality.resolutionScale),
              height = scaledSide(height_, quality.resolutionScale);
    // Room for the eye's own size at least: whoever trades resolution for speed changes it again and again.
    const int roomWidth = std::max(width, width_), roomHeight = std::max(height, height_);
    const bool isLeftSmall = letsDisplayEnlarge_ && !hasLabels && width <= width_ && height <= height_;
    picture_ = isLeftSmall ? PictureSize{width, height} : PictureSize{width_, height_};
    const bool isScaled = width != picture_.width || height != picture_.height;
    chooseEdgeSamples(quality);
    for (Eye& eye : eyes_) {
        eye.isScaled = isScaled, eye.warpWidth = width, eye.warpHeight = height;
        makeTargets(eye, quality, roomWidth, roomHeight);
    }
}

void Renderer::chooseEdgeSamples(const Quality& quality) {
    if (!polygonPass_) return;
    const int samples = edgeSamplesOf(device_, quality.edgeSamples);
    if (samples == polygonPass_->samples) return;
    streams_.waitForAll(); // what goes may be in use
    for (Eye& eye : eyes_)
        eye.polygons.reset();
    polygonPass_ = makePolygonPass(device_, *polygons_, eyeLayout_, samples);
}

void Renderer::makeTargets(Eye& eye, const Quality& quality, int roomWidth, int roomHeight) {
    const std::size_t room = static_cast<std::size_t>(roomWidth) * static_cast<std::size_t>(roomHeight);
    const bool needsBlend = quality.isBlended && (!eye.blend || eye.blend->pixels < room),
               needsScaled = eye.isScaled && (!eye.scaled || eye.scaled->pixels < room),
               needsPolygons = polygonPass_ && (!eye.polygons || eye.polygons->colours.width < roomWidth ||
                                                eye.polygons->colours.height < roomHeight);
    if (!needsBlend && !needsScaled && !needsPolygons) return;
    streams_.waitForAll(); // what goes may be in use
    if (needsBlend) {
        eye.blend.reset();
        eye.blend = makeBlendTarget(device_, blend_, room, kFirstBlendDraws);
    }
    if (needsScaled) {
        eye.scaled.reset();
        eye.scaled = makeScaledTarget(device_, rescale_, eyeLayout_, eye.target, roomWidth, roomHeight);
    }
    if (needsPolygons) {
        eye.polygons.reset();
        eye.polygons = makePolygonTarget(device_, *polygonPass_, roomWidth, roomHeight);
    }
}

void Renderer::makeRoom(const Quality& quality) {
    for (Eye& eye : eyes_) {
        EyeTarget& target = eye.isScaled ? eye.scaled->target : eye.target;
        const bool isShort = eye.list.tiles > target.mostDraws,
                   isShortToBlend = quality.isBlended && eye.blendList.tiles > eye.blend->mostDraws;
        if (!isShort && !isShortToBlend) continue;
        streams_.waitForAll(); // what goes may be in use
        makeRoomForDraws(device_, target, eye.list.tiles);
        if (!isShortToBlend) continue;
        const std::size_t pixels = eye.blend->pixels;
        eye.blend.reset();
        eye.blend = makeBlendTarget(device_, blend_, pixels, eye.blendList.tiles + eye.blendList.tiles / 2);
    }
}

bool Renderer::unite(const Quality& quality, std::size_t slot, FrameStats& stats) {
    if (!quality.isOnePass || !whyNotInOnePass(device_, quality, eyes()).empty()) return false;
    bool canBe = false;
    timed(stats.cpu, "unite", kWholeFrame, [&] {
        canBe = uniteDraws(scene_.tiles().size(), eyes_[0].list, eyes_[1].list, !device_.isProcessor(), pairs_);
        if (!canBe) return;
        if (!stereo_) stereo_ = makeStereoPass(device_, scene_.pageLayout(), eyeLayout_, mostPointsOf(scene_));
        if (!stereoTarget_ || stereoTarget_->mostPairs < pairs_.pairs.size()) {
            streams_.waitForAll(); // what goes may be in use
            stereoTarget_.reset();
            stereoTarget_ = makeStereoTarget(device_, *stereo_, pairs_.pairs.size() + pairs_.pairs.size() / 2);
        }
        std::copy(pairs_.pairs.begin(), pairs_.pairs.end(), stereoTarget_->pairs[slot].as<PairDraw>().begin());
    });
    return canBe;
}

void Renderer::findWays(std::span<const scene::View> views, const Quality& quality) {
    if (coverage_ == nullptr || !quality.leavesOutBehindUnseen()) return ways_.forget();
    std::vector<glm::dvec3> eyes;
    for (const scene::View& view : views)
        eyes.push_back(view.worldFromEye.translation);
    ways_.standAt(coverage_->openGrid(), eyes);
}

bool Renderer::leavesOutHidden(const Quality& quality) const {
    // A card draws tiles sooner than it finds out that it need not.
    return quality.leavesOutHidden && device_.isProcessor();
}

void Renderer::choose(Eye& eye, const scene::View& given, const Quality& quality, int index) {
    assert(given.camera.width == width_ && given.camera.height == height_);
    const scene::View view{scene::resized(given.camera, eye.warpWidth, eye.warpHeight), given.worldFromEye};
    timed(eye.times, "cull", index, [&] {
        const double margin = marginOf(quality, scene_.isStreamed());
        findSourceViews(scene_.index(), view, quality, margin, scene_.shares(), ways_, eye.sources);
        scene_.index().findPiecesOf(eye.sources.seen, eye.visible.pieces);
        const bool mayStandIn = hasGaps(scene_.places());
        const auto planesFor = [&](const TilePiece& piece) -> std::optional<ImagePlanes> {
            const SourceView& source = eye.sources.of[piece.image];
            const bool isBlended =
                quality.isBlended && source.level == 0 && mayBeBlended(piece, source.eyeFromCamera, quality.blend);
            if (!isBlended && !mayBeChosen(piece, source, quality, mayStandIn)) return std::nullopt;
            return planesOf(source.eyeImageFromSource, eye.warpWidth, eye.warpHeight, margin,
                            scene_.images()[piece.image].extent);
        };
        cull(scene_.bounds(), scene_.pieces(), planesFor, eye.visible);
    });
    const std::uint64_t leastItems = device_.looksAlways() ? 0 : kLeastItemsToLook;
    timed(eye.times, "choose", index, [&] {
        chooseDraws(scene_.index(), scene_.places(), eye.sources.of, eye.visible, quality, eye.list,
                    device_.isProcessor() ? static_cast<double>(eye.warpWidth) * eye.warpHeight : 0,
                    leavesOutHidden(quality) ? leastItems : kNeverLook);
        if (quality.isBlended)
            chooseBlendDraws(scene_.index(), scene_.places(), capturedOf(eye), eye.visible, quality.blend,
                             polygonPass_.has_value(), eye.blendList);
    });
}

void Renderer::prepareOutputs(std::span<const EyeOutput> outputs) {
    for (std::size_t i = 0; i < outputs.size(); ++i) {
        if (outputs[i].image == VK_NULL_HANDLE || isFor(eyes_[i].output, outputs[i])) continue;
        streams_.waitForAll();
        eyes_[i].output = makeOutputPass(device_, eyes_[i].target, outputs[i]);
    }
}

std::span<const SourceView> Renderer::capturedOf(const Eye& eye) const {
    return std::span<const SourceView>(eye.sources.of).first(scene_.capturedImages());
}

void Renderer::list(Eye& eye, const Quality& quality, std::size_t slot, int index) {
    timed(eye.times, "list", index, [&] {
        writeDraws(scene_.index(), scene_.places(), eye.sources.of, eye.list, eye.warped().draws[slot].as<TileDraw>());
        if (quality.isBlended)
            writeBlendDraws(scene_.index(), scene_.places(), capturedOf(eye), eye.blendList,
                            eye.blend->draws[slot].as<BlendDraw>());
    });
}

void Renderer::prepareOverlay(Eye& eye, const scene::View& view, const Overlay& overlay, std::size_t slot, int index) {
    if (overlay.empty()) {
        eye.overlay = {};
        return;
    }
    timed(eye.times, "overlay", index, [&] {
        const scene::View seen{scene::resized(view.camera, picture_.width, picture_.height), view.worldFromEye};
        listOverlay(overlay, seen, eye.overlay, static_cast<double>(picture_.width) / width_);
        if (eye.overlay.bins.empty()) return;
        OverlayBuffers& buffers = eye.overlayBuffers[slot];
        if (buffers.set == VK_NULL_HANDLE) buffers = makeOverlayBuffers(device_, overlay_, width_, height_);
        write(eye.overlay, buffers);
    });
}

void Renderer::recordCommands(Eye& eye, const scene::View& view, const Quality& quality, const EyeOutput& output,
                              std::size_t slot, int index) {
    timed(eye.times, "record", index, [&] {
        const VkCommandBuffer commands = streams_.begin(slot, index);
        const VkDescriptorSet eyeSet = eye.warped().sets[slot];
        StepTimer& timer = eye.timers[slot];
        // In one pass the first eye's commands, which come before, have waited for both.
        if (!isOnePass_ || index == 0) record(commands, kAfterLastFrame);
        timer.begin(commands);

        if (!isStanding_) recordScene(commands, eye, view, quality, slot, index);

        const std::optional<PlaceSteps> places = placeStepsOf(quality);
        const Rescaling rescaling{eye.warpWidth, eye.warpHeight, picture_.width, picture_.height};
        const bool keepsPlaces = places && eye.isScaled && rescaling.isEnlarging();
        recordResolve(commands, resolve_, eyeSet, eye.warpWidth, eye.warpHeight, quality.holes,
                      keepsPlaces ? PlaceUse::kept
                      : places    ? PlaceUse::interpolated
                                  : PlaceUse::none,
                      places.value_or(PlaceSteps{}));
        if (quality.isBlended) {
            record(commands, kBetweenPictures);
            recordBlendResolve(commands, blend_, eyeSet, *eye.blend, slot, eye.warpWidth, eye.warpHeight);
        }
        record(commands, kAfterResolve);
        timer.mark(commands, "resolve");

        if (coverage_ != nullptr && quality.showUnseen) {
            record(commands, kBetweenPictures);
            recordUnseen(commands, unseen_, *coverage_, eyeSet,
                         scene::View{scene::resized(view.camera, eye.warpWidth, eye.warpHeight), view.worldFromEye},
                         quality);
            record(commands, kAfterResolve);
            timer.mark(commands, "unseen");
        }

        if (eye.isScaled) {
            record(commands, kBetweenPictures);
            recordRescale(commands, rescale_, *eye.scaled, rescaling, keepsPlaces ? places : std::nullopt);
            record(commands, kAfterResolve);
            timer.mark(commands, "rescale");
        }

        if (quality.marksUnmeasured) {
            record(commands, kBetweenPictures);
            recordMark(commands, mark_, eye.target.sets[slot], picture_.width, picture_.height);
            record(commands, kAfterResolve);
            timer.mark(commands, "mark");
        }

        if (!eye.overlay.bins.empty()) {
            record(commands, kBetweenPictures);
            recordOverlay(commands, overlay_, eye.overlay, eye.overlayBuffers[slot], eye.target.sets[slot]);
            record(commands, kAfterResolve);
            timer.mark(commands, "overlay");
        }

        if (keepsNext_) recordKeeping(commands, eye, slot);
        if (output.image != VK_NULL_HANDLE) {
            recordOutput(commands, device_, *eye.output, slot, picture_, {width_, height_}, output);
            timer.mark(commands, "output");
        }
    });
}

void Renderer::recordScene(VkCommandBuffer commands, Eye& eye, const scene::View& view, const Quality& quality,
                           std::size_t slot, int index) {
    const VkDescriptorSet eyeSet = eye.warped().sets[slot];
    StepTimer& timer = eye.timers[slot];
    if (!isOnePass_)
        recordClearAndWarp(commands, eye, quality, slot);
    else if (index == 0)
        recordOnePass(commands, quality, slot);

    if (polygonPass_) {
        recordPolygonsInto(commands, eye, view, eyeSet);
        timer.mark(commands, "polygons");
    }

    if (quality.isBlended) {
        recordBlend(commands, blend_, scene_, eyeSet, *eye.blend, slot, eye.blendList.runs, eye.warpWidth,
                    eye.warpHeight);
        record(commands, kAfterWarp);
        timer.mark(commands, "blend");
    }
}

void Renderer::recordClearAndWarp(VkCommandBuffer commands, Eye& eye, const Quality& quality, std::size_t slot) {
    recordClear(commands, eye.warped(), eye.warpWidth, eye.warpHeight);
    record(commands, kAfterClear);
    eye.timers[slot].mark(commands, "clear");

    recordWarpInBatches(commands, occlusion_, warps_, scene_, eye.warped().sets[slot], eye.warped(), eye.list.runs,
                        eye.warpWidth, eye.warpHeight, closesGaps(quality));
    record(commands, kAfterWarp);
    eye.timers[slot].mark(commands, "warp");
}

void Renderer::recordOnePass(VkCommandBuffer commands, const Quality& quality, std::size_t slot) {
    StepTimer& timer = eyes_[0].timers[slot];
    for (const Eye& eye : eyes_)
        recordClear(commands, eye.warped(), eye.warpWidth, eye.warpHeight);
    record(commands, kAfterClear);
    timer.markBoth(commands, "clear");

    recordStereoWarp(commands, *stereo_, occlusion_, scene_,
                     {eyes_[0].warped().sets[slot], eyes_[1].warped().sets[slot]}, *stereoTarget_, slot, pairs_.runs,
                     eyes_[0].warpWidth, eyes_[0].warpHeight, closesGaps(quality));
    record(commands, kAfterWarp);
    timer.markBoth(commands, "warp");
}

void Renderer::recordPolygonsInto(VkCommandBuffer commands, Eye& eye, const scene::View& view, VkDescriptorSet eyeSet) {
    const scene::View warped{scene::resized(view.camera, eye.warpWidth, eye.warpHeight), view.worldFromEye};
    eye.trianglesDrawn = recordPolygons(commands, *polygonPass_, *polygons_, *eye.polygons, warped);
    record(commands, kBeforeMerge);
    recordPolygonMerge(commands, *polygonPass_, *eye.polygons, eyeSet, eye.warpWidth, eye.warpHeight);
    record(commands, kAfterWarp);
}

void Renderer::recordKeeping(VkCommandBuffer commands, Eye& eye, std::size_t slot) const {
    const Buffer& colours = eye.target.colours;
    if (eye.kept[slot].handle() == VK_NULL_HANDLE)
        eye.kept[slot] = Buffer(device_, colours.size(), VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryUse::hostReads);
    const VkBufferCopy picture{0, 0, pixelsOf(picture_) * sizeof(std::uint32_t)};
    vkCmdCopyBuffer(commands, colours.handle(), eye.kept[slot].handle(), 1, &picture);
    record(commands, kAfterKeeping);
}

void Renderer::readTimes(std::size_t slot, std::vector<StepTime>& times) const {
    for (std::size_t i = 0; i < eyes_.size(); ++i)
        eyes_[i].timers[slot].read(static_cast<int>(i), times);
}

FrameStats Renderer::finish() {
    assert(frames_ > 0);
    const std::size_t slot = (frames_ - 1) % kFramesInFlight;
    streams_.wait(slot);
    last_.gpu.clear();
    last_.gpuFrame = last_.frame;
    readTimes(slot, last_.gpu);
    return last_;
}

bool Renderer::takeKept(FramePictures& pictures) {
    std::optional<std::size_t> newest;
    for (std::size_t slot = 0; slot < kept_.size(); ++slot)
        if (kept_[slot] && (!newest || kept_[slot]->frame > kept_[*newest]->frame) && streams_.isDone(slot))
            newest = slot;
    if (!newest) return false;
    const Kept& kept = *kept_[*newest];
    pictures.frame = kept.frame;
    pictures.places = kept.places;
    pictures.width = kept.size.width, pictures.height = kept.size.height;
    pictures.eyes.resize(eyes_.size());
    for (std::size_t i = 0; i < eyes_.size(); ++i) {
        const auto pixels = eyes_[i].kept[*newest].as<const std::uint32_t>().first(pixelsOf(kept.size));
        pictures.eyes[i].assign(pixels.begin(), pixels.end());
    }
    for (std::optional<Kept>& other : kept_)
        if (other && other->frame <= pictures.frame) other.reset();
    return true;
}

std::vector<EyeImage> Renderer::readBack() {
    assert(frames_ > 0);
    streams_.wait((frames_ - 1) % kFramesInFlight);
    std::vector<EyeImage> images;
    for (const Eye& eye : eyes_)
        images.push_back(render::readBack(device_, eye.target, last_.picture.width, last_.picture.height));
    return images;
}

} // namespace render
