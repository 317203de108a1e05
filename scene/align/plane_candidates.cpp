#include "scene/align/plane_candidates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include <Eigen/Dense>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scene {

namespace {

constexpr std::size_t kMostDirections = 16; ///< of a scan; the heaviest
constexpr std::size_t kMostRotations = 48;
constexpr std::size_t kMostOffsets = 24;  ///< pairs of planes for one direction
constexpr double kSameDirection = 0.9986; ///< cosine: planes that face one way
constexpr double kLeastSine = 0.34;       ///< between two directions that a rotation is found from
constexpr double kLeastVolume = 0.4;      ///< of the normals of three planes that a place is found from
constexpr double kCellMetres = 0.10;      ///< of votes

double worthOf(const ScanPlane& plane) {
    return std::sqrt(plane.areaSquareMetres);
}

/// Planes that face one way.
struct Direction {
    glm::dvec3 normal{0.0};
    double worth = 0;
    std::vector<std::size_t> planes;
};

std::vector<Direction> directionsOf(const std::vector<ScanPlane>& planes) {
    std::vector<Direction> directions;
    for (std::size_t i = 0; i < planes.size(); ++i) {
        const auto same = std::find_if(directions.begin(), directions.end(), [&](const Direction& direction) {
            return glm::dot(glm::normalize(direction.normal), planes[i].normal) > kSameDirection;
        });
        Direction& direction = same == directions.end() ? directions.emplace_back() : *same;
        direction.normal += worthOf(planes[i]) * planes[i].normal;
        direction.worth += worthOf(planes[i]);
        direction.planes.push_back(i);
    }
    std::sort(directions.begin(), directions.end(),
              [](const Direction& a, const Direction& b) { return a.worth > b.worth; });
    if (directions.size() > kMostDirections) directions.resize(kMostDirections);
    for (Direction& direction : directions)
        direction.normal = glm::normalize(direction.normal);
    return directions;
}

/// The rotation of least squares of weighted pairs of directions.
glm::dmat3 kabsch(const Eigen::Matrix3d& products) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(products, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d flip = Eigen::Matrix3d::Identity();
    flip(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
    const Eigen::Matrix3d r = svd.matrixU() * flip * svd.matrixV().transpose();
    glm::dmat3 result;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            result[j][i] = r(i, j);
    return result;
}

void addProduct(Eigen::Matrix3d& products, const glm::dvec3& inA, const glm::dvec3& inB, double weight) {
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            products(i, j) += weight * inA[i] * inB[j];
}

struct Rotation {
    glm::dmat3 aFromB{1.0};
    double worth = 0;
};

/// Sharpens a rotation by all directions that it brings together, and says how much they are worth.
Rotation settle(const std::vector<Direction>& a, const std::vector<Direction>& b, const glm::dmat3& aFromB,
                double sameCosine) {
    Rotation rotation{aFromB, 0};
    Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
    for (const Direction& other : b) {
        const glm::dvec3 normal = aFromB * other.normal;
        const Direction* best = nullptr;
        double nearest = sameCosine;
        for (const Direction& direction : a)
            if (const double cosine = glm::dot(direction.normal, normal); cosine > nearest)
                nearest = cosine, best = &direction;
        if (!best) continue;
        const double worth = std::min(best->worth, other.worth);
        rotation.worth += worth;
        addProduct(products, best->normal, other.normal, worth);
    }
    if (rotation.worth > 0) rotation.aFromB = kabsch(products);
    return rotation;
}

/// Columns are an orthonormal frame of two directions.
glm::dmat3 frameOf(const glm::dvec3& first, const glm::dvec3& second) {
    const glm::dvec3 across = glm::normalize(glm::cross(first, second));
    return {first, across, glm::cross(first, across)};
}

std::vector<Rotation> findRotations(const std::vector<Direction>& a, const std::vector<Direction>& b, double radians) {
    std::vector<Rotation> found;
    const double same = std::cos(2 * radians);
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t j = i + 1; j < a.size(); ++j) {
            const double cosine = glm::dot(a[i].normal, a[j].normal);
            if (std::abs(cosine) > std::sqrt(1 - kLeastSine * kLeastSine)) continue;
            const glm::dmat3 frame = frameOf(a[i].normal, a[j].normal);
            for (std::size_t k = 0; k < b.size(); ++k)
                for (std::size_t l = 0; l < b.size(); ++l) {
                    if (k == l) continue;
                    const double other = glm::dot(b[k].normal, b[l].normal);
                    if (std::abs(other) > 0.98 || std::abs(std::acos(cosine) - std::acos(other)) > radians) continue;
                    const glm::dmat3 aFromB = frame * glm::transpose(frameOf(b[k].normal, b[l].normal));
                    const bool isKnown = std::any_of(found.begin(), found.end(), [&](const Rotation& rotation) {
                        return cosineBetween(rotation.aFromB, aFromB) > same;
                    });
                    if (!isKnown) found.push_back(settle(a, b, aFromB, std::cos(radians)));
                }
        }
    std::stable_sort(found.begin(), found.end(),
                     [](const Rotation& x, const Rotation& y) { return x.worth > y.worth; });
    // Those that settled into one.
    std::vector<Rotation> kept;
    for (const Rotation& rotation : found) {
        const bool isKnown = std::any_of(kept.begin(), kept.end(), [&](const Rotation& other) {
            return cosineBetween(rotation.aFromB, other.aFromB) > std::cos(radians);
        });
        if (!isKnown) kept.push_back(rotation);
        if (kept.size() == kMostRotations) break;
    }
    return kept;
}

/// That a plane of b is one of a says how far b's scanner stands along its normal.
struct Offset {
    glm::dvec3 normal{0.0}; ///< in a
    double metres = 0, worth = 0;
    PlaneMatch match;
};

struct Cell {
    std::int64_t key = 0;
    glm::dvec3 sum{0.0};
    double votes = 0;
    std::size_t rotation = 0;
};

class Places {
  public:
    Places(const std::vector<ScanPlane>& a, const std::vector<ScanPlane>& b, const CandidateOptions& options)
        : a_(a), b_(b), options_(options) {}

