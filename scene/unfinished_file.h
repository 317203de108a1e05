#pragma once
// A file that appears under its name when it is whole, and not before.

#include <filesystem>

namespace scene {

inline constexpr const char* kWriteRemedy = "check that the disk has room and the folder may be written";

/// Stands under another name in the same folder until finish(); without it nothing stays.
class UnfinishedFile {
  public:
    explicit UnfinishedFile(std::filesystem::path wanted);
    ~UnfinishedFile();
    UnfinishedFile(const UnfinishedFile&) = delete;
    UnfinishedFile& operator=(const UnfinishedFile&) = delete;

    const std::filesystem::path& path() const { return path_; }
    /// It must have been closed. Throws Failure.
    void finish() const;

  private:
    std::filesystem::path wanted_, path_;
};

} // namespace scene
