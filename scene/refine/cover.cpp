#include "scene/refine/cover.h"

#include "scene/refine/open_spaces.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr std::uint64_t kAllCells = ~std::uint64_t{0};
constexpr double kCoarseSamples = 12;  ///< the first pass divides no cell below so many samples' spacing
constexpr double kMiddleShare = 0.1;   ///< of a smallest cell's edge, to either side: what decides over all of it
constexpr int kParallelLevels = 3;     ///< deeper, a task would be too small
constexpr int kSampleStep = 4;         ///< every so many samples, across and down, bound the cube
constexpr double kOutlierShare = 5e-4; ///< of an image's samples, at each end of an axis, may lie outside
constexpr int kSampledLevel = 3;       ///< where an estimate carves some nodes and passes over others
constexpr int kSampledNodes = 1 << 6 * kSampledLevel;
constexpr int kEstimateShare = 16;    ///< it carves one in so many
constexpr double kSure = 3;           ///< standard errors that it must be too large by, to be believed
constexpr std::int64_t kOnTheWay = 2; ///< times as many nodes as may stay: later images take few of them away

/// A node that grows. Cells in none of the masks are unseen; children in the order of their bits.
struct Growing {
    std::uint64_t empty = 0, surface = 0, divided = 0;
    std::vector<Growing> children;
};

std::int64_t countNodes(const Growing& node) {
    std::int64_t count = 1;
    for (const Growing& child : node.children)
        count += countNodes(child);
    return count;
}

/// How an image carves: its camera in the tree's axes, and how small its cells become.
struct Carver {
    const OpenSpace& space;
    glm::dmat3 cameraFromWorld; ///< rotation
    glm::dvec3 halfOfUnit{0.0}; ///< half extents, in the camera's axes, of a unit cube along the world's
    bool isCoarse = false;
    double nearestMetres = 0, smallest = 0, atSurface = 0; ///< the last two in samples' spacings
    int shareOf = 1;                                       ///< of the nodes of kSampledLevel one in so many is carved
    std::span<std::int64_t> grownBelow = {}; ///< if not all are: by how many nodes each has grown, by its path

    double spacingAt(const glm::dvec3& pInCamera) const {
        return space.spacingAt(std::max(pInCamera.z, nearestMetres));
    }
};

/// Cells side by side that are decided together: at the finest level, where four to an edge would be finer than asked.
std::uint64_t maskOf(int x, int y, int z, int side) {
    std::uint64_t mask = 0;
    for (int dz = 0; dz < side; ++dz)
        for (int dy = 0; dy < side; ++dy)
            for (int dx = 0; dx < side; ++dx)
                mask |= coverageMask(coverageBit(x + dx, y + dy, z + dz));
    return mask;
}

class Carving {
  public:
    Carving(const Carver& carver) : c_(carver) {}

    /// How many nodes there are more then. centre: of the node, in the camera; path: by the bits of its cells, from
    /// the root down.
    std::int64_t carve(Growing& node, const glm::dvec3& centre, double edge, int level, std::uint64_t path) const {
        const double cell = edge / kCoverageBranching;
        const int side = !c_.isCoarse && 2 * cell <= c_.smallest * c_.spacingAt(centre) && node.divided == 0 ? 2 : 1;
        std::uint64_t toCarve = 0;
        for (int z = 0; z < kCoverageBranching; z += 2)
            for (int y = 0; y < kCoverageBranching; y += 2)
                for (int x = 0; x < kCoverageBranching; x += 2)
                    toCarve |= carveOctant(node, {x, y, z}, side, centre, cell, level);
        std::int64_t grown = divide(node, toCarve & ~node.divided);
        grown += carveChildren(node, toCarve, centre, cell, level, path);
        return grown - collapse(node);
    }

