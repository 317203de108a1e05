#include "scene/coverage_levels.h"

#include <bit>
#include <cassert>
#include <cmath>

namespace scene {

namespace {

/// Share of a cell that is unseen if it is to count so whole. Less, and narrow gaps that images saw between unseen
/// parts are closed. Where there is surface in it, it is for what little was not observed that the surface shall
/// vanish: with less, large cells stand out of walls and floors that were seen; if surface always decided, what lies
/// behind thin ones would be missed (docs/performance.md, "Coarser cells").
constexpr float kMostlyUnseen = 0.75f, kUnseenBesideSurface = 0.9f;

/// Of what is cut off.
struct Content {
    float unseen = 0; ///< share of its volume
    bool hasSurface = false;
};

Content contentOf(const CoverageNode& node, const std::vector<Content>& below, std::size_t firstBelow) {
    constexpr float kCell = 1.f / 64;
    Content content;
    content.unseen = kCell * static_cast<float>(std::popcount(node.unseen));
    content.hasSurface = node.surface != 0;
    for (int child = 0; child < std::popcount(node.children); ++child) {
        const Content& part = below[node.firstChild + static_cast<std::size_t>(child) - firstBelow];
        content.unseen += kCell * part.unseen;
        content.hasSurface = content.hasSurface || part.hasSurface;
    }
    return content;
}

Observed kindOf(const Content& content) {
    if (content.unseen >= (content.hasSurface ? kUnseenBesideSurface : kMostlyUnseen)) return Observed::unseen;
    return content.hasSurface ? Observed::surface : Observed::empty;
}

} // namespace

std::vector<std::size_t> firstNodesOf(const Coverage& coverage) {
    // Each level's nodes stand behind those of the level before.
    std::vector<std::size_t> firsts{0};
    for (std::size_t next = 1; next > firsts.back();) {
        std::size_t end = next;
        for (std::size_t i = firsts.back(); i < next; ++i)
            end += static_cast<std::size_t>(std::popcount(coverage.nodes[i].children));
        firsts.push_back(next);
        next = end;
    }
    return firsts;
}

int levelsOf(const Coverage& coverage) {
    return static_cast<int>(firstNodesOf(coverage).size()) - 1;
}

double cellOfLevels(const Coverage& coverage, int levels) {
    return coverage.edgeMetres / std::pow(kCoverageBranching, levels);
}

Coverage coarsened(const Coverage& coverage, int levels) {
    assert(levels >= 1);
    const std::vector<std::size_t> firsts = firstNodesOf(coverage);
    const auto last = static_cast<std::size_t>(levels) - 1;
    if (last + 2 >= firsts.size()) return coverage;
    const std::size_t end = firsts[last + 1];
    std::vector<Content> below(coverage.nodes.size() - end);
    for (std::size_t i = coverage.nodes.size(); i-- > end;)
        below[i - end] = contentOf(coverage.nodes[i], below, end);

    Coverage coarser;
    coarser.cornerInWorld = coverage.cornerInWorld, coarser.edgeMetres = coverage.edgeMetres;
    coarser.nodes.assign(coverage.nodes.begin(), coverage.nodes.begin() + static_cast<std::ptrdiff_t>(end));
    for (std::size_t i = firsts[last]; i < end; ++i) {
        CoverageNode& node = coarser.nodes[i];
        std::size_t child = node.firstChild;
        for (std::uint64_t left = node.children; left != 0; left &= left - 1, ++child) {
            const Observed kind = kindOf(below[child - end]);
            const std::uint64_t cell = left & -left;
            if (kind == Observed::unseen) node.unseen |= cell;
            if (kind == Observed::surface) node.surface |= cell;
        }
        node.children = 0, node.firstChild = 0;
    }
    return coarser;
}

} // namespace scene
