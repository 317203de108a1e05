#pragma once
// What the stages of a build leave behind, kept under keys made of their input and options: a build that was killed
// goes on where it was, and a changed option redoes only what depends on it. The folder may be removed at any time.

#include <nlohmann/json.hpp>

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace app {

/// 32 hexadecimal digits of XXH3-128 over the JSON as CBOR (objects are sorted by name; strings may be any bytes).
std::string keyOf(const nlohmann::json& inputAndOptions);

/// A file or folder of which a stage's result depends: path, size and time of last change.
nlohmann::json fingerprintOf(const std::filesystem::path& file);

enum class Lock {
    held,
    ofAnother, ///< who was not waited for
    none,      ///< the file system has none: one goes on without
};
/// What flock says of an open file or folder; how: as flock has it. Throws scene::Failure where it fails otherwise.
Lock takeLock(int descriptor, int how, const std::filesystem::path& where);

class StageStore {
  public:
    /// What a build that was killed left unfinished is removed, unless the file system has no locks. Throws
    /// scene::Failure if the folder cannot be made or another build uses it.
    explicit StageStore(std::filesystem::path folder);
    ~StageStore();
    StageStore(const StageStore&) = delete;
    StageStore& operator=(const StageStore&) = delete;

    /// FOLDER/STAGE-KEY, made if it is not there: for stages that keep a file for each item.
    std::filesystem::path folderOf(const std::string& stage, const std::string& key);

    /// The folder of a result that consists of several files; if it is not there, `make` fills a temporary one, which
    /// gets the name when it is whole.
    std::filesystem::path find(const std::string& stage, const std::string& key,
                               const std::function<void(const std::filesystem::path&)>& make);

    const std::filesystem::path& folder() const { return folder_; }

    /// Whether it held results of earlier builds when it was opened.
    bool hasOlder() const { return hasOlder_; }

  private:
    void lookAround(bool removeUnfinished);

    std::filesystem::path folder_;
    int lock_ = -1;
    bool hasOlder_ = false;
};

/// Where a file of that name really is, or would be; the name itself if it is no link.
std::filesystem::path endOfLinks(const std::filesystem::path& file);

/// Writes under a temporary name and renames: whole or not there. A link is followed; what is no file is written to.
/// Throws scene::Failure.
void writeWhole(const std::filesystem::path& wanted, std::span<const std::byte> bytes);
void writeWhole(const std::filesystem::path& path, const std::string& text);
std::vector<std::byte> readWhole(const std::filesystem::path& path);
/// What a stage wrote of itself; a damaged one is a Failure that says to remove it.
nlohmann::json readJson(const std::filesystem::path& path);

} // namespace app
