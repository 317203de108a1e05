#pragma once
// A scene on the device: vertices and quads in pages, and what the processor keeps of each tile to cull and
// draw it.

#include "render/pipeline.h"
#include "render/resources.h"
#include "render/visibility.h"
#include "scene/preference.h"
#include "scene/tile.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace render {

/// Small enough for one allocation and one view on every common device; the few that see less get smaller
/// pages.
inline constexpr std::size_t kPageBytes = std::size_t{64} << 20;

/// A tile as the draw list needs it; positions count within its page.
struct ResidentTile {
    std::uint32_t image = 0, page = 0; ///< image: of its level
    std::uint32_t firstVertex = 0, pointCount = 0, firstQuad = 0, quadCount = 0;
    std::uint32_t firstFacet = 0, facetCount = 0, firstTexel = 0, texelsInRow = 0;
    std::int32_t x0 = 0, y0 = 0; ///< first sample in the image
    float minDisparity = 0, maxDisparity = 0;
    std::uint32_t placeBits = scene::kPlaceBits;
    scene::TileMiddle middle;
};

/// A captured image, or one of its coarser levels (scene/pyramid.h).
struct ResidentImage {
    scene::Camera camera;
    scene::Pose worldFromCamera;
    BoundsExtent extent;
    std::uint32_t captured = 0, level = 0; ///< of which image it is a level, and which
    bool hasCoarser = false;
    double middleReach = 0; ///< metres from the camera to the tile in the middle of those of the captured image
};

class GpuScene {
  public:
    /// Copies the blocks to the device, pageBytes of vertices and of quads to a page (tests make them small).
    /// The blocks are not needed afterwards. A tile is never split: pageBytes must hold the largest. Throws
    /// scene::Failure if the device's memory does not suffice.
    GpuScene(const Device& device, std::span<const scene::TileBlock> blocks, std::size_t pageBytes = kPageBytes);

    /// The captured ones first, then their coarser levels.
    std::span<const ResidentImage> images() const { return images_; }
    std::size_t capturedImages() const { return capturedImages_; }
    std::span<const ResidentTile> tiles() const { return tiles_; }
    const TileBounds& bounds() const { return bounds_; }
    /// All tiles once, in order; a piece never crosses an image, nor holds both base tiles and others.
    std::span<const TilePiece> pieces() const { return pieces_; }

    std::size_t pageCount() const { return pages_.size(); }
    std::size_t bytesResident() const { return bytesResident_; }

    /// Binding 0: vertices, 1: quads, 2: facets (two texels each), 3: what they are textured with; all as texels.
    VkDescriptorSetLayout pageLayout() const { return pageLayout_; }
    VkDescriptorSet pageSet(std::size_t page) const { return pages_[page].set; }

  private:
    struct Page {
        std::array<Buffer, 4> buffers;
        std::array<BufferView, 4> views;
        VkDescriptorSet set = VK_NULL_HANDLE;
    };
    TilePiece pieceFrom(std::size_t first) const; ///< up to the last tile there is
    struct Filling;
    void layOut(std::span<const scene::TileBlock> blocks, std::size_t pageBytes);
    void layOutImage(const ResidentImage& image, std::span<const scene::Tile> tiles, Filling& filling);
    void upload(const Device& device, std::span<const scene::TileBlock> blocks);

    std::vector<ResidentImage> images_;
    std::size_t capturedImages_ = 0;
    std::vector<ResidentTile> tiles_;
    TileBounds bounds_;
    std::vector<TilePiece> pieces_;
    std::vector<Page> pages_;
    DescriptorSetLayout pageLayout_;
    DescriptorPool pool_;
    std::size_t bytesResident_ = 0;
};

} // namespace render
