#pragma once
// What one eye draws into: its z-buffer of 64-bit keys (shaders/shared/z_key.h) and the picture it is
// resolved to.

#include "render/pipeline.h"
#include "render/resources.h"

#include <array>
#include <cstddef>
#include <string>

namespace render {

inline constexpr int kFramesInFlight = 2;

/// The layout of an eye's set: 0 draws, 1 z-buffer, 2 colours, 3 depths, 4 z-buffer as texels, to be read, 5 holes
/// (shaders/shared/hole_words.h); 6 the nearest that each block hides, 7 draws that passed a test against that, 8 how
/// many of each run; 9 what blocks hide and 10 draws as texels, to be read.
VkDescriptorSetLayout makeEyeLayout(const Device& device);
inline constexpr std::uint32_t kEyeStorageBuffers = 8; ///< of them: all but the texels

/// One z-buffer and picture serve all frames in flight: they follow one another on the queue. The draw
/// lists, which the processor writes ahead, do not.
struct EyeTarget {
    Buffer zBuffer; ///< 64 bits per pixel, row by row
    Buffer colours; ///< r | g << 8 | b << 16 | class << 24 per pixel
    Buffer depths;  ///< metres along z as float per pixel
    /// Which pixels hold anything, and a list for each row (shaders/shared/hole_words.h); before that is asked, what
    /// the warp's large pieces leave to others (shaders/shared/large_part.h).
    Buffer holes;
    Buffer listedGroups; ///< an indirect dispatch: so many workgroups draw what was left
    BufferView zTexels;
    Buffer occluders, passed, passedRuns; ///< see shaders/shared/occlusion.h
    BufferView occluderTexels;
    std::array<Buffer, kFramesInFlight> draws; ///< TileDraw; mapped
    std::array<BufferView, kFramesInFlight> drawTexels;
    std::size_t mostDraws = 0; ///< that there is room for
    DescriptorPool pool;
    std::array<VkDescriptorSet, kFramesInFlight> sets{};
};

/// Runs whose draws can be tested in one batch.
inline constexpr std::size_t kMostTestedRuns = 4096;

/// Throws scene::Failure if a shader cannot see so many bytes of `what`, and says the remedy.
void requireRange(const Device& device, std::size_t bytes, const std::string& what, const std::string& remedy);

/// With room for some draws. Throws scene::Failure if the device cannot see such an image at once.
EyeTarget makeEyeTarget(const Device& device, VkDescriptorSetLayout eyeLayout, int width, int height);

/// Makes room for so many draws, and some more. Nothing may be using the target. Throws scene::Failure if the device
/// cannot see such a list at once.
void makeRoomForDraws(const Device& device, EyeTarget& target, std::size_t draws);

} // namespace render
