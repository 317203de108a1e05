#include "scene/open_ways.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <tbb/parallel_invoke.h>

namespace scene {

namespace {

using Row = OpenGrid::Row;

/// About an eye, in which it may move before all is found anew: metres, as far as that is so many cells.
constexpr double kPlaceMetres = 0.2, kLeastPlace = 2, kMostPlace = 8;
constexpr double kBesideFace = 0.01; ///< cells: whoever is so near to a face counts as on both sides of it
constexpr double kLeastPart = 8;     ///< cells: smaller parts of a box are not asked about one by one
constexpr int kBlock = 4, kBlocksAcross = kOpenGridAcross / kBlock;

std::uint64_t mirrored(std::uint64_t w) {
    const auto swap = [&](int by, std::uint64_t mask) { w = ((w >> by) & mask) | ((w & mask) << by); };
    swap(1, 0x5555555555555555), swap(2, 0x3333333333333333), swap(4, 0x0f0f0f0f0f0f0f0f);
    return __builtin_bswap64(w);
}

Row mirrored(const Row& row) {
    Row turned;
    for (std::size_t i = 0; i < row.size(); ++i)
        turned[i] = mirrored(row[row.size() - 1 - i]);
    return turned;
}

bool isEmpty(const Row& row) {
    std::uint64_t any = 0;
    for (const std::uint64_t word : row)
        any |= word;
    return any == 0;
}

/// Each cell, and the one after it.
Row spread(const Row& row) {
    Row wider;
    std::uint64_t carried = 0;
    for (std::size_t i = 0; i < row.size(); ++i) {
        wider[i] = row[i] | row[i] << 1 | carried;
        carried = row[i] >> 63;
    }
    return wider;
}

/// From cells of the row along x as far as it is open. An addition carries through what is open and stops at what is
/// not.
Row filled(const Row& from, const Row& open) {
    Row all;
    std::uint64_t carry = 0;
    for (std::size_t i = 0; i < from.size(); ++i) {
        const std::uint64_t start = from[i] & open[i], half = open[i] + start, sum = half + carry;
        carry = static_cast<std::uint64_t>(half < start) | static_cast<std::uint64_t>(sum < half);
        all[i] = ((sum ^ open[i]) | start) & open[i];
    }
    return all;
}

/// A bit for each four of a word.
std::uint64_t anyOfFour(std::uint64_t w) {
    w |= w >> 1, w |= w >> 2;
    w &= 0x1111111111111111;
    w = (w | w >> 3) & 0x0303030303030303;
    w = (w | w >> 6) & 0x000f000f000f000f;
    w = (w | w >> 12) & 0x000000ff000000ff;
    return (w | w >> 24) & 0xffff;
}

/// Bits of a word of 64 from one to another, both included.
std::uint64_t bitsFrom(int first, int last) {
    return (~std::uint64_t{0} << first) & (~std::uint64_t{0} >> (63 - last));
}

} // namespace

OpenGrid::OpenGrid(const Coverage& coverage)
    : cornerInWorld_(coverage.cornerInWorld), cellMetres_(coverage.edgeMetres / kOpenGridAcross),
      open_(std::size_t{kOpenGridAcross} * kOpenGridAcross), mirrored_(open_.size()), clear_(open_.size()) {
    openCells(coverage, 0, {0, 0, 0}, kOpenGridAcross);
    std::transform(open_.begin(), open_.end(), mirrored_.begin(), [](const Row& row) { return mirrored(row); });
}

void OpenGrid::openCells(const Coverage& coverage, std::size_t index, const GridCell& first, int edge) {
    const CoverageNode& node = coverage.nodes[index];
    const int cell = edge / kCoverageBranching;
    for (int bit = 0; bit < 64; ++bit) {
        const std::uint64_t mask = coverageMask(bit);
        if ((node.unseen & mask) != 0) continue;
        const GridCell at{first[0] + bit % 4 * cell, first[1] + bit / 4 % 4 * cell, first[2] + bit / 16 * cell};
        const bool isDivided = (node.children & mask) != 0;
        if (isDivided && cell > 1) {
            openCells(coverage, node.firstChild + childRank(node.children, bit), at, cell);
            continue;
        }
        fill(open_, at, cell);
        if (!isDivided) fill(clear_, at, cell);
    }
}

void OpenGrid::fill(std::vector<Row>& rows, const GridCell& first, int edge) {
    for (int z = first[2]; z < first[2] + edge; ++z)
        for (int y = first[1]; y < first[1] + edge; ++y)
            for (int x = first[0]; x < first[0] + edge; ++x)
                rows[rowOf(y, z)][static_cast<std::size_t>(x) / 64] |= std::uint64_t{1} << (x % 64);
}

bool OpenGrid::holds(const std::vector<Row>& rows, const GridCell& cell) {
    if (std::any_of(cell.begin(), cell.end(), [](int at) { return at < 0 || at >= kOpenGridAcross; })) return false;
    return (rows[rowOf(cell[1], cell[2])][static_cast<std::size_t>(cell[0]) / 64] >> (cell[0] % 64) & 1) != 0;
}

namespace {

GridCell cellOf(const glm::dvec3& inCells) {
    // What is too far away for an int is outside all the same.
    const glm::dvec3 at = glm::clamp(glm::floor(inCells), -1e6, 1e6);
    return {static_cast<int>(at.x), static_cast<int>(at.y), static_cast<int>(at.z)};
}

/// The cells that an eye is in or right beside.
std::vector<GridCell> cellsAbout(const OpenGrid& grid, const glm::dvec3& eyeInWorld) {
    const glm::dvec3 inCells = (eyeInWorld - grid.cornerInWorld()) / grid.cellMetres();
    std::vector<GridCell> cells;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 side((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, (corner & 4) != 0 ? 1 : -1);
        const GridCell beside = cellOf(inCells + kBesideFace * side);
        if (std::find(cells.begin(), cells.end(), beside) == cells.end()) cells.push_back(beside);
    }
    return cells;
}

} // namespace

void OpenWays::forget() {
    isKnown_ = false;
    isPlace_.clear();
}

bool OpenWays::areStillWithin(const OpenGrid& grid, std::span<const glm::dvec3> eyesInWorld) const {
    const auto isPlace = [&](const GridCell& cell) {
        std::size_t at = 0;
        for (std::size_t axis = 3; axis-- > 0;) {
            if (cell[axis] < low_[axis] || cell[axis] > high_[axis]) return false;
            at = at * static_cast<std::size_t>(high_[axis] - low_[axis] + 1) +
                 static_cast<std::size_t>(cell[axis] - low_[axis]);
        }
        return isPlace_[at] != 0;
    };
    return !isPlace_.empty() && std::all_of(eyesInWorld.begin(), eyesInWorld.end(), [&](const glm::dvec3& eye) {
        const std::vector<GridCell> cells = cellsAbout(grid, eye);
        return std::all_of(cells.begin(), cells.end(), isPlace);
    });
}

/// Where the eyes may move without leaving open space or what is near: cells that hang together with theirs.
void OpenWays::gatherPlace(const OpenGrid& grid, std::span<const glm::dvec3> eyesInWorld) {
    std::vector<GridCell> left;
    const double cells = std::clamp(kPlaceMetres / grid.cellMetres(), kLeastPlace, kMostPlace);
    const int reach = static_cast<int>(cells);
    low_ = {kOpenGridAcross, kOpenGridAcross, kOpenGridAcross}, high_ = {-1, -1, -1};
    for (const glm::dvec3& eye : eyesInWorld)
        for (const GridCell& cell : cellsAbout(grid, eye)) {
            left.push_back(cell);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                low_[axis] = std::clamp(cell[axis] - reach, 0, low_[axis]);
                high_[axis] = std::clamp(cell[axis] + reach, high_[axis], kOpenGridAcross - 1);
            }
        }
    std::array<std::size_t, 3> size{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        size[axis] = static_cast<std::size_t>(high_[axis] - low_[axis] + 1);
    isPlace_.assign(size[0] * size[1] * size[2], 0);
    while (!left.empty()) {
        const GridCell cell = left.back();
        left.pop_back();
        bool isWithin = grid.isOpen(cell);
        std::size_t at = 0;
        for (std::size_t axis = 3; axis-- > 0;) {
            isWithin = isWithin && cell[axis] >= low_[axis] && cell[axis] <= high_[axis];
            at = at * size[axis] + static_cast<std::size_t>(cell[axis] - low_[axis]);
        }
        if (!isWithin || isPlace_[at] != 0) continue;
        isPlace_[at] = 1;
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (const int step : {-1, 1}) {
                left.push_back(cell);
                left.back()[axis] += step;
            }
    }
}

/// The ways of one octant: on along x in the rows as given, along y and z by steps of one.
void OpenWays::sweep(const OpenGrid& grid, bool isMirrored, int stepY, int stepZ, std::vector<Row>& reached) const {
    constexpr int kLast = kOpenGridAcross - 1;
    const auto placeRow = [&](int y, int z) {
        Row row{};
        if (y < low_[1] || y > high_[1] || z < low_[2] || z > high_[2]) return row;
        const int across = high_[0] - low_[0] + 1;
        const std::size_t first =
            (static_cast<std::size_t>(z - low_[2]) * static_cast<std::size_t>(high_[1] - low_[1] + 1) +
             static_cast<std::size_t>(y - low_[1])) *
            static_cast<std::size_t>(across);
        for (int x = 0; x < across; ++x) {
            if (isPlace_[first + static_cast<std::size_t>(x)] == 0) continue;
            const int at = isMirrored ? kLast - (low_[0] + x) : low_[0] + x;
            row[static_cast<std::size_t>(at) / 64] |= std::uint64_t{1} << (at % 64);
        }
        return row;
    };
    // One slice behind the other; a row more than there are, before the first, in which nothing is.
    std::array<Row, kOpenGridAcross + 1> before{}, here{};
    const int beginY = stepY > 0 ? low_[1] : high_[1], beginZ = stepZ > 0 ? low_[2] : high_[2];
    for (int z = beginZ; z >= 0 && z <= kLast; z += stepZ) {
        bool isAnything = false;
        std::size_t i = 1;
        for (int y = beginY; y >= 0 && y <= kLast; y += stepY, ++i) {
            Row from;
            const Row place = placeRow(y, z);
            for (std::size_t w = 0; w < from.size(); ++w)
                from[w] = before[i][w] | before[i - 1][w] | here[i - 1][w];
            from = spread(from);
            for (std::size_t w = 0; w < from.size(); ++w)
                from[w] |= place[w];
            if (isEmpty(from)) {
                here[i] = from;
                continue;
            }
            here[i] = filled(from, isMirrored ? grid.mirroredRow(y, z) : grid.openRow(y, z));
            Row& all = reached[OpenGrid::rowOf(y, z)];
            for (std::size_t w = 0; w < all.size(); ++w)
                all[w] |= here[i][w];
            isAnything = true;
        }
        const bool isPast = stepZ > 0 ? z >= high_[2] : z <= low_[2];
        if (!isAnything && isPast) break;
        std::swap(before, here);
    }
}

/// Both ways along x together; whether a way leads to the cube's rim, and blocks of cells, so that large boxes are
/// asked about quickly.
void OpenWays::summarize() {
    constexpr int kLast = kOpenGridAcross - 1;
    leavesCube_ = false;
    blocks_.assign(std::size_t{kBlocksAcross} * kBlocksAcross, 0);
    for (int z = 0; z < kOpenGridAcross; ++z)
        for (int y = 0; y < kOpenGridAcross; ++y) {
            Row& row = reached_[OpenGrid::rowOf(y, z)];
            if (const Row& back = backwards_[OpenGrid::rowOf(y, z)]; !isEmpty(back)) {
                const Row turned = mirrored(back);
                for (std::size_t w = 0; w < row.size(); ++w)
                    row[w] |= turned[w];
            }
            if (isEmpty(row)) continue;
            leavesCube_ = leavesCube_ || z == 0 || z == kLast || y == 0 || y == kLast || (row.front() & 1) != 0 ||
                          (row.back() >> 63) != 0;
            std::uint64_t& block =
                blocks_[static_cast<std::size_t>(z / kBlock) * kBlocksAcross + static_cast<std::size_t>(y / kBlock)];
            for (std::size_t w = 0; w < row.size(); ++w)
                block |= anyOfFour(row[w]) << (16 * w);
        }
}

bool OpenWays::standAt(const OpenGrid& grid, std::span<const glm::dvec3> eyesInWorld) {
    const auto standsClear = [&](const glm::dvec3& eye) {
        const std::vector<GridCell> cells = cellsAbout(grid, eye);
        return std::all_of(cells.begin(), cells.end(), [&](const GridCell& cell) { return grid.isClear(cell); });
    };
    if (!std::all_of(eyesInWorld.begin(), eyesInWorld.end(), standsClear)) {
        forget();
        return false;
    }
    eyesInWorld_.assign(eyesInWorld.begin(), eyesInWorld.end());
    if (areStillWithin(grid, eyesInWorld)) return false;
    cornerInWorld_ = grid.cornerInWorld(), cellMetres_ = grid.cellMetres();
    gatherPlace(grid, eyesInWorld);
    const auto sweepAll = [&](bool isMirrored, std::vector<Row>& reached) {
        reached.assign(std::size_t{kOpenGridAcross} * kOpenGridAcross, Row{});
        for (const int stepY : {1, -1})
            for (const int stepZ : {1, -1})
                sweep(grid, isMirrored, stepY, stepZ, reached);
    };
    tbb::parallel_invoke([&] { sweepAll(false, reached_); }, [&] { sweepAll(true, backwards_); });
    summarize();
    isKnown_ = true;
    return true;
}

bool OpenWays::mayMeet(const glm::dvec3& least, const glm::dvec3& most, double beside) const {
    if (!isKnown_) return true;
    double farthest = 0;
    for (const glm::dvec3& eye : eyesInWorld_)
        farthest = std::max(farthest, glm::length(glm::max(glm::abs(least - eye), glm::abs(most - eye))));
    const double around = beside * farthest;
    if (!meets(least - around, most + around)) return false;
    // Of a large box no part is as far away as its farthest corner but that one.
    const glm::dvec3 size = most - least;
    const int longest = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    if (around <= cellMetres_ || size[longest] <= kLeastPart * cellMetres_) return true;
    glm::dvec3 lowHalf = most, highHalf = least;
    lowHalf[longest] = highHalf[longest] = 0.5 * (least[longest] + most[longest]);
    return mayMeet(least, lowHalf, beside) || mayMeet(highHalf, most, beside);
}

bool OpenWays::meets(const glm::dvec3& least, const glm::dvec3& most) const {
    const double around = kBesideFace * cellMetres_;
    GridCell low = cellOf((least - around - cornerInWorld_) / cellMetres_),
             high = cellOf((most + around - cornerInWorld_) / cellMetres_);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (leavesCube_ && (low[axis] < 0 || high[axis] >= kOpenGridAcross)) return true;
        low[axis] = std::max(low[axis], 0), high[axis] = std::min(high[axis], kOpenGridAcross - 1);
        if (low[axis] > high[axis]) return false;
    }
    const std::uint64_t asked = bitsFrom(low[0] / kBlock, high[0] / kBlock);
    for (int z = low[2] / kBlock; z <= high[2] / kBlock; ++z)
        for (int y = low[1] / kBlock; y <= high[1] / kBlock; ++y) {
            if ((blocks_[static_cast<std::size_t>(z) * kBlocksAcross + static_cast<std::size_t>(y)] & asked) == 0)
                continue;
            for (int cz = std::max(low[2], z * kBlock); cz <= std::min(high[2], z * kBlock + kBlock - 1); ++cz)
                for (int cy = std::max(low[1], y * kBlock); cy <= std::min(high[1], y * kBlock + kBlock - 1); ++cy)
                    for (int word = low[0] / 64; word <= high[0] / 64; ++word) {
                        const std::uint64_t bits =
                            bitsFrom(std::max(low[0] - 64 * word, 0), std::min(high[0] - 64 * word, 63));
                        if ((reached_[OpenGrid::rowOf(cy, cz)][static_cast<std::size_t>(word)] & bits) != 0)
                            return true;
                    }
        }
    return false;
}

} // namespace scene
