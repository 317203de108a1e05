// Next scans against places of known geometry: what a proposal is said to reveal is held against what a simulated scan
// from there does reveal.

#include "scene/plan/next_scan.h"

#include "scene/image_store.h"
#include "scene/project/cube_faces.h"
#include "scene/refine/cover.h"
#include "scene/refine/pairs.h"
#include "scene/refine/skins.h"
#include "scene/synthetic.h"
#include "scene/synthetic_model.h"

#include <chrono>
#include <cmath>
#include <cstdio>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

namespace scene {
namespace {

constexpr int kColumns = 700, kRows = 292;

/// World +Z up; walk's floor at z = 0.
Pose walkFromUpright() {
    return {glm::dmat3(1, 0, 0, 0, 0, -1, 0, 1, 0), glm::dvec3(0)};
}

Coverage scanFrom(const SyntheticScene& place, const std::vector<glm::dvec3>& stood) {
    std::vector<DepthImage> images;
    for (std::size_t i = 0; i < stood.size(); ++i) {
        Scan scan = simulateScan(place, {glm::dmat3(1), stood[i]}, kColumns, kRows);
        scan.name = "scan" + std::to_string(i);
        for (DepthImage& face : projectToCubeFaces(scan).faces)
            images.push_back(std::move(face));
    }
    ImageStore store(images);
    std::vector<ImageOutline> outlines;
    for (const DepthImage& image : images)
        outlines.push_back(outlineOf(image));
    const auto partners = findPartners(outlines);
    tbb::parallel_for(std::size_t{0}, images.size(), [&](std::size_t i) {
        SkinFigures figures;
        images[i].flags = markSkins(store, i, partners[i], {}, figures);
    });
    ImageStore marked(images);
    CoverFigures figures;
    return cover(marked, {}, figures);
}

double tell(const char* name, const SyntheticScene& place, std::vector<glm::dvec3> stood) {
    const auto now = [] { return std::chrono::steady_clock::now(); };
    const auto t0 = now();
    Coverage coverage = scanFrom(place, stood);
    const auto t1 = now();
    const NextScanPlan plan = planNextScans(coverage, walkFromUpright(), stood, {});
    const auto t2 = now();
    std::printf("%s: bounds %.2f %.2f %.2f, unseen %.1f m3 of %.1f, candidates %zu, free path %.1f; cover %.1f s plan %.1f s\n",
                name, plan.bounds.size.x, plan.bounds.size.y, plan.bounds.size.z, plan.unseenCubicMetres,
                plan.bounds.cubicMetres(), plan.candidates, plan.seen.freePathMetres,
                std::chrono::duration<double>(t1 - t0).count(), std::chrono::duration<double>(t2 - t1).count());
    for (double e : plan.seen.echo) std::printf(" %.2f", e);
    std::printf("\n");
    double before = plan.unseenCubicMetres, ratio = 0;
    for (const NextScan& scan : plan.scans) {
        stood.push_back(scan.positionInWorld);
        const double after = unseenWithin(scanFrom(place, stood), plan.bounds);
        std::printf("   %.2f %.2f %.2f foretold %.2f m3 (%.1f %%), true %.2f, ratio %.2f\n", scan.positionInWorld.x,
                    scan.positionInWorld.y, scan.positionInWorld.z, scan.revealsCubicMetres, 100 * scan.revealsShare,
                    before - after, scan.revealsCubicMetres / (before - after));
        if (ratio == 0) ratio = scan.revealsCubicMetres / (before - after);
        before = after;
    }
    return ratio;
}

/// A room of 8 x 6 x 2.8 m; a wall from the long side hides the far corner from the first scan.
SyntheticScene roomWithHiddenCorner() {
    SyntheticModel model;
    model.name = "hidden corner";
    model.lightSpacing = 2;
    const int m = addMaterial(model, {});
    addRectangle(model, {0, 0, 0}, {8, 0, 0}, {0, 6, 0}, m);
    addRectangle(model, {0, 0, 2.8}, {0, 6, 0}, {8, 0, 0}, m);
    addRectangle(model, {0, 0, 0}, {0, 0, 2.8}, {8, 0, 0}, m);
    addRectangle(model, {0, 6, 0}, {8, 0, 0}, {0, 0, 2.8}, m);
    addRectangle(model, {0, 0, 0}, {0, 6, 0}, {0, 0, 2.8}, m);
    addRectangle(model, {8, 0, 0}, {0, 0, 2.8}, {0, 6, 0}, m);
    addBox(model, Pose{}, {4.9, 2.5, 0}, {5.1, 6, 2.8}, m);
    return SyntheticScene(std::move(model));
}

TEST(NextScan, Tell) {
    tell("hidden", roomWithHiddenCorner(), {{2, 4, 1.5}});
    std::fflush(stdout);
    for (const char* name : {"room", "corridor", "corner"}) {
        const SyntheticScene place = *makeSyntheticScene(name);
        std::vector<glm::dvec3> stood;
        for (const Pose& pose : scanPositions(place)) {
            stood.push_back(pose.translation);
            if (stood.size() <= 1 + (name[2] == 'r')) tell(name, place, stood);
        }
    }
}

} // namespace
} // namespace scene