  private:
    /// Eight cells from the first one on, or one cell where they are decided together: those to be carved in parts.
    std::uint64_t carveOctant(Growing& node, const glm::ivec3& first, int side, const glm::dvec3& centre, double cell,
                              int level) const {
        const std::uint64_t octant = maskOf(first.x, first.y, first.z, 2);
        if ((node.empty & octant) == octant) return 0;
        const glm::dvec3 middle = centreOf(centre, cell, first.x, first.y, first.z, 2);
        if (side == 2) return decide(node, octant, middle, cell * side, level, false) ? octant : 0;
        // Two thirds of all cells are hidden or outside the image, most of them with their neighbours.
        const Sight sight = c_.space.look({middle, 2 * cell * c_.halfOfUnit}).sight;
        if (sight == Sight::all) node.surface &= node.empty | ~octant, node.empty |= octant;
        if (sight != Sight::part) return 0;
        std::uint64_t toCarve = 0;
        for (int z = first.z; z < first.z + 2; ++z)
            for (int y = first.y; y < first.y + 2; ++y)
                for (int x = first.x; x < first.x + 2; ++x) {
                    const std::uint64_t mask = coverageMask(coverageBit(x, y, z));
                    if ((node.empty & mask) != 0) continue;
                    if (decide(node, mask, centreOf(centre, cell, x, y, z, 1), cell, level, true)) toCarve |= mask;
                }
        return toCarve;
    }

    glm::dvec3 centreOf(const glm::dvec3& centre, double cell, int x, int y, int z, int side) const {
        const double half = 0.5 * side, middle = 0.5 * kCoverageBranching;
        return centre +
               c_.cameraFromWorld * (cell * glm::dvec3(x + half - middle, y + half - middle, z + half - middle));
    }

    /// What the image knows of cells of one kind; true if only their parts can tell.
    bool decide(Growing& node, std::uint64_t mask, const glm::dvec3& middle, double cell, int level,
                bool mayDivide) const {
        const BoxSight sight = c_.space.look({middle, cell * c_.halfOfUnit});
        if (sight.sight == Sight::none) return false;
        if (sight.sight == Sight::all) {
            node.empty |= mask, node.surface &= ~mask;
            return false; // children of empty cells go when the node collapses
        }
        const double spacing = c_.spacingAt(middle);
        if (c_.isCoarse) return cell > kCoarseSamples * spacing && level + 1 < kMaxCoverageLevels;
        if ((node.divided & mask) != 0) return true;
        const double limit = sight.hasEdge ? c_.smallest : c_.atSurface;
        if (mayDivide && cell > limit * spacing && level + 1 < kMaxCoverageLevels) return (node.surface & mask) == 0;
        // Smallest cells in the open are as their middle is, else every end of seen space would reach a cell too far.
        // Cells at surfaces are surface if any of them is seen: they must not stand out of it as unseen.
        const bool isSmallest = !mayDivide || cell <= c_.smallest * spacing;
        const bool holdsSample = isSmallest && c_.space.holdsSample({middle, cell * c_.halfOfUnit});
        const Sight core = holdsSample ? Sight::part : c_.space.look({middle, glm::dvec3(kMiddleShare * cell)}).sight;
        if (isSmallest && !holdsSample && core == Sight::none) return false;
        if (isSmallest ? holdsSample : core != Sight::all)
            node.surface |= mask;
        else
            node.empty |= mask, node.surface &= ~mask;
        return false;
    }

    static int divide(Growing& node, std::uint64_t cells) {
        if (cells == 0) return 0;
        std::vector<Growing> children(static_cast<std::size_t>(std::popcount(node.divided | cells)));
        for (std::uint64_t left = node.divided; left != 0; left &= left - 1) {
            const int bit = std::countr_zero(left);
            children[childRank(node.divided | cells, bit)] = std::move(node.children[childRank(node.divided, bit)]);
        }
        node.divided |= cells;
        node.children = std::move(children);
        return std::popcount(cells);
    }

    /// By chance, as it were: the finalizer of SplitMix64 (Steele et al. 2014).
    bool isSampled(std::uint64_t path) const {
        std::uint64_t z = path + 0x9e3779b97f4a7c15;
        z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9;
        z = (z ^ z >> 27) * 0x94d049bb133111eb;
        return (z ^ z >> 31) % static_cast<std::uint64_t>(c_.shareOf) == 0;
    }

