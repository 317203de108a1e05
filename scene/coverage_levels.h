#pragma once
// Coverage told by fewer nodes, where there is no room for all of them: the tree is cut off below a level.

#include "scene/coverage.h"

#include <cstddef>
#include <vector>

namespace scene {

/// The first node of each level, the whole cube's level first, and behind them how many nodes there are. One level less
/// than it has entries.
std::vector<std::size_t> firstNodesOf(const Coverage& coverage);

/// Nodes on the way to the smallest cell, at least 1.
int levelsOf(const Coverage& coverage);

/// Edge of the smallest cell that a tree of so many levels can have, metres.
double cellOfLevels(const Coverage& coverage, int levels);

/// Of at most so many levels (at least 1). What is cut off becomes one cell. If there is surface in it, it is of
/// surface unless nine tenths of it are unseen; if there is none, it is empty unless three quarters are. A rim of the
/// unseen moves by less than such a cell; what is thinner is lost, on either side of it.
Coverage coarsened(const Coverage& coverage, int levels);

} // namespace scene
