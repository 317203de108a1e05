#pragma once
// How far about each voxel of a grid nothing is unseen.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace render {

using VoxelPlace = std::array<std::size_t, 3>;

inline constexpr std::uint8_t kMostRings = 254; ///< and, before they are counted: open
inline constexpr std::size_t kVoxelLines = 32;  ///< rows of voxels along x are whole multiples of it

/// Counts the rings of open voxels about each open one, itself the first, by one more than there are whole cubes of
/// open ones about it: the chessboard distance (Rosenfeld and Pfaltz, "Distance functions on digital pictures", 1968)
/// to the nearest that is not, which one axis after the other finds. rings: by voxel, x first, then y, then z;
/// kMostRings where it is open, 0 where it is not. Outside nothing was observed. The same on any number of threads.
void countRings(std::vector<std::uint8_t>& rings, const VoxelPlace& count);

} // namespace render
