#pragma once
// How exactly places and distances that a walker notes are known: by how far apart samples stand there, how much they
// scatter, and, between places that different set-ups saw, how far apart those have what both show.

#include "scene/samples_about.h"
#include "scene/scene.h"

#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

namespace app {

/// Metres, one standard deviation; nothing where a scene does not tell. What is not in it: what a scanner measures
/// wrong everywhere (its scale), or smoothly over many samples; and of scans whose poses are as given how far they may
/// have slid along what both show.
class NoteAccuracy {
  public:
    /// The scene is lent. One whose manifest tells nothing of its poses knows places, and distances within a set-up.
    explicit NoteAccuracy(const scene::Scene& scene);

    /// Within what the set-up has that saw it.
    std::optional<double> ofPlace(const glm::dvec3& place) const;
    std::optional<double> ofDistance(const glm::dvec3& from, const glm::dvec3& to) const;

  private:
    struct Registered {
        std::string group;
        double metres = 0, radians = 0; ///< deviation of its pose
    };
    struct End {
        glm::dvec3 place;
        scene::SamplesAbout about;
    };

    std::optional<double> between(const End& a, const End& b) const;
    std::optional<double> betweenScans(const std::string& a, const std::string& b, const End& atA,
                                       const End& atB) const;
    std::optional<double> betweenPhotographs(const End& a, const End& b) const;

    const scene::Scene& scene_;
    bool isExact_ = false;               ///< ray-traced: its poses are those of its images
    std::optional<double> surfaceShare_; ///< photographs: of range, that surfaces of two of them lie apart
    std::set<std::string> loose_;        ///< photographs that others do not say the place of
    std::map<std::pair<std::string, std::string>, double> apartMetres_; ///< scans, in the order of their names
    std::map<std::string, Registered> registered_;
};

} // namespace app
