#include "scene/import/ply_counts.h"

#include "scene/errors.h"
#include "scene/import/text_lines.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

namespace scene {

namespace {

/// What an element of this type takes in a binary file.
std::uint64_t bytesOfPlyType(std::string_view type) {
    constexpr std::array<std::pair<std::string_view, std::uint64_t>, 10> kWider{{{"short", 2},
                                                                                 {"ushort", 2},
                                                                                 {"int16", 2},
                                                                                 {"uint16", 2},
                                                                                 {"int", 4},
                                                                                 {"uint", 4},
                                                                                 {"int32", 4},
                                                                                 {"uint32", 4},
                                                                                 {"float", 4},
                                                                                 {"float32", 4}}};
    for (const auto& [name, bytes] : kWider)
        if (type == name) return bytes;
    return type == "double" || type == "float64" ? 8 : 1;
}

struct PlyElement {
    std::string name;
    std::uint64_t count = 0, bytes = 0; ///< bytes: that one of them takes at least
};

} // namespace

void checkPlyCounts(const std::filesystem::path& path) {
    if (path.extension() != ".ply" && path.extension() != ".PLY") return;
    TextLines lines(path, 0);
    std::string_view line;
    if (!lines.next(line) || line != "ply") return;
    bool isText = false;
    std::uint64_t left = 0; // of the bytes after the header
    std::optional<PlyElement> element;
    const auto subtract = [&](const PlyElement& of) {
        // A line of text may hold next to nothing, but ends.
        const std::uint64_t each = std::max<std::uint64_t>(of.bytes, 1);
        if (of.count > left / each)
            throw Failure("claims " + std::to_string(of.count) + " of '" + of.name + "', for which it is too short",
                          path, "it is cut off or damaged: copy or export it again");
        left -= of.count * each;
    };
    // Headers are short: gone through once for where they end, and again for what they claim.
    const auto header = [&](TextLines& from, auto&& visit) {
        std::string_view text;
        while (from.next(text) && text != "end_header")
            visit(text);
    };
    header(lines, [](std::string_view) {});
    left = lines.fileBytes() - std::min(lines.fileBytes(), lines.byte());
    TextLines again(path, 0);
    header(again, [&](std::string_view text) {
        std::istringstream words{std::string(text)};
        std::string word, type;
        words >> word;
        if (word == "format") {
            isText = words >> type && type == "ascii";
            left += isText ? 1 : 0; // the last line need not end
        } else if (word == "element") {
            if (element) subtract(*element);
            element.emplace();
            words >> element->name >> element->count;
        } else if (word == "property" && element) {
            words >> type;
            if (type == "list") words >> type; // of its count; it may be empty
            constexpr std::uint64_t kDigitAndBlank = 2;
            element->bytes += isText ? kDigitAndBlank : bytesOfPlyType(type);
        }
    });
    if (element) subtract(*element);
}

} // namespace scene
