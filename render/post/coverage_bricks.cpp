#include "render/post/coverage_bricks.h"

#include "render/shaders/shared/unseen.h"

#include <bit>
#include <limits>
#include <utility>

namespace render {

namespace {

constexpr int kEdge = scene::kCoverageBranching;

// A brick with four voxels more on each side, all that its rings tell apart: rows of bits along x, y first, then z.
constexpr int kAcross = 3 * kEdge;
using Rows = std::array<std::uint16_t, std::size_t{kAcross} * kAcross>;
static_assert(kMostBrickRings == kEdge + 1);

/// What is within one of what is set. At the rim that is too little.
Rows widened(const Rows& rows) {
    const auto orBeside = [](const Rows& from, std::size_t step) {
        Rows all = from;
        for (std::size_t i = step; i < from.size(); ++i)
            all[i] |= from[i - step];
        for (std::size_t i = step; i < from.size(); ++i)
            all[i - step] |= from[i];
        return all;
    };
    Rows along;
    for (std::size_t i = 0; i < rows.size(); ++i)
        along[i] = static_cast<std::uint16_t>(rows[i] | rows[i] << 1 | rows[i] >> 1);
    // The last row of a slice and the first of the next are at the rim.
    return orBeside(orBeside(along, 1), kAcross);
}

/// The brick's own voxels, by bit.
std::uint64_t ownOf(const Rows& rows) {
    std::uint64_t own = 0;
    for (int z = 0; z < kEdge; ++z)
        for (int y = 0; y < kEdge; ++y) {
            const std::uint64_t row = rows[static_cast<std::size_t>((z + kEdge) * kAcross + y + kEdge)];
            own |= (row >> kEdge & 15) << kEdge * (y + kEdge * z);
        }
    return own;
}

/// Adds a brick's mask, of one so many to the side.
void place(Rows& rows, std::uint64_t mask, int x, int y, int z) {
    for (int k = 0; k < kEdge; ++k)
        for (int j = 0; j < kEdge; ++j) {
            const std::uint64_t row = mask >> kEdge * (j + kEdge * k) & 15;
            const int at = ((z + 1) * kEdge + k) * kAcross + (y + 1) * kEdge + j;
            rows[static_cast<std::size_t>(at)] |= static_cast<std::uint16_t>(row << (x + 1) * kEdge);
        }
}

/// Voxels whose two by two by two, of a brick's eight, are all open.
std::uint64_t openPairs(std::uint64_t closed) {
    const std::uint64_t alongX = closed | (closed >> 1 & 0x5555555555555555) | (closed << 1 & 0xaaaaaaaaaaaaaaaa);
    const std::uint64_t alongY = alongX | (alongX >> 4 & 0x0f0f0f0f0f0f0f0f) | (alongX << 4 & 0xf0f0f0f0f0f0f0f0);
    return ~(alongY | (alongY >> 16 & 0x0000ffff0000ffff) | (alongY << 16 & 0xffff0000ffff0000));
}

template <class Visit>
void forBeside(const Visit& visit) {
    for (int z = -1; z <= 1; ++z)
        for (int y = -1; y <= 1; ++y)
            for (int x = -1; x <= 1; ++x)
                visit(x, y, z);
}

} // namespace

UnseenTree::UnseenTree(const scene::Coverage& coverage) : nodes_(&coverage.nodes), divided_(coverage.nodes.size()) {
    for (std::size_t i = divided_.size(); i-- > 0;) // children come after their parents
        for (std::uint64_t left = nodes()[i].children; left != 0; left &= left - 1) {
            const int bit = std::countr_zero(left);
            if (hasUnseen(child(i, bit))) divided_[i] |= scene::coverageMask(bit);
        }
}

BrickOrder orderBricks(const UnseenTree& tree, std::vector<std::uint32_t> nodesOfGrid) {
    BrickOrder order{std::move(nodesOfGrid), {}};
    for (std::size_t i = 0; i < order.nodes.size(); ++i) {
        order.bases.push_back(static_cast<std::uint32_t>(order.nodes.size()));
        for (std::uint64_t left = tree.divided(order.nodes[i]); left != 0; left &= left - 1)
            order.nodes.push_back(static_cast<std::uint32_t>(tree.child(order.nodes[i], std::countr_zero(left))));
    }
    return order;
}

/// Of places of a brick's size, itself and those beside it: nodes, or all of one kind.
struct BrickedGrid::About {
    static constexpr std::uint32_t kAllOpen = std::numeric_limits<std::uint32_t>::max(), kAllClosed = kAllOpen - 1;
    std::array<std::uint32_t, 27> nodes; ///< from the least x, y, z on, x first

