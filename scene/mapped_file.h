#pragma once
// A file read through memory: nothing is copied, and what is not looked at is not loaded.

#include <cstddef>
#include <filesystem>
#include <span>
#include <utility>

namespace scene {

/// Throws Failure if the file cannot be opened or mapped.
class MappedFile {
  public:
    MappedFile() = default;
    explicit MappedFile(const std::filesystem::path& path);
    MappedFile(MappedFile&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}
    MappedFile& operator=(MappedFile&& other) noexcept {
        std::swap(bytes_, other.bytes_);
        return *this;
    }
    ~MappedFile();
    std::span<const std::byte> bytes() const { return bytes_; }

  private:
    std::span<const std::byte> bytes_;
};

} // namespace scene
