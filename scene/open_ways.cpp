#include "scene/open_ways.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <tbb/parallel_invoke.h>

namespace scene {

namespace {

/// About an eye, in which it may move before all is found anew: metres, as far as that is so many cells.
constexpr double kPlaceMetres = 0.2, kLeastPlace = 2, kMostPlace = 8;
constexpr double kBesideFace = 0.01; ///< cells: whoever is so near to a face counts as on both sides of it
constexpr double kLeastPart = 8;     ///< cells: smaller parts of a box are not asked about one by one
constexpr int kLast = kOpenCellsAcross - 1;
constexpr int kFinerAcross = kOpenCellsAcross / kCoverageBranching; ///< cells of a layer that the next one takes up

bool isEmpty(const CellRow& row) {
    std::uint64_t any = 0;
    for (const std::uint64_t word : row)
        any |= word;
    return any == 0;
}

CellRow operator|(const CellRow& a, const CellRow& b) {
    return {a[0] | b[0], a[1] | b[1], a[2] | b[2], a[3] | b[3]};
}

/// Each cell, and the one after it.
CellRow spread(const CellRow& row) {
    CellRow wider;
    std::uint64_t carried = 0;
    for (std::size_t i = 0; i < row.size(); ++i) {
        wider[i] = row[i] | row[i] << 1 | carried;
        carried = row[i] >> 63;
    }
    return wider;
}

/// From cells of the row along x as far as it is open. An addition carries through what is open and stops at what is
/// not.
CellRow filled(const CellRow& from, const CellRow& open) {
    CellRow all;
    std::uint64_t carry = 0;
    for (std::size_t i = 0; i < from.size(); ++i) {
        const std::uint64_t start = from[i] & open[i], half = open[i] + start, sum = half + carry;
        carry = static_cast<std::uint64_t>(half < start) | static_cast<std::uint64_t>(sum < half);
        all[i] = ((sum ^ open[i]) | start) & open[i];
    }
    return all;
}

/// Sixty-four cells of a row, from the first on.
CellRow cellsFrom(int first, std::uint64_t bits) {
    CellRow row{};
    const auto word = static_cast<std::size_t>(first) / 64;
    const int shift = first % 64;
    row[word] = bits << shift;
    if (shift > 0) row[word + 1] = bits >> (64 - shift);
    return row;
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

GridCell cellOf(const glm::dvec3& inCells) {
    // What is too far away for an int is outside all the same.
    const glm::dvec3 at = glm::clamp(glm::floor(inCells), -1e6, 1e6);
    return {static_cast<int>(at.x), static_cast<int>(at.y), static_cast<int>(at.z)};
}

/// Right beside a place, on all sides.
std::array<glm::dvec3, 8> beside(const glm::dvec3& p, double by) {
    std::array<glm::dvec3, 8> corners;
    for (std::size_t i = 0; i < corners.size(); ++i)
        corners[i] = p + by * glm::dvec3((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
    return corners;
}

/// The cells that an eye is in or right beside.
std::vector<GridCell> cellsAbout(const OpenCells& layer, const glm::dvec3& eyeInWorld) {
    std::vector<GridCell> cells;
    for (const glm::dvec3& corner : beside(layer.inCells(eyeInWorld), kBesideFace)) {
        const GridCell cell = cellOf(corner);
        if (std::find(cells.begin(), cells.end(), cell) == cells.end()) cells.push_back(cell);
    }
    return cells;
}

/// Whether all eyes are far from the rim of a layer, or within it at least.
bool holds(const OpenCells& layer, std::span<const glm::dvec3> eyesInWorld, int margin) {
    return std::all_of(eyesInWorld.begin(), eyesInWorld.end(), [&](const glm::dvec3& eye) {
        for (const GridCell& cell : cellsAbout(layer, eye))
            if (std::any_of(cell.begin(), cell.end(), [&](int at) { return at < margin || at > kLast - margin; }))
                return false;
        return true;
    });
}

} // namespace

void OpenWays::Reached::clear() {
    rows.resize(std::size_t{kOpenCellsAcross} * kOpenCellsAcross);
    for (int z = lowZ; z <= highZ; ++z)
        std::fill_n(rows.begin() + static_cast<std::ptrdiff_t>(OpenCells::rowOf(lowY, z)), highY - lowY + 1, CellRow{});
    lowY = lowZ = kOpenCellsAcross, highY = highZ = -1;
    blocks.fill(0);
}

void OpenWays::Reached::add(int y, int z, const CellRow& cells) {
    CellRow& all = rows[OpenCells::rowOf(y, z)];
    all = all | cells;
    lowY = std::min(lowY, y), highY = std::max(highY, y), lowZ = std::min(lowZ, z), highZ = std::max(highZ, z);
}

bool OpenWays::standClear(const OpenGrid& grid, std::span<const glm::dvec3> eyesInWorld) {
    return std::all_of(eyesInWorld.begin(), eyesInWorld.end(), [&](const glm::dvec3& eye) {
        const std::array<glm::dvec3, 8> corners = beside(eye, kBesideFace * grid.finestMetres());
        return std::all_of(corners.begin(), corners.end(), [&](const glm::dvec3& p) { return grid.isClear(p); });
    });
}

void OpenWays::knowNothing() {
    isKnown_ = false;
    isPlace_.clear();
}

void OpenWays::forget() {
    knowNothing();
    layers_.clear();
    used_ = 0;
}

/// Lays the finer layers about the eyes. Returns whether they are others than before.
bool OpenWays::centre(const OpenGrid& grid) {
    const std::size_t before = used_;
    bool isAnother = false;
    if (layers_.empty()) {
        layers_.push_back(std::make_unique<Layer>());
        layers_.front()->cells = &grid.whole();
    }
    assert(layers_.front()->cells == &grid.whole());
    for (used_ = 1; used_ < static_cast<std::size_t>(grid.layers()); ++used_) {
        const int number = static_cast<int>(used_);
        const bool isThere = used_ < layers_.size();
        if (!isThere) layers_.push_back(std::make_unique<Layer>());
        Layer& layer = *layers_[used_];
        if (!isThere || !holds(*layer.cells, eyesInWorld_, kOpenCellsAcross / 4)) {
            const GridCell first = grid.firstAbout(eyesInWorld_.front(), number);
            if (!isThere || layer.cells->first() != first) {
                layer.own.emplace(grid.layer(number, first));
                layer.cells = &*layer.own;
                isAnother = true;
            }
        }
        if (!holds(*layer.cells, eyesInWorld_, 0)) break; // eyes stand too far apart
    }
    for (std::size_t i = 0; i + 1 < used_; ++i) {
        Part& finer = layers_[i]->finer;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            finer.low[axis] =
                layers_[i + 1]->cells->first()[axis] / kCoverageBranching - layers_[i]->cells->first()[axis];
            finer.high[axis] = finer.low[axis] + kFinerAcross - 1;
        }
    }
    return isAnother || used_ != before;
}

bool OpenWays::areStillWithin() const {
    const auto isPlace = [&](const GridCell& cell) {
        std::size_t at = 0;
        for (std::size_t axis = 3; axis-- > 0;) {
            if (cell[axis] < place_.low[axis] || cell[axis] > place_.high[axis]) return false;
            at = at * static_cast<std::size_t>(place_.high[axis] - place_.low[axis] + 1) +
                 static_cast<std::size_t>(cell[axis] - place_.low[axis]);
        }
        return isPlace_[at] != 0;
    };
    return !isPlace_.empty() && std::all_of(eyesInWorld_.begin(), eyesInWorld_.end(), [&](const glm::dvec3& eye) {
        const std::vector<GridCell> cells = cellsAbout(*layers_[used_ - 1]->cells, eye);
        return std::all_of(cells.begin(), cells.end(), isPlace);
    });
}

/// Where the eyes may move without leaving open space or what is near: cells that hang together with theirs.
void OpenWays::gatherPlace() {
    const OpenCells& layer = *layers_[used_ - 1]->cells;
    std::vector<GridCell> left;
    const double cells = std::clamp(kPlaceMetres / layer.cellMetres(), kLeastPlace, kMostPlace);
    const int reach = static_cast<int>(cells);
    GridCell &low = place_.low, &high = place_.high;
    low = {kOpenCellsAcross, kOpenCellsAcross, kOpenCellsAcross}, high = {-1, -1, -1};
    for (const glm::dvec3& eye : eyesInWorld_)
        for (const GridCell& cell : cellsAbout(layer, eye)) {
            left.push_back(cell);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                low[axis] = std::clamp(cell[axis] - reach, 0, low[axis]);
                high[axis] = std::clamp(cell[axis] + reach, high[axis], kLast);
            }
        }
    std::array<std::size_t, 3> size{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        size[axis] = static_cast<std::size_t>(high[axis] - low[axis] + 1);
    isPlace_.assign(size[0] * size[1] * size[2], 0);
    while (!left.empty()) {
        const GridCell cell = left.back();
        left.pop_back();
        bool isWithin = layer.isOpen(cell);
        std::size_t at = 0;
        for (std::size_t axis = 3; axis-- > 0;) {
            isWithin = isWithin && cell[axis] >= low[axis] && cell[axis] <= high[axis];
            at = at * size[axis] + static_cast<std::size_t>(cell[axis] - low[axis]);
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

CellRow OpenWays::placeRow(int y, int z, bool isMirrored) const {
    CellRow row{};
    const auto& [low, high] = place_;
    const auto across = static_cast<std::size_t>(high[0] - low[0] + 1),
               down = static_cast<std::size_t>(high[1] - low[1] + 1);
    const std::size_t first =
        (static_cast<std::size_t>(z - low[2]) * down + static_cast<std::size_t>(y - low[1])) * across;
    for (int x = low[0]; x <= high[0]; ++x) {
        if (isPlace_[first + static_cast<std::size_t>(x - low[0])] == 0) continue;
        const int at = isMirrored ? kLast - x : x;
        row[static_cast<std::size_t>(at) / 64] |= std::uint64_t{1} << (at % 64);
    }
    return row;
}

/// On along x in the rows as given, along y and z by steps of one, from where the eyes stand or from what the finer
/// layer found; there its own cells say nothing. found: blocks of what was reached.
void OpenWays::sweep(Layer& layer, const Octant& octant, const Blocks* finer, Blocks& found) const {
    const Part& start = finer != nullptr ? layer.finer : place_;
    const bool isMirrored = octant.isMirrored;
    const int firstX = isMirrored ? kLast - layer.finer.high[0] : layer.finer.low[0];
    const CellRow allOfFiner = finer != nullptr ? cellsFrom(firstX, ~std::uint64_t{0}) : CellRow{};
    const auto startOf = [&](int y, int z) {
        if (finer == nullptr) return placeRow(y, z, isMirrored);
        return cellsFrom(firstX, (*finer)[static_cast<std::size_t>(z - start.low[2]) * kBlocksAcross +
                                          static_cast<std::size_t>(y - start.low[1])]);
    };
    Reached& reached = isMirrored ? layer.against : layer.along;
    // One slice behind the other; a row more than there are, before the first, in which nothing is. Rows behind the
    // end of a slice are empty.
    std::array<CellRow, kOpenCellsAcross + 1> before{}, here{};
    std::size_t endBefore = 1, endHere = 1;
    const int rowsOfStart = start.high[1] - start.low[1] + 1;
    const int beginY = octant.stepY > 0 ? start.low[1] : start.high[1],
              beginZ = octant.stepZ > 0 ? start.low[2] : start.high[2];
    for (int z = beginZ; z >= 0 && z <= kLast; z += octant.stepZ) {
        const bool isAtStart = z >= start.low[2] && z <= start.high[2];
        const std::size_t least = isAtStart ? static_cast<std::size_t>(rowsOfStart) + 1 : 1;
        std::size_t i = 1, end = 1;
        for (int y = beginY; y >= 0 && y <= kLast && i <= std::max({least, endBefore, end}); y += octant.stepY, ++i) {
            const bool isStart = isAtStart && y >= start.low[1] && y <= start.high[1];
            CellRow from = spread(before[i] | before[i - 1] | here[i - 1]), there{};
            if (isStart) from = from | (there = startOf(y, z));
            here[i] = CellRow{};
            if (isEmpty(from)) continue;
            CellRow open = isMirrored ? layer.cells->mirroredRow(y, z) : layer.cells->openRow(y, z);
            if (isStart && finer != nullptr)
                for (std::size_t w = 0; w < open.size(); ++w)
                    open[w] = (open[w] & ~allOfFiner[w]) | there[w];
            here[i] = filled(from, open);
            if (isEmpty(here[i])) continue;
            end = i + 1;
            reached.add(y, z, here[i]);
            std::uint64_t& block =
                found[static_cast<std::size_t>(z / kBlock) * kBlocksAcross + static_cast<std::size_t>(y / kBlock)];
            for (std::size_t w = 0; w < open.size(); ++w)
                block |= anyOfFour(here[i][w]) << (16 * w);
        }
        for (; i < endHere; ++i)
            here[i] = CellRow{};
        const bool isPast = octant.stepZ > 0 ? z >= start.high[2] : z <= start.low[2];
        if (end == 1 && isPast) break;
        std::swap(before, here);
        endHere = endBefore, endBefore = end;
    }
}

/// The ways of one octant: in the finest cells, and on in wider ones.
void OpenWays::findWays(const Octant& octant) {
    Blocks finer, found;
    for (std::size_t i = used_; i-- > 0;) {
        found.fill(0);
        Layer& layer = *layers_[i];
        sweep(layer, octant, i + 1 < used_ ? &finer : nullptr, found);
        Blocks& all = (octant.isMirrored ? layer.against : layer.along).blocks;
        std::transform(all.begin(), all.end(), found.begin(), all.begin(), std::bit_or<>());
        finer = found;
    }
}

/// Both ways along x together, but for what a finer layer knows better; and whether a way leads to the cube's rim.
void OpenWays::summarize(std::size_t number) {
    Layer& layer = *layers_[number];
    const bool isFinest = number + 1 == used_, isWhole = number == 0;
    const Part& finer = layer.finer;
    const CellRow ofFiner = isFinest ? CellRow{} : cellsFrom(finer.low[0], ~std::uint64_t{0});
    Reached &all = layer.along, &against = layer.against;
    for (int z = against.lowZ; z <= against.highZ; ++z)
        for (int y = against.lowY; y <= against.highY; ++y)
            if (const CellRow& row = against.rows[OpenCells::rowOf(y, z)]; !isEmpty(row)) all.add(y, z, mirrored(row));
    for (int z = all.lowZ; z <= all.highZ; ++z)
        for (int y = all.lowY; y <= all.highY; ++y) {
            CellRow& row = all.rows[OpenCells::rowOf(y, z)];
            if (isEmpty(row)) continue;
            if (isWhole)
                leavesCube_ = leavesCube_ || z == 0 || z == kLast || y == 0 || y == kLast || (row.front() & 1) != 0 ||
                              (row.back() >> 63) != 0;
            if (isFinest || y < finer.low[1] || y > finer.high[1] || z < finer.low[2] || z > finer.high[2]) continue;
            for (std::size_t w = 0; w < row.size(); ++w)
                row[w] &= ~ofFiner[w];
        }
    const int first = finer.low[0] / kBlock, last = finer.high[0] / kBlock;
    for (int z = 0; z < kBlocksAcross; ++z)
        for (int y = 0; y < kBlocksAcross; ++y) {
            const auto i = static_cast<std::size_t>(z) * kBlocksAcross + static_cast<std::size_t>(y);
            all.blocks[i] |= mirrored(against.blocks[i]);
            if (isFinest || y < finer.low[1] / kBlock || y > finer.high[1] / kBlock || z < finer.low[2] / kBlock ||
                z > finer.high[2] / kBlock)
                continue;
            all.blocks[i] &= ~bitsFrom(first, last);
        }
}

bool OpenWays::standAt(const OpenGrid& grid, std::span<const glm::dvec3> eyesInWorld) {
    if (!standClear(grid, eyesInWorld)) {
        knowNothing();
        return false;
    }
    eyesInWorld_.assign(eyesInWorld.begin(), eyesInWorld.end());
    if (!centre(grid) && areStillWithin()) return false;
    gatherPlace();
    for (const std::unique_ptr<Layer>& layer : std::span(layers_).first(used_)) {
        layer->along.clear();
        layer->against.clear();
    }
    const auto findAll = [&](bool isMirrored) {
        for (const int stepY : {1, -1})
            for (const int stepZ : {1, -1})
                findWays({isMirrored, stepY, stepZ});
    };
    tbb::parallel_invoke([&] { findAll(false); }, [&] { findAll(true); });
    leavesCube_ = false;
    for (std::size_t i = 0; i < used_; ++i)
        summarize(i);
    isKnown_ = true;
    return true;
}

/// Of the finest layer that the box is in.
double OpenWays::cellMetresAbout(const glm::dvec3& least, const glm::dvec3& most) const {
    const auto isIn = [&](const OpenCells& cells) {
        const glm::dvec3 low = cells.inCells(least), high = cells.inCells(most);
        return glm::all(glm::greaterThanEqual(low, glm::dvec3(0))) &&
               glm::all(glm::lessThanEqual(high, glm::dvec3(kOpenCellsAcross)));
    };
    std::size_t i = used_ - 1;
    while (i > 0 && !isIn(*layers_[i]->cells))
        --i;
    return layers_[i]->cells->cellMetres();
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
    const double cellMetres = cellMetresAbout(least - around, most + around);
    if (around <= cellMetres || size[longest] <= kLeastPart * cellMetres) return true;
    glm::dvec3 lowHalf = most, highHalf = least;
    lowHalf[longest] = highHalf[longest] = 0.5 * (least[longest] + most[longest]);
    return mayMeet(least, lowHalf, beside) || mayMeet(highHalf, most, beside);
}

bool OpenWays::meets(const glm::dvec3& least, const glm::dvec3& most) const {
    return std::any_of(layers_.begin(), layers_.begin() + static_cast<std::ptrdiff_t>(used_),
                       [&](const std::unique_ptr<Layer>& layer) { return meets(*layer, least, most); });
}

bool OpenWays::meets(const Layer& layer, const glm::dvec3& least, const glm::dvec3& most) const {
    GridCell low = cellOf(layer.cells->inCells(least) - kBesideFace),
             high = cellOf(layer.cells->inCells(most) + kBesideFace);
    const bool leavesCube = leavesCube_ && &layer == layers_.front().get();
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (leavesCube && (low[axis] < 0 || high[axis] > kLast)) return true;
        low[axis] = std::max(low[axis], 0), high[axis] = std::min(high[axis], kLast);
        if (low[axis] > high[axis]) return false;
    }
    const std::uint64_t asked = bitsFrom(low[0] / kBlock, high[0] / kBlock);
    for (int z = low[2] / kBlock; z <= high[2] / kBlock; ++z)
        for (int y = low[1] / kBlock; y <= high[1] / kBlock; ++y) {
            if ((layer.along.blocks[static_cast<std::size_t>(z) * kBlocksAcross + static_cast<std::size_t>(y)] &
                 asked) == 0)
                continue;
            for (int cz = std::max(low[2], z * kBlock); cz <= std::min(high[2], z * kBlock + kBlock - 1); ++cz)
                for (int cy = std::max(low[1], y * kBlock); cy <= std::min(high[1], y * kBlock + kBlock - 1); ++cy)
                    for (int word = low[0] / 64; word <= high[0] / 64; ++word) {
                        const std::uint64_t bits =
                            bitsFrom(std::max(low[0] - 64 * word, 0), std::min(high[0] - 64 * word, 63));
                        if ((layer.along.rows[OpenCells::rowOf(cy, cz)][static_cast<std::size_t>(word)] & bits) != 0)
                            return true;
                    }
        }
    return false;
}

} // namespace scene
