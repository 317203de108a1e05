#include "scene/errors.h"

namespace scene {

Failure::Failure(const std::string& what, const std::string& where, const std::string& remedy)
    : std::runtime_error(where + ": " + what + "; " + remedy) {}

Failure::Failure(const std::string& what, const std::filesystem::path& where, const std::string& remedy)
    : Failure(what, where.string(), remedy) {}

std::string atLine(const std::filesystem::path& path, std::size_t line) {
    return path.string() + ", line " + std::to_string(line);
}

std::string atByte(const std::filesystem::path& path, std::uint64_t byte) {
    return path.string() + ", byte " + std::to_string(byte);
}

} // namespace scene
