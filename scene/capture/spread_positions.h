#pragma once
// Reference positions by no more than spreading them: the baseline that every search for better ones has to beat.
//
// Candidates stand at eye height over every floor on a grid; those that keep clear of surfaces, are in no solid, and
// see surfaces nearly all round are spread by taking the farthest from those taken (T. Gonzalez, "Clustering to
// minimize the maximum intercluster distance", 1985), then each moves to the middle of what is nearest to it (S. Lloyd,
// "Least squares quantization in PCM", 1982).

#include "scene/capture/tracer.h"

#include <vector>

namespace scene {

struct SpreadOptions {
    double eyeMetres = 1.6;       ///< above the floor; in scenes that are lower, half of their height
    double clearanceMetres = 0.3; ///< to the nearest surface
    int gridAcross = 64;          ///< columns of candidates along the longer side
    /// Candidates see surfaces in at least this share of the level looks, compared with the one
    /// that sees most: roofs and what is outside of a building see less.
    double seenShare = 0.6;
    /// Of a room, which is what one gets to without passing through surfaces, at least this share of the number of
    /// triangles is seen that the richest shows: gaps between walls show less.
    double richShare = 0.2;
};

/// All candidates, in the world; the first is the one with the widest look. A function of the scene alone. Throws
/// Failure if there are none.
std::vector<glm::dvec3> standingPlaces(const PolygonTracer& tracer, const SpreadOptions& options = {});

/// As many positions, in the world (+Y up); the first is the one with the widest look, where a walk may begin. A
/// function of the scene alone. Throws Failure if the scene has not so much free space. count > 0.
std::vector<glm::dvec3> spreadPositions(const PolygonTracer& tracer, int count, const SpreadOptions& options = {});

} // namespace scene
