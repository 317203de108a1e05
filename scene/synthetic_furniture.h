#pragma once
// Things that stand about in synthetic scenes, each built into a model at a place.

#include "scene/synthetic_model.h"
#include "scene/synthetic_random.h"

namespace scene {

/// All stand on z = 0 of the pose they are given; x is their width, y their depth, their front is towards -y.
void addChair(SyntheticModel& model, const Pose& worldFromChair, int wood, int cloth);
void addTable(SyntheticModel& model, const Pose& worldFromTable, const glm::dvec3& size, int wood);
void addSofa(SyntheticModel& model, const Pose& worldFromSofa, double width, int cloth, int pillow);

/// A case of shelves filled with books and a few round things.
void addBookcase(SyntheticModel& model, const Pose& worldFromCase, const glm::dvec3& size, int wood,
                 SeededSequence& random);

/// A pot with a bunch of arching leaves.
void addPottedPlant(SyntheticModel& model, const glm::dvec3& at, double height, SeededSequence& random);

/// A trunk with branches and a crown of leaves around it.
void addTree(SyntheticModel& model, const glm::dvec3& at, double height, int leaves, SeededSequence& random);

/// A clipped hedge: a dense volume of leaves over a dark core.
void addHedge(SyntheticModel& model, const Pose& worldFromHedge, const glm::dvec3& size, int leaves,
              SeededSequence& random);

/// A car with its damage: x forward, y left, z up, its middle over the origin.
struct CarShape {
    glm::dvec3 paint{0.5, 0.05, 0.04};
    double frontCrush = 0; ///< metres that the front is shorter
    double sideDent = 0;   ///< metres that the right side is pushed in
    double dentAt = 0;     ///< x of the dent's middle
    double fineness = 1;   ///< of its mesh; 1: a vertex each 4 cm
    std::uint32_t seed = 1;
};
void addCar(SyntheticModel& model, const Pose& worldFromCar, const CarShape& shape);

} // namespace scene