    std::int64_t carveChildren(Growing& node, std::uint64_t cells, const glm::dvec3& centre, double cell, int level,
                               std::uint64_t path) const {
        std::vector<int> bits;
        for (; cells != 0; cells &= cells - 1)
            bits.push_back(std::countr_zero(cells));
        const bool isOfSample = c_.shareOf > 1 && level + 1 == kSampledLevel;
        const auto carveOne = [&](std::size_t i) -> std::int64_t {
            const int bit = bits[i];
            const std::uint64_t pathTo = path << 6 | static_cast<std::uint64_t>(bit);
            if (isOfSample && !isSampled(pathTo)) return 0;
            const std::int64_t grown =
                carve(node.children[childRank(node.divided, bit)],
                      centreOf(centre, cell, bit % 4, bit / 4 % 4, bit / 16, 1), cell, level + 1, pathTo);
            if (!isOfSample) return grown;
            c_.grownBelow[pathTo] += grown;
            return 0;
        };
        if (level < kParallelLevels) {
            std::atomic<std::int64_t> grown = 0;
            tbb::parallel_for(std::size_t{0}, bits.size(), [&](std::size_t i) { grown += carveOne(i); });
            return grown;
        }
        std::int64_t grown = 0;
        for (std::size_t i = 0; i < bits.size(); ++i)
            grown += carveOne(i);
        return grown;
    }

    /// How many nodes are gone.
    static std::int64_t collapse(Growing& node) {
        std::uint64_t gone = 0;
        std::int64_t count = 0;
        for (std::uint64_t left = node.divided; left != 0; left &= left - 1) {
            const int bit = std::countr_zero(left);
            const std::uint64_t mask = coverageMask(bit);
            const Growing& child = node.children[childRank(node.divided, bit)];
            const bool isUnseen = (child.empty | child.surface | child.divided) == 0;
            if ((node.empty & mask) == 0 && child.empty != kAllCells && child.surface != kAllCells && !isUnseen)
                continue;
            if (child.surface == kAllCells && (node.empty & mask) == 0) node.surface |= mask;
            if (child.empty == kAllCells) node.empty |= mask;
            gone |= mask;
            count += countNodes(child);
        }
        if (gone == 0) return 0;
        std::vector<Growing> kept;
        const std::uint64_t stay = node.divided & ~gone;
        kept.reserve(static_cast<std::size_t>(std::popcount(stay)));
        for (std::uint64_t left = stay; left != 0; left &= left - 1)
            kept.push_back(std::move(node.children[childRank(node.divided, std::countr_zero(left))]));
        node.divided = stay;
        node.children = std::move(kept);
        return count;
    }

    const Carver& c_;
};

struct Box {
    glm::dvec3 least{std::numeric_limits<double>::infinity()}, most{-std::numeric_limits<double>::infinity()};
    void include(const glm::dvec3& p) {
        for (int axis = 0; axis < 3; ++axis)
            least[axis] = std::min(least[axis], p[axis]), most[axis] = std::max(most[axis], p[axis]);
    }
    bool isEmpty() const { return !(least.x <= most.x); }
};

/// Of the camera and most of what it saw; a few samples that fly far off do not count.
Box boxOf(const DepthImage& image) {
    std::array<std::vector<double>, 3> places;
    for (int y = 0; y < image.camera.height; y += kSampleStep)
        for (int x = 0; x < image.camera.width; x += kSampleStep) {
            if (!isDrawable(image.flags(x, y)) || image.disparity(x, y) <= 0) continue;
            const glm::dvec3 p =
                image.worldFromCamera * (rayThrough(image.camera, x + 0.5, y + 0.5) / double{image.disparity(x, y)});
            for (std::size_t axis = 0; axis < 3; ++axis)
                places[axis].push_back(p[static_cast<int>(axis)]);
        }
    Box box;
    box.include(image.worldFromCamera.translation);
    if (places[0].empty()) return box;
    glm::dvec3 least(0), most(0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        std::vector<double>& values = places[axis];
        const auto outliers = static_cast<std::ptrdiff_t>(kOutlierShare * static_cast<double>(values.size()));
        std::nth_element(values.begin(), values.begin() + outliers, values.end());
        least[static_cast<int>(axis)] = values[static_cast<std::size_t>(outliers)];
        std::nth_element(values.begin(), values.end() - 1 - outliers, values.end());
        most[static_cast<int>(axis)] = *(values.end() - 1 - outliers);
    }
    box.include(least), box.include(most);
    return box;
}

/// Metres along the axis to the nearest sample, no more than its distance; infinite if there is none.
double nearestDepthOf(const DepthImage& image) {
    float most = 0;
    for (int y = 0; y < image.camera.height; ++y)
        for (int x = 0; x < image.camera.width; ++x)
            if (isDrawable(image.flags(x, y))) most = std::max(most, image.disparity(x, y));
    return 1 / double{most};
}

