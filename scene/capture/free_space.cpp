#include "scene/capture/free_space.h"

#include "scene/directions.h"
#include "scene/errors.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include <tbb/parallel_for.h>

namespace scene {

Surroundings lookRound(const PolygonTracer& tracer, const glm::dvec3& positionInWorld, int looks) {
    Surroundings about;
    about.nearestMetres = std::numeric_limits<double>::infinity();
    int hits = 0, backs = 0, level = 0, levelHits = 0;
    for (const glm::dvec3& direction : spreadDirections(looks)) {
        const std::optional<PolygonHit> hit = tracer.cast(positionInWorld, direction);
        const bool isLevel = std::abs(direction.y) <= kLevelSine;
        level += isLevel;
        if (!hit) continue;
        ++hits;
        backs += hit->isBack;
        levelHits += isLevel;
        about.nearestMetres = std::min(about.nearestMetres, hit->t);
        about.meanMetres += hit->t;
    }
    about.hitShare = static_cast<double>(hits) / looks;
    about.backShare = static_cast<double>(backs) / looks;
    about.levelShare = level > 0 ? static_cast<double>(levelHits) / level : 0.0;
    if (hits > 0) about.meanMetres /= hits;
    return about;
}

void checkPositions(const PolygonTracer& tracer, std::span<const glm::dvec3> positionsInWorld,
                    const std::filesystem::path& where) {
    std::vector<Surroundings> about(positionsInWorld.size());
    tbb::parallel_for(std::size_t{0}, about.size(),
                      [&](std::size_t i) { about[i] = lookRound(tracer, positionsInWorld[i]); });
    for (std::size_t i = 0; i < about.size(); ++i) {
        const glm::dvec3& p = positionsInWorld[i];
        char name[128];
        std::snprintf(name, sizeof name, "position %zu (%.6g %.6g %.6g) ", i, p.x, p.y, p.z);
        if (about[i].hitShare == 0)
            throw Failure(std::string(name) + "sees nothing: it is outside of everything", where,
                          "move it into the scene, or remove it");
        if (!isInsideSolid(about[i])) continue;
        char why[160];
        std::snprintf(why, sizeof why,
                      "is inside a solid: %.0f %% of the looks round end at the back of a surface, the nearest %.3g m "
                      "away",
                      100 * about[i].backShare, about[i].nearestMetres);
        throw Failure(std::string(name) + why, where, "move it into free space, or remove it");
    }
}

} // namespace scene
