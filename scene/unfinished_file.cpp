#include "scene/unfinished_file.h"

#include "scene/errors.h"

#include <system_error>
#include <utility>

namespace scene {

UnfinishedFile::UnfinishedFile(std::filesystem::path wanted) : wanted_(std::move(wanted)), path_(wanted_) {
    path_ += ".part";
}

UnfinishedFile::~UnfinishedFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
}

void UnfinishedFile::finish() const {
    std::error_code error;
    std::filesystem::rename(path_, wanted_, error);
    if (error) throw Failure("cannot be put in place (" + error.message() + ")", wanted_, kWriteRemedy);
}

} // namespace scene