    std::vector<Offset> offsetsOf(const Direction& direction, const glm::dmat3& aFromB) const {
        std::vector<Offset> offsets;
        for (const std::size_t i : direction.planes)
            for (std::size_t j = 0; j < b_.size(); ++j) {
                if (glm::dot(a_[i].normal, aFromB * b_[j].normal) < std::cos(options_.sameRadians)) continue;
                offsets.push_back({a_[i].normal,
                                   a_[i].offset - b_[j].offset,
                                   std::sqrt(std::min(a_[i].areaSquareMetres, b_[j].areaSquareMetres)),
                                   {i, j}});
            }
        std::stable_sort(offsets.begin(), offsets.end(),
                         [](const Offset& x, const Offset& y) { return x.worth > y.worth; });
        if (offsets.size() > kMostOffsets) offsets.resize(kMostOffsets);
        return offsets;
    }

    void vote(std::size_t rotationIndex, const std::vector<std::vector<Offset>>& offsets,
              std::unordered_map<std::int64_t, Cell>& cells) const {
        for (std::size_t i = 0; i < offsets.size(); ++i)
            for (std::size_t j = i + 1; j < offsets.size(); ++j)
                for (std::size_t k = j + 1; k < offsets.size(); ++k) {
                    if (offsets[i].empty() || offsets[j].empty() || offsets[k].empty()) continue;
                    const glm::dvec3 x = offsets[i][0].normal, y = offsets[j][0].normal, z = offsets[k][0].normal;
                    if (std::abs(glm::dot(x, glm::cross(y, z))) < kLeastVolume) continue;
                    for (const Offset& first : offsets[i])
                        for (const Offset& second : offsets[j])
                            for (const Offset& third : offsets[k])
                                voteFor(rotationIndex, first, second, third, cells);
                }
    }

  private:
    void voteFor(std::size_t rotationIndex, const Offset& x, const Offset& y, const Offset& z,
                 std::unordered_map<std::int64_t, Cell>& cells) const {
        const glm::dvec3 yz = glm::cross(y.normal, z.normal), zx = glm::cross(z.normal, x.normal),
                         xy = glm::cross(x.normal, y.normal);
        const glm::dvec3 place = (x.metres * yz + y.metres * zx + z.metres * xy) / glm::dot(x.normal, yz);
        if (!(glm::length(place) < options_.farthestMetres)) return;
        std::int64_t key = static_cast<std::int64_t>(rotationIndex);
        for (int axis = 0; axis < 3; ++axis)
            key = (key << 12) | (static_cast<std::int64_t>(std::floor(place[axis] / kCellMetres)) & 0xfff);
        const double votes = x.worth * y.worth * z.worth;
        Cell& cell = cells[key];
        cell.key = key, cell.rotation = rotationIndex;
        cell.sum += votes * place;
        cell.votes += votes;
    }

