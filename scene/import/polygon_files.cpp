#include "scene/import/polygon_files.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <fstream>
#include <string>

namespace scene {

namespace {

/// Where a file of materials first names one, as Assimp knows it: by a line whose first word begins so. The file's end
/// if it never does.
std::size_t firstMaterialIn(const std::filesystem::path& path, std::size_t size) {
    std::ifstream file(path, std::ios::binary);
    std::string head(3, '\0');
    file.read(head.data(), 3);
    head.resize(static_cast<std::size_t>(file.gcount()));
    if (head.starts_with("\xff\xfe") || head.starts_with("\xfe\xff")) return 0; // of wider characters
    const std::size_t first = head == "\xef\xbb\xbf" ? 3 : 0;
    file.clear();
    file.seekg(static_cast<std::streamoff>(first));
    bool isAtFirstWord = true;
    for (std::size_t at = first; at < size; ++at) {
        const int c = file.get();
        if (c == '\n' || c == '\r') isAtFirstWord = true;
        if (c == ' ' || c == '\t' || c == '\n' || c == '\r') continue;
        if (isAtFirstWord && (c == 'n' || c == 'N') && file.peek() == 'e') return at;
        isAtFirstWord = false;
    }
    return size;
}

class FileStream : public Assimp::IOStream {
  public:
    FileStream(const std::filesystem::path& path, bool isMaterials, std::set<Assimp::IOStream*>& open)
        : file_(path, std::ios::binary), size_(static_cast<std::size_t>(std::filesystem::file_size(path))),
          open_(open) {
        // What stands before the first material belongs to none: Assimp writes it through a null pointer.
        if (isMaterials) blankUpTo_ = firstMaterialIn(path, size_);
        open_.insert(this);
    }
    ~FileStream() override { open_.erase(this); }
    FileStream(const FileStream&) = delete;
    FileStream& operator=(const FileStream&) = delete;

    std::size_t Read(void* to, std::size_t size, std::size_t count) override {
        if (size == 0 || count == 0) return 0;
        const std::size_t from = Tell(), whole = std::min(count, (size_ - std::min(size_, from)) / size);
        file_.read(static_cast<char*>(to), static_cast<std::streamsize>(whole * size));
        if (from < blankUpTo_) std::fill_n(static_cast<char*>(to), std::min(blankUpTo_ - from, whole * size), '\n');
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
    std::size_t size_, blankUpTo_ = 0;
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
    // An OBJ names its files of materials, whatever their extension; nothing else is opened with it.
    if (opened_.size() == 1) extension_ = std::filesystem::path(path).extension().string();
    std::string extension = extension_;
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return new FileStream(found, extension == ".obj" && found != opened_.front(), streams_);
}

void PolygonFiles::Close(Assimp::IOStream* stream) {
    delete stream;
}

} // namespace scene
