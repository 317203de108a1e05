#include "app/stage_store.h"

#include "app/say.h"
#include "scene/errors.h"
#include "scene/unfinished_file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>
#include <xxhash.h>

namespace app {

namespace {

constexpr const char* kUnfinishedStage = ".part"; ///< of files and folders that were begun (scene/unfinished_file.h)

std::filesystem::path withSuffix(std::filesystem::path path, const char* suffix) {
    path += suffix;
    return path;
}

void makeFolder(const std::filesystem::path& folder) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) throw scene::Failure("cannot be made (" + error.message() + ")", folder, scene::kWriteRemedy);
}

void moveInto(const std::filesystem::path& from, const std::filesystem::path& to) {
    std::error_code error;
    std::filesystem::rename(from, to, error);
    if (error) throw scene::Failure("cannot be renamed into place (" + error.message() + ")", to, scene::kWriteRemedy);
}

bool endsWith32Digits(const std::string& name) {
    constexpr std::size_t kDigits = 32;
    return name.size() > kDigits && name[name.size() - kDigits - 1] == '-' &&
           name.find_first_not_of("0123456789abcdef", name.size() - kDigits) == std::string::npos;
}

} // namespace

std::string keyOf(const nlohmann::json& inputAndOptions) {
    // JSON's text would refuse file names that are not UTF-8.
    const std::vector<std::uint8_t> bytes = nlohmann::json::to_cbor(inputAndOptions);
    const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
    char hex[33];
    std::snprintf(hex, sizeof hex, "%016llx%016llx", static_cast<unsigned long long>(hash.high64),
                  static_cast<unsigned long long>(hash.low64));
    return hex;
}

nlohmann::json fingerprintOf(const std::filesystem::path& file) {
    std::error_code error;
    const auto size = std::filesystem::file_size(file, error);
    const auto time = std::filesystem::last_write_time(file, error);
    return {std::filesystem::absolute(file).string(), error ? 0 : size, error ? 0 : time.time_since_epoch().count()};
}

Lock takeLock(int descriptor, int how, const std::filesystem::path& where) {
    while (flock(descriptor, how) != 0) {
        const int error = errno;
        if (error == EWOULDBLOCK) return Lock::ofAnother;
        if (error == ENOLCK || error == ENOSYS || error == EOPNOTSUPP) return Lock::none; // as of some networks
        if (error != EINTR)
            throw scene::Failure(std::string("cannot be locked (") + std::strerror(error) + ")", where,
                                 "check the disk, or keep the scene on another");
    }
    return Lock::held;
}

StageStore::StageStore(std::filesystem::path folder) : folder_(std::move(folder)) {
    makeFolder(folder_);
    const std::filesystem::path lockFile = folder_ / "lock";
    lock_ = open(lockFile.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (lock_ < 0) throw scene::Failure("cannot be written", lockFile, scene::kWriteRemedy);
    try {
        const Lock lock = takeLock(lock_, LOCK_EX | LOCK_NB, lockFile);
        if (lock == Lock::ofAnother)
            throw scene::Failure("another build is writing this scene", folder_,
                                 "wait for it to end, or give another name with -o");
        if (lock == Lock::none)
            sayNote(folder_.string() +
                    ": its file system has no locks: see to it that no other build writes this scene");
        lookAround(lock == Lock::held);
    } catch (...) {
        close(lock_);
        throw;
    }
}

StageStore::~StageStore() {
    close(lock_);
}

void StageStore::lookAround(bool removeUnfinished) {
    std::vector<std::filesystem::path> unfinished;
    const auto look = [](const std::filesystem::path& in, const auto& take) {
        std::error_code error;
        for (std::filesystem::directory_iterator at(in, error), end; !error && at != end; at.increment(error))
            take(*at);
    };
    look(folder_, [&](const std::filesystem::directory_entry& entry) {
        // Nothing of another hand.
        const bool isUnfinished = entry.path().extension() == kUnfinishedStage;
        const std::filesystem::path name = isUnfinished ? entry.path().stem() : entry.path().filename();
        if (!endsWith32Digits(name.string())) return;
        if (isUnfinished) return unfinished.push_back(entry.path());
        hasOlder_ = true;
        look(entry.path(), [&](const std::filesystem::directory_entry& file) {
            if (file.path().extension() == kUnfinishedStage) unfinished.push_back(file.path());
        });
    });
    if (!removeUnfinished) return;
    std::error_code ignored;
    for (const std::filesystem::path& path : unfinished)
        std::filesystem::remove_all(path, ignored);
}

std::filesystem::path StageStore::folderOf(const std::string& stage, const std::string& key) {
    const std::filesystem::path folder = folder_ / (stage + "-" + key);
    makeFolder(folder);
    return folder;
}

std::filesystem::path StageStore::find(const std::string& stage, const std::string& key,
                                       const std::function<void(const std::filesystem::path&)>& make) {
    const std::filesystem::path folder = folder_ / (stage + "-" + key);
    std::error_code ignored;
    if (std::filesystem::exists(folder, ignored)) return folder;
    const std::filesystem::path part = withSuffix(folder, kUnfinishedStage);
    std::filesystem::remove_all(part, ignored);
    makeFolder(part);
    try {
        make(part);
    } catch (...) {
        std::filesystem::remove_all(part, ignored);
        throw;
    }
    moveInto(part, folder);
    return folder;
}

std::filesystem::path endOfLinks(const std::filesystem::path& file) {
    constexpr int kMostLinks = 40; // as the system follows
    std::filesystem::path path = file;
    std::error_code error;
    for (int i = 0; i < kMostLinks && std::filesystem::is_symlink(std::filesystem::symlink_status(path, error)); ++i)
        path = path.parent_path() / std::filesystem::read_symlink(path, error);
    return path;
}

void writeWhole(const std::filesystem::path& wanted, std::span<const std::byte> bytes) {
    std::error_code error;
    const std::filesystem::file_status there = std::filesystem::status(wanted, error);
    // A link stays one, and what is no file, as a pipe or a device, is written to as it is.
    const bool isFile = !std::filesystem::exists(there) || std::filesystem::is_regular_file(there) ||
                        std::filesystem::is_directory(there);
    const std::filesystem::path path = isFile ? endOfLinks(wanted) : wanted;
    const std::filesystem::path part = isFile ? withSuffix(path, kUnfinishedStage) : path;
    std::ofstream file(part, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!isFile) {
        if (!file) throw scene::Failure("cannot be written to", path, "name a file");
        return;
    }
    try {
        if (!file) throw scene::Failure("cannot be written", path, scene::kWriteRemedy);
        moveInto(part, path);
    } catch (...) {
        std::error_code ignored;
        std::filesystem::remove(part, ignored);
        throw;
    }
}

void writeWhole(const std::filesystem::path& path, const std::string& text) {
    writeWhole(path, std::as_bytes(std::span(text)));
}

std::vector<std::byte> readWhole(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    if (!file) throw scene::Failure("cannot be opened", path, "check that it is readable");
    std::vector<std::byte> bytes(static_cast<std::size_t>(file.tellg()));
    file.seekg(0);
    file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (!file) throw scene::Failure("cannot be read", path, "check the disk");
    return bytes;
}

nlohmann::json readJson(const std::filesystem::path& path) {
    const std::vector<std::byte> bytes = readWhole(path);
    const char* text = reinterpret_cast<const char*>(bytes.data());
    try {
        return nlohmann::json::parse(text, text + bytes.size());
    } catch (const nlohmann::json::exception&) {
        throw scene::Failure("is damaged", path, "remove the folder it is in and build again");
    }
}

} // namespace app
