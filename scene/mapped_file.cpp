#include "scene/mapped_file.h"

#include "scene/errors.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace scene {

MappedFile::MappedFile(const std::filesystem::path& path) {
    const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat status {};
    if (file < 0 || fstat(file, &status) != 0 || !S_ISREG(status.st_mode)) {
        const std::string cause = file < 0 ? std::strerror(errno) : "no regular file";
        if (file >= 0) close(file);
        throw Failure("cannot be opened (" + cause + ")", path, "check the path, or build the scene again");
    }
    const auto size = static_cast<std::size_t>(status.st_size);
    void* address = size > 0 ? mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file, 0) : nullptr;
    close(file);
    if (address == MAP_FAILED) throw Failure("cannot be mapped into memory", path, "free some memory and try again");
    bytes_ = {static_cast<const std::byte*>(address), size};
}

MappedFile::~MappedFile() {
    if (!bytes_.empty()) munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

} // namespace scene
