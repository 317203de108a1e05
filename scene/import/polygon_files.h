#pragma once
// The files that a polygon scene names: only those in its own folder or below are read, and which were is remembered.

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>

namespace scene {

/// The file that `named` (a path as other programs write it, with either slash) means, seen from `folder`; empty if it
/// leads out of that folder, links followed.
std::filesystem::path findWithin(const std::filesystem::path& folder, std::string named);

/// What Assimp opens files by.
class PolygonFiles : public Assimp::IOSystem {
  public:
    explicit PolygonFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}
    ~PolygonFiles() override;
    PolygonFiles(const PolygonFiles&) = delete;
    PolygonFiles& operator=(const PolygonFiles&) = delete;

    bool Exists(const char* path) const override;
    char getOsSeparator() const override { return '/'; }
    Assimp::IOStream* Open(const char* path, const char* mode) override;
    void Close(Assimp::IOStream* stream) override;

    const std::vector<std::filesystem::path>& opened() const { return opened_; }
    const std::vector<std::string>& refused() const { return refused_; } ///< lead out of the folder, or are not there

  private:
    std::filesystem::path folder_;
    std::set<Assimp::IOStream*> streams_; ///< that are open: Assimp closes some, deletes others, and forgets the rest
    std::vector<std::filesystem::path> opened_;
    std::string extension_; ///< of the first, by the name that it was asked for
    std::vector<std::string> refused_;
};

} // namespace scene
