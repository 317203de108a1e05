#include "scene/import/polygon_files.h"

#include <algorithm>
#include <cstdio>
#include <fstream>

namespace scene {

namespace {

class FileStream : public Assimp::IOStream {
  public:
    FileStream(const std::filesystem::path& path, std::set<Assimp::IOStream*>& open)
        : file_(path, std::ios::binary), size_(static_cast<std::size_t>(std::filesystem::file_size(path))),
          open_(open) {
        open_.insert(this);
    }
    ~FileStream() override { open_.erase(this); }
    FileStream(const FileStream&) = delete;
    FileStream& operator=(const FileStream&) = delete;

    std::size_t Read(void* to, std::size_t size, std::size_t count) override {
        if (size == 0 || count == 0) return 0;
        const std::size_t whole = std::min(count, (size_ - std::min(size_, Tell())) / size);
        file_.read(static_cast<char*>(to), static_cast<std::streamsize>(whole * size));
        return static_cast<std::size_t>(file_.gcount()) / size;
    }
    std::size_t Write(const void*, std::size_t, std::size_t) override { return 0; }
    aiReturn Seek(std::size_t offset, aiOrigin origin) override {
        const std::size_t base = origin == aiOrigin_SET ? 0 : origin == aiOrigin_CUR ? Tell() : size_;
        const std::size_t place = base + offset; // wraps for negative offsets, as Assimp means them
        if (place > size_) return aiReturn_FAILURE;
        file_.clear();
        file_.seekg(static_cast<std::streamoff>(place));
        return file_ ? aiReturn_SUCCESS : aiReturn_FAILURE;
    }
    std::size_t Tell() const override { return static_cast<std::size_t>(std::max<std::streamoff>(file_.tellg(), 0)); }
    std::size_t FileSize() const override { return size_; }
    void Flush() override {}

  private:
    mutable std::ifstream file_; // to ask where it stands is no change
    std::size_t size_;
    std::set<Assimp::IOStream*>& open_;
};

} // namespace

std::filesystem::path findWithin(const std::filesystem::path& folder, std::string named) {
    std::replace(named.begin(), named.end(), '\\', '/');
    std::error_code error;
    const std::filesystem::path root = std::filesystem::weakly_canonical(folder, error);
    if (error) return {};
    const std::filesystem::path path = std::filesystem::weakly_canonical(root / named, error);
    if (error) return {};
    const auto [rootEnd, ignored] = std::mismatch(root.begin(), root.end(), path.begin(), path.end());
    return rootEnd == root.end() ? path : std::filesystem::path();
}

PolygonFiles::~PolygonFiles() {
    while (!streams_.empty())
        delete *streams_.begin();
}

bool PolygonFiles::Exists(const char* path) const {
    std::error_code error;
    const std::filesystem::path found = findWithin(folder_, path);
    return !found.empty() && std::filesystem::is_regular_file(found, error);
}

Assimp::IOStream* PolygonFiles::Open(const char* path, const char* mode) {
    if (mode[0] != 'r') return nullptr;
    if (!Exists(path)) {
        refused_.emplace_back(path);
        return nullptr;
    }
    const std::filesystem::path found = findWithin(folder_, path);
    // Files are opened again, to see what they are.
    if (std::find(opened_.begin(), opened_.end(), found) == opened_.end()) opened_.push_back(found);
    return new FileStream(found, streams_);
}

void PolygonFiles::Close(Assimp::IOStream* stream) {
    delete stream;
}

} // namespace scene
