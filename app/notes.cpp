#include "app/notes.h"

#include "app/stage_store.h"
#include "scene/errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <limits>

#include <glm/geometric.hpp>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

namespace app {

namespace {

using nlohmann::json;

constexpr const char* kFormat = "revisit notes";
constexpr int kVersion = 1;

json describe(const glm::dvec3& p) {
    return {p.x, p.y, p.z};
}

glm::dvec3 readPlace(const json& from, const char* field, const std::string& where) {
    const auto values = from.at(field).get<std::vector<double>>();
    if (values.size() != 3 || !std::isfinite(values[0]) || !std::isfinite(values[1]) || !std::isfinite(values[2]))
        throw scene::Failure(std::string(field) + " is no place", where, "give three finite numbers, in metres");
    return {values[0], values[1], values[2]};
}

Note readNote(const json& from, const std::string& where) {
    Note note;
    note.fields = from;
    try {
        const auto number = from.at("number").get<double>();
        if (!(number >= 1 && number < std::numeric_limits<int>::max() && number == std::floor(number)))
            throw scene::Failure("has a number that cannot be one", where, "number notes 1, 2, ...");
        note.number = static_cast<int>(number);
        const auto kind = from.at("kind").get<std::string>();
        note.kind = kind == "point" ? Note::Kind::point : kind == "distance" ? Note::Kind::distance : Note::Kind::other;
        if (note.kind == Note::Kind::other) return note;
        note.label = from.at("label").get<std::string>();
        if (note.kind == Note::Kind::point) {
            note.from = note.to = readPlace(from, "position", where);
        } else {
            note.from = readPlace(from, "from", where), note.to = readPlace(from, "to", where);
        }
    } catch (const json::exception& e) {
        throw scene::Failure(std::string("lacks something or has it wrong (") + e.what() + ")", where,
                             "correct it, or move the file away");
    }
    return note;
}

/// Held while a file in a folder is compared and replaced; the system lets go of it whatever becomes of us.
class FolderLock {
  public:
    explicit FolderLock(const std::filesystem::path& folder)
        : descriptor_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
        if (descriptor_ < 0) throw scene::Failure("cannot be opened", folder, "check that the scene is still there");
        try {
            takeLock(descriptor_, LOCK_EX, folder);
        } catch (...) {
            close(descriptor_);
            throw;
        }
    }
    ~FolderLock() { close(descriptor_); }
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

  private:
    int descriptor_;
};

Note makeNote(const Notes& notes, std::optional<glm::dvec3> from, const glm::dvec3& to, const std::string& time,
              const HowExactly& howExactly) {
    constexpr double kFinest = 0.001; // metres: no more is claimed than is shown
    std::optional<double> knownTo = howExactly ? howExactly(to, from) : std::nullopt;
    if (knownTo) knownTo = std::max(*knownTo, kFinest);
    Note note;
    for (const Note& other : notes.list)
        note.number = std::max(note.number, other.number);
    ++note.number;
    note.to = to;
    note.from = from.value_or(to);
    note.fields = {{"number", note.number}, {"made", time}};
    if (from) {
        const double metres = glm::distance(*from, to);
        note.kind = Note::Kind::distance;
        note.label = labelOf(note.number, metres, knownTo);
        note.fields.update(
            {{"kind", "distance"}, {"from", describe(*from)}, {"to", describe(to)}, {"distance_m", metres}});
    } else {
        note.label = labelOf(note.number, std::nullopt);
        note.fields.update({{"kind", "point"}, {"position", describe(to)}});
    }
    note.fields["label"] = note.label;
    if (knownTo) note.fields["known_to_m"] = *knownTo;
    return note;
}

} // namespace

Notes notesOf(const std::string& text, const std::string& where) {
    json root;
    try {
        root = json::parse(text);
    } catch (const json::exception&) {
        throw scene::Failure("is damaged", where, "repair it or move it away; it is left as it is");
    }
    if (!root.is_object() || root.value("format", json()) != kFormat || !root.contains("notes") ||
        !root["notes"].is_array())
        throw scene::Failure("holds no notes of this program", where, "move it away; it is left as it is");
    if (root.value("version", json()) != kVersion || root.value("unit", json()) != "m")
        throw scene::Failure("is of a version this program does not know", where,
                             "use the program that wrote it; it is left as it is");
    Notes notes;
    for (std::size_t i = 0; i < root["notes"].size(); ++i)
        notes.list.push_back(readNote(root["notes"][i], where + ", note " + std::to_string(i)));
    root.erase("notes");
    notes.fields = std::move(root);
    return notes;
}

std::string textOf(const Notes& notes) {
    json root = notes.fields;
    root["format"] = kFormat, root["version"] = kVersion, root["unit"] = "m";
    root["notes"] = json::array();
    for (const Note& note : notes.list)
        root["notes"].push_back(note.fields);
    return root.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

Noting press(Noting noting, NoteMode mode, const scene::Pick& aim, const std::string& time,
             const HowExactly& howExactly) {
    if (!aim.isSeen) return noting;
    if (mode == NoteMode::distances && !noting.start) {
        noting.start = aim.position;
        return noting;
    }
    const std::optional<glm::dvec3> from = mode == NoteMode::distances ? noting.start : std::nullopt;
    noting.notes.list.push_back(makeNote(noting.notes, from, aim.position, time, howExactly));
    noting.start.reset();
    return noting;
}

Noting undo(Noting noting) {
    if (noting.start)
        noting.start.reset();
    else if (noting.notes.list.size() > noting.older)
        noting.notes.list.pop_back();
    return noting;
}

std::string labelOf(int number, std::optional<double> metres, std::optional<double> knownToMetres) {
    if (!metres) return "P" + std::to_string(number);
    return "D" + std::to_string(number) + " " + distanceText(*metres, knownToMetres);
}

std::string distanceText(double metres, std::optional<double> knownToMetres) {
    std::array<char, 64> text{};
    if (knownToMetres)
        std::snprintf(text.data(), text.size(), "%.3f m +-%.3f", metres, *knownToMetres);
    else
        std::snprintf(text.data(), text.size(), "%.3f m", metres);
    return text.data();
}

std::string timeNow() {
    const std::time_t now = std::time(nullptr);
    std::tm utc{};
    gmtime_r(&now, &utc);
    std::array<char, 32> text{};
    std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
    return text.data();
}

NotesFile::NotesFile(const std::filesystem::path& sceneFolder)
    : folder_(sceneFolder), path_(sceneFolder / "notes.json") {}

std::optional<std::string> NotesFile::bytesOnDisk() const {
    std::error_code ignored;
    if (!std::filesystem::exists(path_, ignored)) return std::nullopt;
    if (!std::filesystem::is_regular_file(path_, ignored)) throw scene::Failure("is no file", path_, "move it away");
    const std::vector<std::byte> bytes = readWhole(path_);
    return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

Notes NotesFile::read() {
    const std::optional<std::string> text = bytesOnDisk();
    const Notes notes = text ? notesOf(*text, path_.string()) : Notes{};
    known_ = text;
    return notes;
}

void NotesFile::write(const Notes& notes) {
    const FolderLock lock(folder_);
    if (bytesOnDisk() != known_)
        throw scene::Failure("was changed by another program", path_,
                             "it is left as it is; end this walk and start it again to go on noting");
    const std::string text = textOf(notes);
    writeWhole(path_, text);
    known_ = text;
}

} // namespace app