    const std::vector<ScanPlane>&a_, &b_;
    const CandidateOptions& options_;
};

/// Each plane once, the heaviest match first.
std::vector<PlaneMatch> matchesAt(const std::vector<ScanPlane>& a, const std::vector<ScanPlane>& b, const Pose& aFromB,
                                  const CandidateOptions& options, double& worth) {
    struct Found {
        PlaneMatch match;
        double worth;
    };
    std::vector<Found> found;
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t j = 0; j < b.size(); ++j) {
            const glm::dvec3 normal = aFromB.rotation * b[j].normal;
            if (glm::dot(a[i].normal, normal) < std::cos(options.sameRadians)) continue;
            // At the middle of b's plane: that is where its offset is known.
            const double off = glm::dot(a[i].normal, aFromB * b[j].middle) - a[i].offset;
            if (std::abs(off) > options.sameMetres + options.sameRadians * 0.2 * glm::length(b[j].middle)) continue;
            found.push_back({{i, j}, std::sqrt(std::min(a[i].areaSquareMetres, b[j].areaSquareMetres))});
        }
    std::stable_sort(found.begin(), found.end(), [](const Found& x, const Found& y) { return x.worth > y.worth; });
    std::vector<bool> takenA(a.size(), false), takenB(b.size(), false);
    std::vector<PlaneMatch> matches;
    worth = 0;
    for (const Found& each : found) {
        if (takenA[each.match.a] || takenB[each.match.b]) continue;
        takenA[each.match.a] = takenB[each.match.b] = true;
        matches.push_back(each.match);
        worth += each.worth;
    }
    return matches;
}

} // namespace

bool poseFromMatches(const std::vector<ScanPlane>& a, const std::vector<ScanPlane>& b,
                     const std::vector<PlaneMatch>& matches, Pose& aFromB) {
    Eigen::Matrix3d products = Eigen::Matrix3d::Zero(), normals = Eigen::Matrix3d::Zero();
    for (const PlaneMatch& match : matches)
        addProduct(products, a[match.a].normal, b[match.b].normal, std::min(worthOf(a[match.a]), worthOf(b[match.b])));
    const Eigen::JacobiSVD<Eigen::Matrix3d> directions(products);
    if (directions.singularValues()[1] < 0.02 * directions.singularValues()[0]) return false;
    aFromB.rotation = kabsch(products);
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const PlaneMatch& match : matches) {
        const glm::dvec3& n = a[match.a].normal;
        const double weight = std::min(worthOf(a[match.a]), worthOf(b[match.b]));
        const double metres = a[match.a].offset - glm::dot(n, aFromB.rotation * b[match.b].middle);
        addProduct(normals, n, n, weight);
        right += weight * metres * Eigen::Vector3d(n.x, n.y, n.z);
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(normals);
    if (solver.eigenvalues()[0] < 0.01 * solver.eigenvalues()[2]) return false;
    const Eigen::Vector3d place = normals.ldlt().solve(right);
    aFromB.translation = {place.x(), place.y(), place.z()};
    return true;
}

std::vector<PoseCandidate> findCandidates(const std::vector<ScanPlane>& a, const std::vector<ScanPlane>& b,
                                          const CandidateOptions& options) {
    const std::vector<Direction> directionsA = directionsOf(a), directionsB = directionsOf(b);
    const std::vector<Rotation> rotations = findRotations(directionsA, directionsB, options.sameRadians);
    const Places places(a, b, options);
    std::vector<Cell> all;
    for (std::size_t r = 0; r < rotations.size(); ++r) {
        std::vector<std::vector<Offset>> offsets;
        for (const Direction& direction : directionsA) {
            offsets.push_back(places.offsetsOf(direction, rotations[r].aFromB));
            if (offsets.size() == 10) break; // the heaviest directions: triples of all would be very many
        }
        std::unordered_map<std::int64_t, Cell> cells;
        places.vote(r, offsets, cells);
        for (const auto& [key, cell] : cells)
            all.push_back(cell);
    }
    std::sort(all.begin(), all.end(),
              [](const Cell& x, const Cell& y) { return x.votes != y.votes ? x.votes > y.votes : x.key < y.key; });

    std::vector<PoseCandidate> candidates;
    const std::size_t looked = std::min(all.size(), static_cast<std::size_t>(options.most) * 20);
    for (std::size_t i = 0; i < looked; ++i) {
        PoseCandidate candidate;
        candidate.aFromB = {rotations[all[i].rotation].aFromB, all[i].sum / all[i].votes};
        for (int pass = 0; pass < 2; ++pass) {
            candidate.matches = matchesAt(a, b, candidate.aFromB, options, candidate.votes);
            if (!poseFromMatches(a, b, candidate.matches, candidate.aFromB)) {
                candidate.votes = 0;
                break;
            }
        }
        if (!(candidate.votes > 0)) continue;
        const bool isKnown = std::any_of(candidates.begin(), candidates.end(), [&](const PoseCandidate& other) {
            return glm::distance(other.aFromB.translation, candidate.aFromB.translation) < kCellMetres &&
                   cosineBetween(other.aFromB.rotation, candidate.aFromB.rotation) > std::cos(options.sameRadians);
        });
        if (!isKnown) candidates.push_back(std::move(candidate));
    }
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const PoseCandidate& x, const PoseCandidate& y) { return x.votes > y.votes; });
    if (candidates.size() > static_cast<std::size_t>(options.most))
        candidates.resize(static_cast<std::size_t>(options.most));
    return candidates;
}

} // namespace scene
