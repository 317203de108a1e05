#include "app/scene_folder.h"

#include "app/notes.h"
#include "input/settings.h"
#include "scene/coverage.h"
#include "scene/errors.h"
#include "scene/scene_file.h"
#include "scene/unfinished_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>

namespace app {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kUnfinished = ".part"; ///< of files and folders that were begun (scene/unfinished_file.h)
constexpr const char* kOtherName = "give another name with -o";

bool isWithin(const fs::path& path, const fs::path& folder) {
    std::error_code error;
    const fs::path from = fs::weakly_canonical(folder, error), to = fs::weakly_canonical(path, error);
    if (error) return false;
    const fs::path relative = to.lexically_relative(from);
    return !relative.empty() && *relative.begin() != "..";
}

/// What a build wrote there last; null if it is none of ours.
nlohmann::json manifestOf(const fs::path& folder) {
    std::ifstream file(folder / "scene.json");
    nlohmann::json manifest = nlohmann::json::parse(file, nullptr, false);
    const bool isOurs = manifest.is_object() && manifest.contains("revisit") && manifest["revisit"] == "scene";
    return isOurs ? manifest : nlohmann::json();
}

/// Names of the files that hold the images of a scene; nothing where it does not say.
std::optional<std::set<std::string>> imagesOf(const nlohmann::json& manifest) {
    if (!manifest.is_object()) return std::nullopt;
    std::set<std::string> names;
    for (const char* list : {"images", "held_out"})
        if (const auto found = manifest.find(list); found != manifest.end() && found->is_array())
            for (const nlohmann::json& image : *found)
                if (image.is_object() && image.contains("name") && image["name"].is_string())
                    names.insert(image["name"].get<std::string>() + ".tiff");
    return names;
}

/// As a manifest says it: names of files need not be UTF-8, JSON must.
std::string inManifest(const std::string& name) {
    using nlohmann::json;
    return json::parse(json(name).dump(-1, ' ', false, json::error_handler_t::replace)).get<std::string>();
}

/// What systems leave in any folder.
bool isOfTheSystem(const std::string& name) {
    return name == ".DS_Store" || name == ".directory" || name == "Thumbs.db" || name == "desktop.ini";
}

/// The first, by name, that no build and no walk writes; empty if there is none.
fs::path foreignIn(const fs::path& folder) {
    const std::string notes = NotesFile(folder).path().filename().string();
    const std::optional<std::set<std::string>> images = imagesOf(manifestOf(folder));
    std::vector<fs::path> foreign;
    std::error_code error;
    const auto look = [&](const fs::path& in, const auto& isOurs) {
        for (fs::directory_iterator at(in, error), end; !error && at != end; at.increment(error)) {
            std::string name = at->path().filename().string();
            if (name.ends_with(kUnfinished)) name.resize(name.size() - kUnfinished.size());
            if (!isOurs(*at, name) && !isOfTheSystem(name)) foreign.push_back(at->path().lexically_relative(folder));
        }
    };
    look(folder, [&](const fs::directory_entry& entry, const std::string& name) {
        if (entry.is_directory(error)) return name == "images" || name == scene::kHeldOutFolder;
        return name == "scene.json" || name == "tiles.bin" || name == scene::kCoverageFile ||
               name == input::kStartFile || name == notes;
    });
    for (const fs::path& in : {folder / "images", folder / scene::kHeldOutFolder})
        if (fs::is_directory(in, error))
            look(in, [&](const fs::directory_entry& entry, const std::string& name) {
                return entry.is_regular_file(error) &&
                       (images ? images->contains(inManifest(name)) : name.ends_with(".tiff"));
            });
    return foreign.empty() ? fs::path() : *std::min_element(foreign.begin(), foreign.end());
}

void checkFolder(const fs::path& folder, std::span<const fs::path> inputs) {
    for (const fs::path& input : inputs)
        if (isWithin(input, folder))
            throw scene::Failure("would be lost: it lies in the folder that the scene is put in place of", input,
                                 std::string("move it elsewhere, or ") + kOtherName);
    if (const fs::path foreign = foreignIn(folder); !foreign.empty())
        throw scene::Failure("holds " + foreign.string() + ", which is no part of a scene and would be lost", folder,
                             std::string("move it elsewhere, or ") + kOtherName);
}

/// What is mounted cannot be renamed.
bool isMountPoint(const fs::path& folder) {
    struct statx own {
    }, parent{};
    if (statx(AT_FDCWD, folder.c_str(), 0, STATX_TYPE, &own) != 0) return false;
    if ((own.stx_attributes & STATX_ATTR_MOUNT_ROOT) != 0) return true; // of the same disk, too
    if (statx(AT_FDCWD, (folder / "..").c_str(), 0, STATX_TYPE, &parent) != 0) return false;
    return own.stx_dev_major != parent.stx_dev_major || own.stx_dev_minor != parent.stx_dev_minor;
}

scene::Failure notExchanged(const fs::path& output, int error) {
    return {std::string("cannot be exchanged for the new scene (") + std::strerror(error) + ")", output,
            "remove the old scene, or give another name with -o"};
}

void putWhereNothingIs(const fs::path& part, const fs::path& output) {
    if (::rename(part.c_str(), output.c_str()) != 0)
        throw scene::Failure(std::string("cannot be renamed into place (") + std::strerror(errno) + ")", output,
                             scene::kWriteRemedy);
}

/// In two steps; where the second fails the older scene is put back.
void putInPlaceOfMoved(const fs::path& part, const fs::path& output) {
    std::string aside = output.string() + ".old-XXXXXX";
    if (mkdtemp(aside.data()) == nullptr) throw notExchanged(output, errno);
    const fs::path older = fs::path(aside) / output.filename();
    std::error_code ignored;
    if (::rename(output.c_str(), older.c_str()) != 0) {
        const int error = errno;
        fs::remove(aside, ignored);
        throw notExchanged(output, error);
    }
    try {
        putWhereNothingIs(part, output);
    } catch (...) {
        if (::rename(older.c_str(), output.c_str()) != 0)
            throw scene::Failure("neither the new scene nor the older one can be put there", output,
                                 "move the older one back from " + older.string());
        fs::remove(aside, ignored);
        throw;
    }
    fs::remove_all(aside, ignored);
}

} // namespace

