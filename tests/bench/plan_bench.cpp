// Walk cells: built beside CGAL alone, and found again from the last one.

#include "scene/plan/walk_cells.h"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <benchmark/benchmark.h>

#include <random>
#include <vector>

namespace {

constexpr int kPositions = 100'000;

std::vector<glm::dvec3> positions() {
    std::mt19937 generator(1);
    std::uniform_real_distribution<double> along(-100, 100);
    std::vector<glm::dvec3> made(kPositions);
    for (glm::dvec3& p : made)
        p = {along(generator), along(generator), along(generator)};
    return made;
}

void buildCells(benchmark::State& state) {
    const std::vector<glm::dvec3> places = positions();
    for (auto _ : state)
        benchmark::DoNotOptimize(scene::WalkCells(places));
    state.SetItemsProcessed(state.iterations() * kPositions);
}
BENCHMARK(buildCells)->Unit(benchmark::kMillisecond);

void buildByCgalAlone(benchmark::State& state) {
    using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
    std::vector<Kernel::Point_3> points;
    for (const glm::dvec3& p : positions())
        points.emplace_back(p.x, p.y, p.z);
    for (auto _ : state) {
        const CGAL::Delaunay_triangulation_3<Kernel> delaunay(points.begin(), points.end());
        benchmark::DoNotOptimize(delaunay.number_of_finite_cells());
    }
    state.SetItemsProcessed(state.iterations() * kPositions);
}
BENCHMARK(buildByCgalAlone)->Unit(benchmark::kMillisecond);

/// A walk of 1 mm a step, straight through everything.
void locateFromLast(benchmark::State& state) {
    static const scene::WalkCells cells(positions());
    std::uint32_t cell = 0;
    double x = -90;
    for (auto _ : state) {
        cell = cells.locate({x, 0.3 * x, -0.2 * x}, cell);
        benchmark::DoNotOptimize(cell);
        x = x > 90 ? -90 : x + 0.001;
    }
}
BENCHMARK(locateFromLast);

void sharesFromLast(benchmark::State& state) {
    std::vector<glm::dvec3> few = positions();
    few.resize(static_cast<std::size_t>(state.range(0)));
    const scene::WalkCells cells(few);
    std::vector<scene::PositionShare> shares;
    std::uint32_t cell = 0;
    double x = -90;
    for (auto _ : state) {
        cells.sharesAt({x, 0.3 * x, -0.2 * x}, cell, shares);
        benchmark::DoNotOptimize(shares.data());
        x = x > 90 ? -90 : x + 0.01;
    }
}
BENCHMARK(sharesFromLast)->Arg(32)->Arg(1000);

} // namespace
