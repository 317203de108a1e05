#pragma once
// Planes that somebody says two scans share: a file for --register, where scans cannot find it out themselves.
//
//   {"matches": [{"a": "scan1", "b": "scan2",
//                 "planes": [{"a": [x, y, z], "b": [x, y, z]}, ...]}, ...]}
//
// For each plane a place on it in either scan, metres in that scanner's own frame; at least three planes that face
// three ways (Nyland et al. 1999, section 4.1, had a person pick as many).

#include "scene/align/register_pair.h"

#include <filesystem>
#include <utility>
#include <vector>

namespace scene {

struct GivenMatches {
    std::size_t a = 0, b = 0; ///< indices of scans
    std::vector<std::pair<glm::dvec3, glm::dvec3>> places;
};

/// Throws Failure: not JSON, not of that form, names that no scan has.
std::vector<GivenMatches> readMatchesFile(const std::filesystem::path& path, const std::vector<std::string>& scanNames);

/// The pair as the matches have it, made exact. Throws Failure about `path` where a place is on no plane or the planes
/// leave the pose open.
PairResult pairFromMatches(const std::vector<ScanView>& scans, const GivenMatches& matches, const PairOptions& options,
                           const std::filesystem::path& path);

} // namespace scene
