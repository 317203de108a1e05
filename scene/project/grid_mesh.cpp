#include "scene/project/grid_mesh.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace scene {
namespace {

// A square of four cells has two triangles, cut along its shorter diagonal, or one where a corner is missing.
// A triangle's number is 4 * cell + kind, the cell being the square's top left one:
//
//     a --- b      kind 0: a b d     kind 2: a b e
//     |     |      kind 1: b e d     kind 3: a e d
//     d --- e
enum Corner { kA, kB, kD, kE };
constexpr std::array<std::array<Corner, 3>, 4> kKinds{{{kA, kB, kD}, {kB, kE, kD}, {kA, kB, kE}, {kA, kE, kD}}};

using Square = std::array<std::int32_t, 4>; ///< points at a, b, d, e; -1 where there is none

Square squareAt(const ScanGrid& grid, int x, int y) {
    const int right = x + 1 < grid.pointOfCell.width() ? x + 1 : 0;
    return {grid.pointOfCell(x, y), grid.pointOfCell(right, y), grid.pointOfCell(x, y + 1),
            grid.pointOfCell(right, y + 1)};
}

struct Vertex {
    glm::dvec3 inFace;
    double range = 0;
};

struct Projected {
    double x = 0, y = 0, disparity = 0;
};

Projected projectVertex(const Camera& camera, const glm::dvec3& p) {
    const glm::dvec2 place = project(camera, p);
    return {place.x, place.y, 1.0 / p.z};
}

// Twice the signed area of (a, b, p).
double edge(const Projected& a, const Projected& b, double x, double y) {
    return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

class Drawing {
  public:
    Drawing(const Camera& camera, const AngularSteps& steps, Image<MeshPixel>& image)
        : camera_(camera), image_(image),
          // Corners of a square that touches the face lie this far beyond its edge at most: linked cells are
          // no more than four steps apart, which at the edge is twice that in tangents, and a diagonal is two
          // sides.
          reach_(1.0 + kMeshOverlapPixels * std::max(1 / camera.fx, 1 / camera.fy) +
                 16.0 * std::min(std::max(steps.horizontal, steps.vertical), 0.125)) {}

    bool mayTouch(const glm::dvec3& p) const {
        return p.z > 0 && std::max(std::abs(p.x), std::abs(p.y)) <= reach_ * p.z;
    }

    void triangle(const Vertex& va, const Vertex& vb, const Vertex& vc, std::uint32_t number) {
        const Projected a = projectVertex(camera_, va.inFace), b = projectVertex(camera_, vb.inFace),
                        c = projectVertex(camera_, vc.inFace);
        const double area = edge(a, b, c.x, c.y);
        if (!(std::abs(area) > 1e-9)) return; // seen edge-on: its points are stamped
        const auto firstCentre = [](double from) { return static_cast<int>(std::ceil(std::max(from, 0.0) - 0.5)); };
        const auto lastCentre = [](double to, int size) {
            return static_cast<int>(std::floor(std::min(to, double(size)) - 0.5));
        };
        const int x0 = firstCentre(std::min({a.x, b.x, c.x})), y0 = firstCentre(std::min({a.y, b.y, c.y}));
        const int x1 = lastCentre(std::max({a.x, b.x, c.x}), image_.width());
        const int y1 = lastCentre(std::max({a.y, b.y, c.y}), image_.height());
        const double low = std::min({a.disparity, b.disparity, c.disparity});
        const double high = std::max({a.disparity, b.disparity, c.disparity});
        constexpr double kOnEdge = -1e-9; // a centre on the edge of two triangles belongs to both, rounding or not
        for (int y = std::max(y0, 0); y <= y1; ++y)
            for (int x = std::max(x0, 0); x <= x1; ++x) {
                const double wa = edge(b, c, x + 0.5, y + 0.5) / area, wb = edge(c, a, x + 0.5, y + 0.5) / area;
                const double wc = 1.0 - wa - wb;
                if (wa < kOnEdge || wb < kOnEdge || wc < kOnEdge) continue;
                const double disparity = std::clamp(wa * a.disparity + wb * b.disparity + wc * c.disparity, low, high);
                keepNearer(image_(x, y), meshPixel(static_cast<float>(disparity), number));
            }
    }

  private:
    static void keepNearer(MeshPixel& pixel, MeshPixel candidate) {
        const std::atomic_ref<MeshPixel> shared(pixel);
        MeshPixel seen = shared.load(std::memory_order_relaxed);
        while (candidate > seen && !shared.compare_exchange_weak(seen, candidate, std::memory_order_relaxed)) {
        }
    }

    const Camera camera_;
    Image<MeshPixel>& image_;
    double reach_;
};

} // namespace

Image<MeshPixel> drawGrid(const Scan& scan, const ScanGrid& grid, const CubeFrame& frame, int face,
                          const Camera& camera) {
    Image<MeshPixel> image(camera.width, camera.height, 0);
    Drawing drawing(camera, grid.steps, image);
    const int width = grid.pointOfCell.width(), squares = grid.closes ? width : width - 1;

    const auto drawSquare = [&](int x, int y) {
        const int right = x + 1 < width ? x + 1 : 0;
        const std::uint8_t a = grid.links(x, y), b = grid.links(right, y), d = grid.links(x, y + 1);
        const bool top = a & kLinkRight, left = a & kLinkBelow, bottom = d & kLinkRight, rightSide = b & kLinkBelow;
        // A triangle is on one surface if both of its sides along the grid are.
        const std::array<bool, 4> isSurface{top && left, rightSide && bottom, top && rightSide, left && bottom};
        if (isSurface == std::array<bool, 4>{}) return;

        const Square square = squareAt(grid, x, y);
        std::array<Vertex, 4> vertices;
        for (std::size_t corner = 0; corner < 4; ++corner) {
            if (square[corner] < 0) continue; // then no side that ends there is linked
            const glm::dvec3 p = frame.inFace(face, scan.pointsInScanner[static_cast<std::size_t>(square[corner])]);
            if (!drawing.mayTouch(p)) return;
            vertices[corner] = {p, glm::length(p)};
        }
        const auto draw = [&](std::uint32_t kind) {
            if (!isSurface[kind]) return false;
            const auto& [i, j, k] = kKinds[kind];
            const std::uint32_t cell =
                static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(width) + static_cast<std::uint32_t>(x);
            drawing.triangle(vertices[i], vertices[j], vertices[k], 4 * cell + kind);
            return true;
        };
        // The diagonal along which the range changes less follows an edge better; the other one serves where
        // only its triangle is a surface.
        const bool fallsB =
            std::abs(vertices[kB].range - vertices[kD].range) <= std::abs(vertices[kA].range - vertices[kE].range);
        const std::uint32_t first = fallsB ? 0 : 2, second = fallsB ? 2 : 0;
        const bool isFirstDrawn = draw(first), isSecondDrawn = draw(first + 1);
        if (!isFirstDrawn && !isSecondDrawn && !draw(second)) draw(second + 1);
    };
    tbb::parallel_for(tbb::blocked_range<int>(0, grid.pointOfCell.height() - 1),
                      [&](const tbb::blocked_range<int>& rows) {
                          for (int y = rows.begin(); y < rows.end(); ++y)
                              for (int x = 0; x < squares; ++x)
                                  drawSquare(x, y);
                      });
    return image;
}

std::array<std::int32_t, 3> cornersOf(const ScanGrid& grid, std::uint32_t triangle) {
    const auto width = static_cast<std::uint32_t>(grid.pointOfCell.width());
    const std::uint32_t cell = triangle / 4;
    const Square square = squareAt(grid, static_cast<int>(cell % width), static_cast<int>(cell / width));
    const auto& [a, b, c] = kKinds[triangle % 4];
    return {square[a], square[b], square[c]};
}

ColourMean colourAt(const Scan& scan, const std::array<std::int32_t, 3>& corners, const CubeFrame& frame, int face,
                    const Camera& camera, double x, double y) {
    std::array<Projected, 3> p;
    for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec3 corner = frame.inFace(face, scan.pointsInScanner[static_cast<std::size_t>(corners[i])]);
        p[i] = projectVertex(camera, corner);
    }
    const double area = edge(p[0], p[1], p[2].x, p[2].y);
    const double wa = std::clamp(edge(p[1], p[2], x, y) / area, 0.0, 1.0);
    const double wb = std::clamp(edge(p[2], p[0], x, y) / area, 0.0, 1.0 - wa);
    const std::array<double, 3> weights{wa, wb, 1.0 - wa - wb};
    ColourMean mean;
    for (std::size_t i = 0; i < 3; ++i)
        mean.add(scan, static_cast<std::size_t>(corners[i]), weights[i]);
    return mean;
}

} // namespace scene
