#pragma once
// The walker notes points and distances: what is aimed at, what a press makes of it, and how it looks. One object for a
// walk.

#include "app/note_accuracy.h"
#include "app/notes.h"

#include "render/overlay.h"
#include "scene/scene.h"

#include <optional>
#include <string>

namespace app {

/// What the walker wants to note in one frame.
struct NotingWants {
    std::optional<scene::Ray> aim; ///< in the world; none while nothing is aimed at
    NoteMode mode = NoteMode::points;
    bool presses = false, undoes = false; ///< for the one frame in which a button went down
    scene::PickOptions shown{};           ///< what the walker is shown, and may thus aim at
    std::optional<scene::Pick> model{};   ///< where the aim meets a model that stands in the scene
};

class Annotator {
  public:
    /// Reads the notes of that scene folder; scene must outlive it. A file that cannot be read is said by takeNotice,
    /// and then nothing is noted.
    Annotator(const scene::Scene& scene, const std::filesystem::path& sceneFolder);

    /// Looks where the aim meets the scene, does what is wanted and writes the file if notes have changed. Costs a pick
    /// where there is an aim, else next to nothing.
    void update(const NotingWants& wants);

    /// Notes with their labels, what is aimed at, and a distance under way.
    void appendTo(render::Overlay& overlay) const;

    const Notes& notes() const { return noting_.notes; }
    /// Where the aim of the last update met the scene.
    const std::optional<scene::Pick>& aimedAt() const { return aimed_; }

    /// One line to tell the walker, once; empty if there is none.
    std::string takeNotice();

  private:
    void keep();
    void takeBack();

    const scene::Scene& scene_;
    scene::Pose worldFromWalk_;
    NoteAccuracy accuracy_;
    NotesFile file_;
    std::string refused_; ///< why the file is not written; empty if it is
    Noting noting_;
    std::optional<scene::Pick> aimed_;
    std::string notice_;
};

} // namespace app
