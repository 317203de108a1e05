#include "scene/open_grid.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr int kSlabs = 16, kRowsOfSlab = kOpenCellsAcross / kSlabs;
/// Cells: a finer layer begins at blocks of the wider one's cells.
constexpr int kAligned = kCoverageBranching * kCoverageBranching;

double cellMetresOf(const Coverage& coverage, int level) {
    return coverage.edgeMetres / std::exp2(2 * level);
}

int cellsAcross(int level) {
    return 1 << (2 * level);
}

/// Four bits of a mask of 4 x 4 x 4: those of a row.
std::uint64_t rowOfMask(std::uint64_t mask, int y, int z) {
    return mask >> (4 * y + 16 * z) & 0xf;
}

} // namespace

std::uint64_t mirrored(std::uint64_t word) {
    const auto swap = [&](int by, std::uint64_t mask) { word = ((word >> by) & mask) | ((word & mask) << by); };
    swap(1, 0x5555555555555555), swap(2, 0x3333333333333333), swap(4, 0x0f0f0f0f0f0f0f0f);
    return __builtin_bswap64(word);
}

CellRow mirrored(const CellRow& row) {
    CellRow turned;
    for (std::size_t i = 0; i < row.size(); ++i)
        turned[i] = mirrored(row[row.size() - 1 - i]);
    return turned;
}

struct OpenCells::Slab {
    int firstZ, endZ;
};

OpenCells::OpenCells(const Coverage& coverage, int level, const GridCell& first)
    : first_(first), cellMetres_(cellMetresOf(coverage, level)),
      cornerInWorld_(coverage.cornerInWorld + cellMetres_ * glm::dvec3(first[0], first[1], first[2])),
      open_(std::size_t{kOpenCellsAcross} * kOpenCellsAcross), mirrored_(open_.size()) {
    tbb::parallel_for(0, kSlabs, [&](int i) {
        const Slab slab{i * kRowsOfSlab, (i + 1) * kRowsOfSlab};
        open(coverage, 0, {-first[0], -first[1], -first[2]}, cellsAcross(level), slab);
        const auto rows = [&](std::vector<CellRow>& all, int z) {
            return all.begin() + static_cast<std::ptrdiff_t>(rowOf(0, z));
        };
        std::transform(rows(open_, slab.firstZ), rows(open_, slab.endZ), rows(mirrored_, slab.firstZ),
                       [](const CellRow& row) { return mirrored(row); });
    });
}

/// Of a node that begins at a cell of the layer, or outside of it, and is `edge` cells wide.
void OpenCells::open(const Coverage& coverage, std::size_t index, const GridCell& at, int edge, const Slab& slab) {
    const CoverageNode& node = coverage.nodes[index];
    if (edge == kCoverageBranching) {
        // Layers begin at multiples of four: a node of such cells is in one of their words.
        for (int z = std::max(at[2], slab.firstZ); z < std::min(at[2] + edge, slab.endZ); ++z)
            for (int y = at[1]; y < at[1] + edge; ++y)
                open_[rowOf(y, z)][static_cast<std::size_t>(at[0]) / 64] |=
                    rowOfMask(~node.unseen, y - at[1], z - at[2]) << (at[0] % 64);
        return;
    }
    const int cell = edge / kCoverageBranching;
    for (int bit = 0; bit < 64; ++bit) {
        if ((node.unseen & coverageMask(bit)) != 0) continue;
        const GridCell to{at[0] + bit % 4 * cell, at[1] + bit / 4 % 4 * cell, at[2] + bit / 16 * cell};
        if (to[0] + cell <= 0 || to[1] + cell <= 0 || to[2] + cell <= slab.firstZ || to[0] >= kOpenCellsAcross ||
            to[1] >= kOpenCellsAcross || to[2] >= slab.endZ)
            continue;
        if ((node.children & coverageMask(bit)) != 0)
            open(coverage, node.firstChild + childRank(node.children, bit), to, cell, slab);
        else
            fill(to, cell, slab);
    }
}

void OpenCells::fill(const GridCell& at, int edge, const Slab& slab) {
    CellRow row{};
    const int firstX = std::max(at[0], 0), endX = std::min(at[0] + edge, kOpenCellsAcross);
    for (int x = firstX; x < endX; ++x)
        row[static_cast<std::size_t>(x) / 64] |= std::uint64_t{1} << (x % 64);
    for (int z = std::max(at[2], slab.firstZ); z < std::min(at[2] + edge, slab.endZ); ++z)
        for (int y = std::max(at[1], 0); y < std::min(at[1] + edge, kOpenCellsAcross); ++y)
            for (std::size_t w = 0; w < row.size(); ++w)
                open_[rowOf(y, z)][w] |= row[w];
}

bool OpenCells::isOpen(const GridCell& cell) const {
    if (std::any_of(cell.begin(), cell.end(), [](int at) { return at < 0 || at >= kOpenCellsAcross; })) return false;
    return (open_[rowOf(cell[1], cell[2])][static_cast<std::size_t>(cell[0]) / 64] >> (cell[0] % 64) & 1) != 0;
}

OpenGrid::OpenGrid(const Coverage& coverage, double fineEnoughMetres)
    : coverage_(&coverage), whole_(coverage, kWidestLevel, {0, 0, 0}), finestCellMetres_(whole_.cellMetres()) {
    for (; layers_ < kMostLayers && finestCellMetres_ > fineEnoughMetres; ++layers_)
        finestCellMetres_ /= kCoverageBranching;
}

bool OpenGrid::isClear(const glm::dvec3& pInWorld) const {
    glm::dvec3 within = (pInWorld - coverage_->cornerInWorld) / coverage_->edgeMetres; // in the node, [0, 1)
    if (!(within.x >= 0 && within.y >= 0 && within.z >= 0 && within.x < 1 && within.y < 1 && within.z < 1))
        return false;
    std::size_t index = 0;
    for (int level = 1; level < kWidestLevel + layers_; ++level) {
        const CoverageNode& node = coverage_->nodes[index];
        const glm::dvec3 inCells = within * double{kCoverageBranching};
        const glm::dvec3 at = glm::min(glm::floor(inCells), glm::dvec3(kCoverageBranching - 1));
        const int bit = coverageBit(static_cast<int>(at.x), static_cast<int>(at.y), static_cast<int>(at.z));
        if ((node.children & coverageMask(bit)) == 0) return (node.unseen & coverageMask(bit)) == 0;
        within = inCells - at;
        index = node.firstChild + childRank(node.children, bit);
    }
    return false; // divided: something in it is unseen, or nearly
}

GridCell OpenGrid::firstAbout(const glm::dvec3& pInWorld, int layer) const {
    const int level = kWidestLevel + layer;
    const glm::dvec3 inCells = (pInWorld - coverage_->cornerInWorld) / cellMetresOf(*coverage_, level);
    GridCell first{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double from = inCells[static_cast<int>(axis)] - kOpenCellsAcross / 2.0;
        const double most = cellsAcross(level) - kOpenCellsAcross;
        first[axis] = static_cast<int>(std::clamp(std::round(from / kAligned) * kAligned, 0.0, most));
    }
    return first;
}

} // namespace scene
