#pragma once
// How exactly places and distances that a walker notes are known: by how far apart samples stand there, how much they
// scatter, and, between places that different set-ups saw, how far apart those have what both show.

#include "scene/samples_about.h"
#include "scene/scene.h"

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace app {

/// Metres, one standard deviation; nothing where a scene does not tell. What a scanner measures wrong everywhere, its
/// scale, say, is not in it.
class NoteAccuracy {
  public:
    /// The scene is lent. One whose manifest tells nothing of its poses knows places, and distances within a set-up.
    explicit NoteAccuracy(const scene::Scene& scene);

    std::optional<double> ofPlace(const glm::dvec3& place) const;
    std::optional<double> ofDistance(const glm::dvec3& from, const glm::dvec3& to) const;

  private:
    std::optional<double> between(const scene::SamplesAbout& a, const scene::SamplesAbout& b) const;

    const scene::Scene& scene_;
    bool isExact_ = false;               ///< ray-traced: its poses are those of its images
    std::optional<double> surfaceShare_; ///< photographs: of range, that surfaces of two of them lie apart
    std::map<std::pair<std::string, std::string>, double> apartMetres_; ///< scans, in the order of their names
    std::map<std::string, std::pair<std::string, double>> deviations_;  ///< of registered scans: group, and metres
};

} // namespace app
