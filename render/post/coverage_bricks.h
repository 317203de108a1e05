#pragma once
// Bricks: voxels of the grid as 4 x 4 x 4 finer ones, where there is both open and unseen space in them, or where they
// are open right beside what is not; and those of these in which there is both, and so on.
//
//     +---+---+---+---+
//     | 2 | 1 |###| 1 |    numbers: rings of open voxels of this size about each, itself the first, across bricks'
//     | 2 | 1 |###| 1 |             borders, whatever stands beside the brick
//     | 2 | 1 | 1 | 1 |    #: closed: unseen, or a brick
//     | 2 | 2 | 2 | 2 |
//     +---+---+---+---+

#include "render/post/coverage_rings.h"
#include "scene/coverage.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace render {

/// The tree of what was observed, without children that hold nothing unseen: those count as seen whole. The coverage
/// must outlive it.
class UnseenTree {
  public:
    explicit UnseenTree(const scene::Coverage& coverage);

    const std::vector<scene::CoverageNode>& nodes() const { return *nodes_; }
    std::uint64_t divided(std::size_t node) const { return divided_[node]; } ///< its cells that are nodes
    std::uint64_t closed(std::size_t node) const { return (*nodes_)[node].unseen | divided_[node]; }
    bool hasUnseen(std::size_t node) const { return closed(node) != 0; } ///< in it or below
    /// The node that a divided cell is.
    std::size_t child(std::size_t node, int bit) const {
        const scene::CoverageNode& parent = (*nodes_)[node];
        return parent.firstChild + scene::childRank(parent.children, bit);
    }

  private:
    const std::vector<scene::CoverageNode>* nodes_;
    std::vector<std::uint64_t> divided_;
};

/// Of bricks that are nodes, those of the grid's voxels first, then those of their voxels, and so on.
struct BrickOrder {
    std::vector<std::uint32_t> nodes; ///< that they are
    std::vector<std::uint32_t> bases; ///< of each, the first of those that its own voxels are
};
BrickOrder orderBricks(const UnseenTree& tree, std::vector<std::uint32_t> nodesOfGrid);

/// A grid of voxels some of which are nodes; all is unseen outside of it.
class BrickedGrid {
  public:
    /// words: of each voxel, x first, then y, then z: 0 if all of it is unseen, kBrick and which brick it is if it is a
    /// node, or what else stands for an open one. All must outlive this.
    BrickedGrid(const UnseenTree& tree, const BrickOrder& order, const VoxelPlace& count,
                std::span<const std::uint32_t> words);

    /// The words of each brick (shaders/shared/unseen.h), of a voxel that is a node and of all below, into those of
    /// all.
    void writeDivided(const VoxelPlace& at, std::span<std::uint32_t> all) const;

    /// Of a voxel that is open: as that brick.
    void writeOpen(const VoxelPlace& at, std::size_t brick, std::span<std::uint32_t> all) const;

  private:
    struct About; ///< what stands in and about a brick

    std::uint32_t wordAt(const VoxelPlace& at, int x, int y, int z) const; ///< so many to the side; 0 outside
    About aboutVoxel(const VoxelPlace& at) const;
    void write(const About& about, std::size_t brick, std::span<std::uint32_t> all) const;

    const UnseenTree& tree_;
    const BrickOrder& order_;
    const VoxelPlace& count_;
    std::span<const std::uint32_t> words_;
};

} // namespace render
