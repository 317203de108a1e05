#include "scene/import/ply_counts.h"

#include "scene/errors.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

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
    constexpr std::size_t kLongestHeader = std::size_t{64} << 10;
    std::string head(kLongestHeader, '\0');
    std::ifstream file(path, std::ios::binary);
    file.read(head.data(), static_cast<std::streamsize>(head.size()));
    head.resize(static_cast<std::size_t>(file.gcount()));
    std::vector<PlyElement> elements;
    bool isText = false, isWhole = false;
    std::istringstream lines(head);
    std::uint64_t headerBytes = 0;
    for (std::string text; !isWhole && std::getline(lines, text);) {
        headerBytes += text.size() + 1;
        std::istringstream words(text); // any blanks part words, those before an end of line included
        std::string word, type;
        words >> word;
        if (word == "end_header") {
            isWhole = true;
        } else if (word == "format") {
            isText = words >> type && type == "ascii";
        } else if (word == "element") {
            words >> elements.emplace_back().name >> elements.back().count;
        } else if (word == "property" && !elements.empty()) {
            words >> type;
            if (type == "list") words >> type; // of its count; it may be empty
            constexpr std::uint64_t kDigitAndBlank = 2;
            elements.back().bytes += isText ? kDigitAndBlank : bytesOfPlyType(type);
        }
    }
    if (!isWhole) {
        std::string magic = head.substr(0, 3);
        std::transform(magic.begin(), magic.end(), magic.begin(),
                       [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
        if (magic != "ply") return;
        // Assimp would look for it for ever.
        throw Failure("has a header without an end", path, "it is cut off or damaged: copy or export it again");
    }
    const std::uint64_t fileBytes = std::filesystem::file_size(path);
    std::uint64_t left = fileBytes - std::min(fileBytes, headerBytes);
    if (isText) ++left; // the last line need not end
    for (const PlyElement& element : elements) {
        // Assimp takes memory for what has no properties, too, though it needs no bytes in a binary file.
        const std::uint64_t each = std::max<std::uint64_t>(element.bytes, 1);
        if (element.count > left / each)
            throw Failure("claims " + std::to_string(element.count) + " of '" + element.name +
                              "', for which it is too short",
                          path, "it is cut off or damaged: copy or export it again");
        left -= element.count * each;
    }
}

} // namespace scene
