// The nearest place of a simplex is the one from which no corner lies towards the point: that alone makes it the
// nearest.

#include "scene/plan/simplex.h"
#include "tests/scene/random_poses.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include <glm/geometric.hpp>

namespace scene {
namespace {

void expectNearest(std::span<const glm::dvec3> corners, const glm::dvec3& p) {
    const glm::dvec3 place = nearestInSimplex(corners, p);
    double extent = glm::length(p - place);
    for (const glm::dvec3& corner : corners)
        extent = std::max(extent, glm::length(corner - p));
    const double small = 1e-7 * extent * extent + 1e-300;
    for (const glm::dvec3& corner : corners)
        EXPECT_LE(glm::dot(corner - place, p - place), small) << corners.size() << " corners";
    // It lies in the simplex: it is its own nearest place.
    EXPECT_LE(glm::length(nearestInSimplex(corners, place) - place), 1e-7 * extent);
}

TEST(NearestInSimplex, IsNearestWhereverThePointLies) {
    RandomPlaces places(71);
    for (int i = 0; i < 20'000; ++i) {
        std::array<glm::dvec3, 4> corners{};
        for (glm::dvec3& corner : corners)
            corner = places.point(1);
        const auto some =
            std::span<const glm::dvec3>(corners).first(static_cast<std::size_t>(places.integerBetween(1, 4)));
        expectNearest(some, places.point(2));
    }
}

TEST(NearestInSimplex, IsNearestWhereCornersSpanLessThanTheirNumber) {
    RandomPlaces places(72);
    for (int i = 0; i < 5'000; ++i) {
        const glm::dvec3 a = places.point(1), b = places.point(1), c = places.point(1);
        const double t = places.between(-1, 2), u = places.between(-1, 2);
        const glm::dvec3 onLine = a + t * (b - a), inPlane = onLine + u * (c - a), p = places.point(2);
        expectNearest(std::array{a, b, onLine}, p);
        expectNearest(std::array{a, b, c, inPlane}, p);
        expectNearest(std::array{a, b, onLine, a + u * (b - a)}, p);
        expectNearest(std::array{a, a, a, a}, p);
        expectNearest(std::array{a, b, a, b}, p);
    }
}

TEST(NearestInSimplex, WithinATetrahedronIsThePointItself) {
    const std::array<glm::dvec3, 4> corners{glm::dvec3(0), {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    EXPECT_EQ(nearestInSimplex(corners, {0.2, 0.2, 0.2}), glm::dvec3(0.2, 0.2, 0.2));
    EXPECT_LE(glm::length(nearestInSimplex(corners, glm::dvec3(1)) - glm::dvec3(1.0 / 3)), 1e-15);
    EXPECT_EQ(nearestInSimplex(corners, {-1, 0.5, -1}), glm::dvec3(0, 0.5, 0));
    EXPECT_EQ(nearestInSimplex(corners, {3, 0, 0}), glm::dvec3(1, 0, 0));
}

} // namespace
} // namespace scene
