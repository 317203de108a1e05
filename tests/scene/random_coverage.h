#pragma once
// A coverage of no place: cells of every kind and size, side by side at random.

#include "scene/coverage.h"

#include <random>

namespace scene {

/// levels nodes deep; its cube stands off the origin, its edge is no round number. unseenShare: of the cells that are
/// not divided. dividedShare: of those above the last level.
inline Coverage randomCoverage(std::uint32_t seed, int levels, double unseenShare = 0.3, double dividedShare = 0.3) {
    std::mt19937 random(seed);
    const auto chance = [&](double share) { return static_cast<double>(random() & 0xffffu) < share * 65536; };
    Coverage coverage;
    coverage.cornerInWorld = {-1.3, 2.2, 0.7};
    coverage.edgeMetres = 5.7;
    coverage.nodes.resize(1);
    std::vector<int> level{1};
    for (std::size_t i = 0; i < coverage.nodes.size(); ++i) {
        CoverageNode node;
        for (int bit = 0; bit < 64; ++bit) {
            if (level[i] < levels && chance(dividedShare))
                node.children |= coverageMask(bit);
            else if (chance(unseenShare))
                node.unseen |= coverageMask(bit);
            else if (chance(0.4))
                node.surface |= coverageMask(bit);
        }
        if (node.children != 0) node.firstChild = static_cast<std::uint32_t>(coverage.nodes.size());
        coverage.nodes[i] = node;
        const std::size_t children = static_cast<std::size_t>(std::popcount(node.children));
        coverage.nodes.resize(coverage.nodes.size() + children);
        level.resize(coverage.nodes.size(), level[i] + 1);
    }
    return coverage;
}

} // namespace scene