fs::path unfinishedSceneOf(const fs::path& output) {
    fs::path part = output;
    part += kUnfinished;
    return part;
}

void checkReplaceable(const fs::path& output, std::span<const fs::path> inputs) {
    std::error_code ignored;
    const fs::path part = unfinishedSceneOf(output);
    if (fs::is_directory(part, ignored))
        checkFolder(part, inputs);
    else if (fs::exists(part, ignored))
        throw scene::Failure("is in the way of the scene that is to be made beside it", part,
                             std::string("move it elsewhere, or ") + kOtherName);
    if (!fs::exists(output, ignored)) {
        if (fs::is_symlink(fs::symlink_status(output, ignored)))
            throw scene::Failure("is a link to what does not exist", output, kOtherName);
        return;
    }
    if (isMountPoint(output))
        throw scene::Failure("is where a disk is mounted, and no other folder can be put in its place", output,
                             "name a folder inside it with -o");
    const bool isScene =
        fs::is_directory(output, ignored) && (!manifestOf(output).is_null() || fs::is_empty(output, ignored));
    if (!isScene)
        throw scene::Failure("exists and is no scene", output,
                             std::string(kOtherName) + ", or move it away if it was one and is damaged");
    checkFolder(output, inputs);
}

fs::path placeOfScene(const fs::path& output) {
    fs::path place = fs::absolute(output).lexically_normal();
    if (!place.has_filename()) place = place.parent_path();
    std::error_code error;
    if (!fs::is_symlink(fs::symlink_status(place, error))) return place;
    const fs::path end = fs::canonical(place, error);
    return error ? place : end; // what leads nowhere is refused
}

void putInPlace(const fs::path& part, const fs::path& output) {
    std::error_code ignored;
    if (!fs::exists(output, ignored)) return putWhereNothingIs(part, output);
    if (renameat2(AT_FDCWD, part.c_str(), AT_FDCWD, output.c_str(), RENAME_EXCHANGE) == 0) {
        fs::remove_all(part, ignored);
        return;
    }
    if (errno == EINVAL || errno == ENOSYS) return putInPlaceOfMoved(part, output);
    throw notExchanged(output, errno);
}

} // namespace app