/// Breadth first: children stand side by side, in the order of their parents.
std::vector<CoverageNode> flatten(const Growing& root) {
    std::vector<CoverageNode> nodes(1);
    std::vector<const Growing*> growing{&root};
    for (std::size_t i = 0; i < growing.size(); ++i) {
        const Growing& from = *growing[i];
        nodes[i] = {~(from.empty | from.surface | from.divided), from.surface, from.divided,
                    from.divided != 0 ? static_cast<std::uint32_t>(growing.size()) : 0, 0};
        for (const Growing& child : from.children)
            growing.push_back(&child);
        nodes.resize(growing.size());
    }
    return nodes;
}

struct Region {
    glm::dvec3 centre{0.0};
    double edge = 1;
};

/// A tree while it grows.
struct Sapling {
    Growing root;
    std::int64_t nodes = 1;
    bool isCoarse = false;
    double cellsPerSample = 1;
    std::int64_t most = std::numeric_limits<std::int64_t>::max(); ///< nodes; with more it grows no further
    std::vector<std::int64_t> sampled; ///< of an estimate: as grownBelow in Carver, and not counted in nodes
    bool isGivenUp() const { return std::accumulate(sampled.begin(), sampled.end(), nodes) > most; }

    /// Nodes that there would be at least, were all carved: by what the sampled ones have grown and differ by.
    double leastNodes() const {
        double sum = 0, squares = 0;
        for (const std::int64_t grown : sampled) {
            const auto g = static_cast<double>(grown);
            sum += g, squares += g * g;
        }
        return static_cast<double>(nodes) + kEstimateShare * sum -
               kSure * std::sqrt(kEstimateShare * (kEstimateShare - 1) * squares);
    }
};

class Growth {
  public:
    Growth(ImageStore& images, const Region& region, std::span<const double> bodies, const CoverOptions& options)
        : spaces_(images, options.tolerance, bodies), region_(region), options_(options) {}

    /// All images carve all trees, until none is left that is not given up. afterImage is told how many images did.
    template <class AfterImage>
    void carve(std::span<Sapling> trees, const AfterImage& afterImage) {
        std::size_t count = 0;
        spaces_.forEach([&](const DepthImage& image, const OpenSpace& space) {
            carveBy(image, space, trees);
            if (std::ranges::all_of(trees, &Sapling::isGivenUp)) return false;
            afterImage(++count);
            return true;
        });
    }

  private:
    void carveBy(const DepthImage& image, const OpenSpace& space, std::span<Sapling> trees) {
        Carver carver{space, glm::transpose(image.worldFromCamera.rotation)};
        for (int row = 0; row < 3; ++row)
            carver.halfOfUnit[row] =
                0.5 * (std::abs(carver.cameraFromWorld[0][row]) + std::abs(carver.cameraFromWorld[1][row]) +
                       std::abs(carver.cameraFromWorld[2][row]));
        carver.nearestMetres = options_.nearestMetres;
        const glm::dvec3 centre = carver.cameraFromWorld * (region_.centre - image.worldFromCamera.translation);
        for (Sapling& tree : trees) {
            if (tree.isGivenUp()) continue;
            carver.isCoarse = tree.isCoarse;
            carver.smallest = 1 / tree.cellsPerSample;
            carver.atSurface = std::max(options_.surfaceSamples, carver.smallest);
            carver.shareOf = tree.sampled.empty() ? 1 : kEstimateShare;
            carver.grownBelow = tree.sampled;
            tree.nodes += Carving(carver).carve(tree.root, centre, region_.edge, 0, 0);
            if (tree.isGivenUp()) tree.root = {}; // nobody asks for it any more
        }
    }

    OpenSpaces spaces_;
    Region region_;
    const CoverOptions& options_;
};

/// Grows the finest tree of no more nodes than may be; cellsPerSample is that of it.
class FinestThatFits {
  public:
    FinestThatFits(Growth growth, std::size_t images, const CoverOptions& options, const std::function<void()>& advance)
        : growth_(std::move(growth)), images_(images),
          most_(static_cast<std::int64_t>(std::min<std::size_t>(options.maxNodes, kMostNodes))), advance_(advance) {
        coarse_.isCoarse = true;
        growth_.carve({&coarse_, 1}, [&](std::size_t count) { advanceTo(count); });
        coarse_.isCoarse = false;
    }

