#pragma once
// Images that the others contradict: their poses, or their range, are wrong. A wrong image claims surfaces where others
// saw through, or saw through surfaces that others have. Either counts against both images of a pair, and the one with
// the most against it, in so many pairs, is the wrong one:
//
//   pair       a b   a c   b c   a X   b X   c X       a: 12 of 32   b: 14 of 32   c: 13 of 32   X: 33 of 36
//   against      1     1     1    10    12    11       without X each 2 of 20
//   of          10    10    10    12    12    12
//
// Beyond the four articles.

#include "scene/refine/skins.h"

#include <cstddef>
#include <span>
#include <vector>

namespace scene {

struct ContradictionOptions {
    /// Of what an image and its partners say of each other's samples, the share against them from which it is named:
    /// of no capture of ours that is as it should be does an image reach 5 %.
    double share = 0.08;
    /// It must also be so many times that of the image in the middle of the rest without it: range that is noisy, or a
    /// wrong camera, speaks against all alike.
    double timesMedian = 4;
    /// What an image and its partners say of each other's samples must come to so much of the image's own: less may be
    /// chance.
    double spokenOf = 0.05;
};

struct Contradiction {
    std::size_t image = 0;
    double share = 0; ///< against it, of all that it and those that are not named say of each other's samples
};

/// The images that the rest contradicts, the worst first. Of two that have none but each other nobody knows which is
/// wrong, and neither is named.
std::vector<Contradiction> findContradictions(std::span<const SkinFigures> images,
                                              const ContradictionOptions& options = {});

} // namespace scene
