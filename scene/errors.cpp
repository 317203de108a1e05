#include "scene/errors.h"

namespace scene {

Failure::Failure(const std::string& what, const std::string& where, const std::string& remedy)
    : std::runtime_error(onOneLine(where + ": " + what + "; " + remedy)) {}

Failure::Failure(const std::string& what, const std::filesystem::path& where, const std::string& remedy)
    : Failure(what, where.string(), remedy) {}

std::string onOneLine(const std::string& text) {
    constexpr const char* kDigits = "0123456789abcdef";
    std::string line;
    const auto escape = [&](unsigned char byte) {
        line.append("\\x").append({kDigits[byte >> 4], kDigits[byte & 15]});
    };
    for (std::size_t i = 0; i < text.size(); ++i) {
        const auto byte = static_cast<unsigned char>(text[i]);
        const auto next = static_cast<unsigned char>(i + 1 < text.size() ? text[i + 1] : 0);
        if (byte == 0xc2 && next >= 0x80 && next <= 0x9f) { // the upper controls, in UTF-8
            escape(byte), escape(next);
            ++i;
        } else if (byte < 0x20 || byte == 0x7f) {
            escape(byte);
        } else { // bytes of UTF-8 and of older encodings stay as they are
            line += text[i];
        }
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
