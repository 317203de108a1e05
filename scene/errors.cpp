#include "scene/errors.h"

namespace scene {

Failure::Failure(const std::string& what, const std::string& where, const std::string& remedy)
    : std::runtime_error(onOneLine(where + ": " + what + "; " + remedy)) {}

Failure::Failure(const std::string& what, const std::filesystem::path& where, const std::string& remedy)
    : Failure(what, where.string(), remedy) {}

std::string onOneLine(const std::string& text) {
    constexpr const char* kDigits = "0123456789abcdef";
    std::string line;
    for (const char character : text) {
        const auto byte = static_cast<unsigned char>(character);
        if (byte >= 0x20 && byte != 0x7f) // bytes of UTF-8 and of older encodings stay as they are
            line += character;
        else
            line.append("\\x").append({kDigits[byte >> 4], kDigits[byte & 15]});
    }
    return line;
}

std::string atLine(const std::filesystem::path& path, std::size_t line) {
    return path.string() + ", line " + std::to_string(line);
}

std::string atByte(const std::filesystem::path& path, std::uint64_t byte) {
    return path.string() + ", byte " + std::to_string(byte);
}

} // namespace scene