    static std::size_t indexOf(int x, int y, int z) {
        return static_cast<std::size_t>((x + 1) + 3 * (y + 1) + 9 * (z + 1));
    }
    std::uint32_t own() const { return nodes[13]; }
    std::uint64_t closed(const UnseenTree& tree, std::size_t i) const {
        return nodes[i] == kAllOpen ? 0 : nodes[i] == kAllClosed ? ~std::uint64_t{0} : tree.closed(nodes[i]);
    }
    /// About a voxel of the brick.
    About below(const UnseenTree& tree, int bit) const {
        About about;
        const int x = bit % kEdge, y = bit / kEdge % kEdge, z = bit / kEdge / kEdge;
        const auto brickOf = [](int at) { return at < 0 ? -1 : at >= kEdge ? 1 : 0; }; // beside this one
        const auto within = [](int at) { return (at + kEdge) % kEdge; };
        forBeside([&](int i, int j, int k) {
            const std::uint32_t in = nodes[indexOf(brickOf(x + i), brickOf(y + j), brickOf(z + k))];
            std::uint32_t& found = about.nodes[indexOf(i, j, k)];
            found = in;
            if (in >= kAllClosed) return;
            const int at = scene::coverageBit(within(x + i), within(y + j), within(z + k));
            const std::uint64_t mask = scene::coverageMask(at);
            if ((tree.divided(in) & mask) != 0)
                found = static_cast<std::uint32_t>(tree.child(in, at));
            else
                found = (tree.closed(in) & mask) != 0 ? kAllClosed : kAllOpen;
        });
        return about;
    }
};

BrickedGrid::BrickedGrid(const UnseenTree& tree, const BrickOrder& order, const VoxelPlace& count,
                         std::span<const std::uint32_t> words)
    : tree_(tree), order_(order), count_(count), words_(words) {}

std::uint32_t BrickedGrid::wordAt(const VoxelPlace& at, int x, int y, int z) const {
    // What is before the first wraps round to far behind the last.
    const std::size_t i = at[0] + static_cast<std::size_t>(x), j = at[1] + static_cast<std::size_t>(y),
                      k = at[2] + static_cast<std::size_t>(z);
    return i < count_[0] && j < count_[1] && k < count_[2] ? words_[(k * count_[1] + j) * count_[0] + i] : 0;
}

BrickedGrid::About BrickedGrid::aboutVoxel(const VoxelPlace& at) const {
    About about;
    forBeside([&](int x, int y, int z) {
        const std::uint32_t word = wordAt(at, x, y, z);
        std::uint32_t& found = about.nodes[About::indexOf(x, y, z)];
        found = word == 0 ? About::kAllClosed : About::kAllOpen;
        if ((word & kBrick) != 0) found = order_.nodes[word & ~kBrick];
    });
    return about;
}

void BrickedGrid::writeDivided(const VoxelPlace& at, std::span<std::uint32_t> all) const {
    write(aboutVoxel(at), wordAt(at, 0, 0, 0) & ~kBrick, all);
}

void BrickedGrid::writeOpen(const VoxelPlace& at, std::size_t brick, std::span<std::uint32_t> all) const {
    write(aboutVoxel(at), brick, all);
}

void BrickedGrid::write(const About& about, std::size_t brick, std::span<std::uint32_t> all) const {
    const bool isNode = about.own() < About::kAllClosed;
    const std::uint64_t closed = about.closed(tree_, 13), divided = isNode ? tree_.divided(about.own()) : 0;
    Rows rows{};
    forBeside([&](int x, int y, int z) {
        if (const std::uint64_t mask = about.closed(tree_, About::indexOf(x, y, z)); mask != 0)
            place(rows, mask, x, y, z);
    });
    // Voxels that have more rings than one, than two, ... In a brick that is a node none has more than three.
    std::array<std::uint64_t, kMostBrickRings - 1> moreThan{};
    for (std::size_t i = 0; i < (isNode ? 2 : moreThan.size()); ++i) {
        rows = widened(rows);
        moreThan[i] = ~ownOf(rows);
    }
    const std::uint64_t pairs = openPairs(closed) & ~moreThan[0];
    for (std::size_t eight = 0; eight < kWordsPerBrick; ++eight) {
        const std::uint64_t before = divided & (scene::coverageMask(static_cast<int>(8 * eight)) - 1);
        std::uint32_t word = static_cast<std::uint32_t>(std::popcount(before)) << kRankBit;
        for (std::size_t i = 0; i < 8; ++i) {
            const std::uint64_t mask = scene::coverageMask(static_cast<int>(8 * eight + i));
            std::uint32_t known = (closed & mask) == 0 ? 1 : 0;
            for (const std::uint64_t more : moreThan)
                known += (more & mask) != 0 ? 1 : 0;
            if ((pairs & mask) != 0) known = kOpenPair;
            if ((divided & mask) != 0) known = kDividedVoxel;
            word |= known << 3 * i;
        }
        all[kWordsPerBrick * brick + eight] = word;
    }
    if (!isNode) return;
    std::size_t below = order_.bases[brick];
    for (std::uint64_t left = divided; left != 0; left &= left - 1)
        write(about.below(tree_, std::countr_zero(left)), below++, all);
}

} // namespace render
