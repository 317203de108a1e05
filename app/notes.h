#pragma once
// What a walker notes in a scene: points, and distances between two of them, set on samples that were really seen.
//
// They stand in SCENE/notes.json, which is written whole after every change:
//
//   {"format": "revisit notes", "version": 1, "unit": "m",
//    "notes": [
//      {"number": 1, "kind": "point", "label": "P1", "position": [x, y, z], "known_to_m": 0.002,
//       "made": "2026-10-02T08:32:22Z"},
//      {"number": 2, "kind": "distance", "label": "D2 1.234 m +-0.005", "from": [x, y, z], "to": [x, y, z],
//       "distance_m": 1.234, "known_to_m": 0.005, "made": "2026-10-02T08:32:40Z"}]}
//
// Positions are metres in the world, the capture's own coordinates; known_to_m, where it is known, is one standard
// deviation, of a point within what its own set-up has (app/note_accuracy.h). Notes stand in the order in which they
// were made; their numbers are positive and rise. A label may be changed in the file. Fields and kinds of notes that
// this version does not know are kept as they are. A file of another format or a later version is refused and left
// alone.

#include "scene/pick.h"

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace app {

struct Note {
    enum class Kind { point, distance, other };
    Kind kind = Kind::point;
    int number = 0;
    std::string label;
    glm::dvec3 from{0}, to{0}; ///< metres, world; a point is both
    nlohmann::json fields;     ///< the note as its file has it, or will
};

struct Notes {
    std::vector<Note> list;
    nlohmann::json fields = nlohmann::json::object(); ///< the file's, notes apart
};

/// Throws scene::Failure naming `where` if the text is no notes file of ours.
Notes notesOf(const std::string& text, const std::string& where);
std::string textOf(const Notes& notes);

/// A walker who notes.
struct Noting {
    Notes notes;
    std::size_t older = 0;           ///< of notes, how many stood in the file before this walk: not to be undone
    std::optional<glm::dvec3> start; ///< of a distance whose end is not set yet
};

enum class NoteMode { points, distances };

/// How exactly a place is known, or the distance from it to another; metres, nothing where nobody knows.
using HowExactly =
    std::function<std::optional<double>(const glm::dvec3& place, const std::optional<glm::dvec3>& other)>;

/// The walker has pressed while aiming at a place. What was never seen leaves everything as it is. time: as "made".
Noting press(Noting noting, NoteMode mode, const scene::Pick& aim, const std::string& time,
             const HowExactly& howExactly = {});

/// Takes back the last thing: the start of a distance, else the last note of this walk.
Noting undo(Noting noting);

/// "D2 1.234 m +-0.005"; P where there is no distance.
std::string labelOf(int number, std::optional<double> metres, std::optional<double> knownToMetres = std::nullopt);

/// "1.234 m +-0.005"; "1.234 m" where nobody knows how exactly.
std::string distanceText(double metres, std::optional<double> knownToMetres);

/// Now, in UTC: "2026-10-02T08:32:22Z".
std::string timeNow();

/// The notes of a scene on disk. Writers that come at the same time wait for one another.
class NotesFile {
  public:
    explicit NotesFile(const std::filesystem::path& sceneFolder);

    const std::filesystem::path& path() const { return path_; }

    /// None if there is no file. Throws scene::Failure if it is damaged or of another kind.
    Notes read();

    /// Puts the whole in place by one rename. Throws scene::Failure if it cannot, or if the file is not what was last
    /// read or written: it is then left as it is.
    void write(const Notes& notes);

  private:
    std::optional<std::string> bytesOnDisk() const;

    std::filesystem::path folder_, path_;
    std::optional<std::string> known_; ///< as last read or written; nothing: no file
};

} // namespace app
