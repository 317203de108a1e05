#include "scene/coverage_levels.h"

#include <bit>
#include <cassert>
#include <cmath>

namespace scene {

namespace {

/// Share of a cell. A surface in what is left of it stands so near that cell's face that it is not taken for hidden.
constexpr float kMostlyUnseen = 0.75f;

/// Of what is cut off: shares of its volume.
struct Content {
    float unseen = 0, empty = 0;
    bool hasSurface = false;
};

Content contentOf(const CoverageNode& node, const std::vector<Content>& below, std::size_t firstBelow) {
    constexpr float kCell = 1.f / 64;
    Content content;
    content.unseen = kCell * static_cast<float>(std::popcount(node.unseen));
    content.empty = kCell * static_cast<float>(std::popcount(~(node.unseen | node.surface | node.children)));
    content.hasSurface = node.surface != 0;
    for (int child = 0; child < std::popcount(node.children); ++child) {
        const Content& part = below[node.firstChild + static_cast<std::size_t>(child) - firstBelow];
        content.unseen += kCell * part.unseen, content.empty += kCell * part.empty;
        content.hasSurface = content.hasSurface || part.hasSurface;
    }
    return content;
}

Observed kindOf(const Content& content) {
    if (content.hasSurface) return content.unseen >= kMostlyUnseen ? Observed::unseen : Observed::surface;
    return content.unseen >= content.empty ? Observed::unseen : Observed::empty;
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