    Growing grow(double& cellsPerSample) {
        for (std::size_t i = 0; cellsPerSample > kCoarsest; cellsPerSample /= 2, ++i) {
            if (i % kEstimatedTogether == 0) estimateFrom(cellsPerSample);
            if (isTooLarge_[i % kEstimatedTogether]) continue;
            Sapling tree = whole(cellsPerSample, kOnTheWay * most_);
            if (tree.nodes <= most_) return std::move(tree.root);
        }
        Sapling coarsest = whole(cellsPerSample, kMostNodes);
        assert(!coarsest.isGivenUp());
        return std::move(coarsest.root);
    }

  private:
    static constexpr double kCoarsest = 1e-3; ///< cells per sample: that is taken however large it is
    static constexpr std::size_t kEstimatedTogether = 4;
    static constexpr std::int64_t kMostNodes = std::numeric_limits<std::uint32_t>::max(); ///< they are counted so

    /// Of this fineness, of half of it, and so on.
    void estimateFrom(double cellsPerSample) {
        std::vector<Sapling> trees(kEstimatedTogether, coarse_);
        for (Sapling& tree : trees) {
            tree.cellsPerSample = cellsPerSample;
            tree.sampled.resize(kSampledNodes);
            tree.most = kOnTheWay * most_;
            cellsPerSample /= 2;
        }
        growth_.carve(trees, [&](std::size_t count) { advanceTo(images_ + count); });
        for (std::size_t i = 0; i < kEstimatedTogether; ++i)
            isTooLarge_[i] = trees[i].isGivenUp() || trees[i].leastNodes() > static_cast<double>(most_);
    }

    Sapling whole(double cellsPerSample, std::int64_t most) {
        Sapling tree = coarse_;
        tree.cellsPerSample = cellsPerSample, tree.most = most;
        growth_.carve({&tree, 1}, [&](std::size_t count) { advanceTo(2 * images_ + count); });
        return tree;
    }

    /// Each step is told once, though a tree that was given up may have come further than the next, and an estimate
    /// may end early.
    void advanceTo(std::size_t steps) {
        for (; advanced_ < steps; ++advanced_)
            if (advance_) advance_();
    }

    Growth growth_;
    std::size_t images_;
    std::int64_t most_;
    const std::function<void()>& advance_;
    Sapling coarse_;
    std::array<bool, kEstimatedTogether> isTooLarge_{};
    std::size_t advanced_ = 0;
};

} // namespace

std::uint64_t bytesToCover(const CoverOptions& options) {
    // The coarse one beside the finest that is tried.
    return sizeof(Growing) * (kOnTheWay + 1) * options.maxNodes;
}

Coverage cover(ImageStore& images, const CoverOptions& options, CoverFigures& figures,
               const std::function<void()>& advance) {
    std::vector<Box> boxes(images.size());
    std::vector<double> bodies(images.size());
    visitEach(images, 2, [&](std::size_t i) { // and places of some samples
        const ImageStore::Lease image = images.borrow(i);
        boxes[i] = boxOf(*image);
        bodies[i] = std::min(options.bodyMetres, nearestDepthOf(*image));
    });
    Box all;
    for (const Box& box : boxes)
        if (!box.isEmpty()) all.include(box.least), all.include(box.most);
    Region region;
    if (!all.isEmpty()) {
        const glm::dvec3 size = all.most - all.least;
        region.centre = 0.5 * (all.least + all.most);
        region.edge = std::max(1.1 * std::max({size.x, size.y, size.z}), 1e-3);
    }
    figures.cellsPerSample = options.cellsPerSample;
    const Growing root = FinestThatFits(Growth(images, region, bodies, options), images.size(), options, advance)
                             .grow(figures.cellsPerSample);
    Coverage coverage{region.centre - glm::dvec3(region.edge / 2), region.edge, flatten(root)};
    figures.nodes = coverage.nodes.size();
    figures.finestMetres = finestCellOf(coverage);
    const std::array<double, 3> volumes = volumesOf(coverage, all.least, all.most);
    figures.unseenCubicMetres = volumes[static_cast<std::size_t>(Observed::unseen)];
    figures.surfaceCubicMetres = volumes[static_cast<std::size_t>(Observed::surface)];
    figures.emptyCubicMetres = volumes[static_cast<std::size_t>(Observed::empty)];
    return coverage;
}

} // namespace scene
