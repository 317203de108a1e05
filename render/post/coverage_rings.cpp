#include "render/post/coverage_rings.h"

#include <algorithm>
#include <iterator>

#include <tbb/parallel_for.h>

namespace render {

namespace {

/// Along a line of voxels that are open or not: how far each is from what is not open.
void countAlongFirst(std::uint8_t* line, std::size_t count) {
    std::uint8_t far = 0;
    const auto visit = [&](std::uint8_t& voxel) {
        far = std::min(voxel, static_cast<std::uint8_t>(far + 1));
        voxel = far;
    };
    std::for_each(line, line + count, visit);
    far = 0;
    std::for_each(std::reverse_iterator(line + count), std::reverse_iterator(line), visit);
}

// By value: what std::min and std::max do through references g++ 12 makes no vectors of.
constexpr std::uint8_t lesser(std::uint8_t a, std::uint8_t b) {
    return a < b ? a : b;
}
constexpr std::uint8_t greater(std::uint8_t a, std::uint8_t b) {
    return a > b ? a : b;
}

/// That lie side by side, as one vector instruction or two take them.
using Side = std::array<std::uint8_t, kVoxelLines>;

/// Along such lines, the `count` voxels of each `step` apart: the least over all voxels of a line of how far that one
/// is from what is not open, along the axes before, or on this line itself, whichever is more.
void countAlong(std::uint8_t* lines, std::size_t count, std::size_t step) {
    std::vector<Side> from(count);
    for (std::size_t i = 0; i < count; ++i)
        std::copy_n(lines + i * step, kVoxelLines, from[i].begin());
    for (std::size_t i = 0; i < count; ++i) {
        Side best;
        const auto toOutside =
            static_cast<std::uint8_t>(std::min({i + 1, count - i, static_cast<std::size_t>(kMostRings)}));
        std::uint8_t most = 0; // of the lines; what lies farther off than that is no nearer to any
        for (std::size_t l = 0; l < kVoxelLines; ++l) {
            best[l] = lesser(from[i][l], toOutside);
            most = greater(most, best[l]);
        }
        for (std::uint8_t k = 1; k < most; ++k) {
            const Side &before = from[i - k], &after = from[i + k];
            most = 0;
            for (std::size_t l = 0; l < kVoxelLines; ++l) {
                best[l] = lesser(best[l], greater(k, lesser(before[l], after[l])));
                most = greater(most, best[l]);
            }
        }
        std::copy(best.begin(), best.end(), lines + i * step);
    }
}

} // namespace

void countRings(std::vector<std::uint8_t>& rings, const VoxelPlace& count) {
    const auto [x, y, z] = count;
    const std::size_t plane = x * y;
    tbb::parallel_for(std::size_t{0}, y * z, [&, x = x](std::size_t line) { countAlongFirst(&rings[line * x], x); });
    const auto alongAll = [&, x = x](std::size_t along, std::size_t step, std::size_t others, std::size_t perOther) {
        tbb::parallel_for(std::size_t{0}, others, [&](std::size_t other) {
            for (std::size_t line = 0; line < x; line += kVoxelLines)
                countAlong(&rings[other * perOther + line], along, step);
        });
    };
    alongAll(y, x, z, plane);
    alongAll(z, plane, y, x);
}

} // namespace render
