#pragma once
// How a photograph stands to another one from the same place: the two differ by a rotation alone, so their greys can be
// compared themselves, which says it to a small part of a pixel. Gauss and Newton's steps from coarse to fine (Lucas
// and Kanade, "An iterative image registration technique", 1981), without the broad shading and up to a factor, since
// exposures differ. A level of a part of the picture has a say by how much the two have in common there: noise alone
// has slopes, too.

#include "scene/align/small_photograph.h"
#include "scene/align/turn_search.h"

#include <optional>
#include <vector>

#include <glm/mat3x3.hpp>

namespace scene {

/// The grey of one size: blurred by a Gaussian less what one twice as broad leaves; one pixel for so many.
struct GreyLevel {
    Image<float> grey;
    int pixelsPerPixel = 1;
};

struct GreyLevels {
    std::vector<GreyLevel> levels; ///< coarsest first
    Camera camera;
};

GreyLevels greyLevels(const SmallPhotograph& photograph);

struct NeighbourTurn {
    Turn turn = Turn::Zero();   ///< about b's axes: matrixOf(turn) * bFromA is right. Radians
    Eigen::Matrix3d covariance; ///< of that, by leaving out parts of the picture; great where nothing holds it
    double correlation = 0;     ///< of the greys, at the fine level where it is greatest
    int parts = 0;              ///< of what both see, that have much in common
    double agreeing = 0;        ///< the share that these have of all that is to be seen, by its contrast
};

/// From near a turn (some pixels of the coarsest level) to the one that lays a on b best; nothing where the two share
/// too little, or nothing holds it.
std::optional<NeighbourTurn> layOnNeighbour(const GreyLevels& a, const GreyLevels& b, const glm::dmat3& bFromA,
                                            const Turn& start);

} // namespace scene
