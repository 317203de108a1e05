#include "scene/plan/simplex.h"

#include <array>
#include <cassert>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scene {

namespace {

/// Below this share of its edges' product a determinant is rounding: the corners do not span what their number says.
constexpr double kFlat = 1e-14;

/// Shares of the corners after the first at the place of the simplex' hyperplane that is nearest to p; false where the
/// corners span none.
bool solve(std::span<const glm::dvec3> corners, const glm::dvec3& p, std::array<double, 3>& shares) {
    const std::size_t n = corners.size() - 1;
    std::array<glm::dvec3, 3> edges{};
    for (std::size_t i = 0; i < n; ++i)
        edges[i] = corners[i + 1] - corners[0];
    const glm::dvec3 to = p - corners[0];
    if (n == 1) {
        const double square = glm::dot(edges[0], edges[0]);
        if (!(square > 0)) return false;
        shares[0] = glm::dot(to, edges[0]) / square;
        return true;
    }
    if (n == 2) {
        const double a = glm::dot(edges[0], edges[0]), b = glm::dot(edges[0], edges[1]),
                     c = glm::dot(edges[1], edges[1]);
        const double determinant = a * c - b * b;
        if (!(determinant > kFlat * a * c)) return false;
        const double u = glm::dot(to, edges[0]), v = glm::dot(to, edges[1]);
        shares[0] = (c * u - b * v) / determinant;
        shares[1] = (a * v - b * u) / determinant;
        return true;
    }
    const glm::dvec3 across = glm::cross(edges[1], edges[2]);
    const double determinant = glm::dot(edges[0], across);
    if (!(std::abs(determinant) > kFlat * glm::length(edges[0]) * glm::length(edges[1]) * glm::length(edges[2])))
        return false;
    shares[0] = glm::dot(to, across) / determinant;
    shares[1] = glm::dot(to, glm::cross(edges[2], edges[0])) / determinant;
    shares[2] = glm::dot(to, glm::cross(edges[0], edges[1])) / determinant;
    return true;
}

} // namespace

glm::dvec3 nearestInSimplex(std::span<const glm::dvec3> corners, const glm::dvec3& p) {
    assert(!corners.empty() && corners.size() <= 4);
    if (corners.size() == 1) return corners[0];
    std::array<double, 3> shares{};
    const bool isSpanned = solve(corners, p, shares);
    std::array<double, 4> weights{1, 0, 0, 0};
    bool isInside = isSpanned;
    if (isSpanned) {
        for (std::size_t i = 1; i < corners.size(); ++i) {
            weights[i] = shares[i - 1];
            weights[0] -= weights[i];
        }
        for (std::size_t i = 0; i < corners.size(); ++i)
            isInside = isInside && weights[i] >= 0;
    }
    if (isInside) {
        if (corners.size() == 4) return p;
        glm::dvec3 place = corners[0];
        for (std::size_t i = 1; i < corners.size(); ++i)
            place += weights[i] * (corners[i] - corners[0]);
        return place;
    }
    // The nearest place lies in a face that p is beyond; of a simplex without extent, in any.
    glm::dvec3 nearest = corners[0];
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t without = 0; without < corners.size(); ++without) {
        if (isSpanned && weights[without] >= 0) continue;
        std::array<glm::dvec3, 3> face{};
        std::size_t count = 0;
        for (std::size_t i = 0; i < corners.size(); ++i)
            if (i != without) face[count++] = corners[i];
        const glm::dvec3 place = nearestInSimplex(std::span(face).first(count), p);
        const double square = glm::dot(place - p, place - p);
        if (square < least) least = square, nearest = place;
    }
    return nearest;
}

} // namespace scene
