#include "scene/import/gltf_nodes.h"

#include "scene/errors.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace scene {

namespace {

using nlohmann::json;

/// The JSON of a .gltf file, or of a .glb's first chunk; discarded if there is none.
json jsonOf(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::array<char, 4> magic{};
    file.read(magic.data(), magic.size());
    if (std::memcmp(magic.data(), "glTF", magic.size()) != 0) {
        file.clear();
        file.seekg(0);
        return json::parse(file, nullptr, false);
    }
    std::array<std::uint32_t, 4> head{}; // version, length of all, length and kind of the first chunk; little-endian
    file.read(reinterpret_cast<char*>(head.data()), sizeof head);
    std::error_code error;
    const std::uintmax_t bytes = std::filesystem::file_size(path, error);
    if (!file || error || head[2] > bytes) return json(json::value_t::discarded);
    std::string text(head[2], '\0');
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(file.gcount()));
    while (!text.empty() && text.back() == '\0') // as some fill up chunks
        text.pop_back();
    return json::parse(text, nullptr, false);
}

} // namespace

void checkGltfNodes(const std::filesystem::path& path, int deepest) {
    const json root = jsonOf(path);
    if (!root.is_object() || !root.contains("nodes") || !root["nodes"].is_array()) return;
    const json& nodes = root["nodes"];
    constexpr std::size_t kNone = static_cast<std::size_t>(-1);
    std::vector<std::size_t> parents(nodes.size(), kNone);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (!nodes[i].is_object() || !nodes[i].contains("children") || !nodes[i]["children"].is_array()) continue;
        for (const json& child : nodes[i]["children"]) {
            if (!child.is_number_unsigned() || child.get<std::uint64_t>() >= nodes.size()) continue;
            std::size_t& parent = parents[child.get<std::size_t>()];
            if (parent != kNone)
                throw Failure("node " + child.dump() + " is a child twice, of nodes " + std::to_string(parent) +
                                  " and " + std::to_string(i),
                              path, "export it again: glTF's nodes are trees");
            parent = i;
        }
    }
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        int depth = 0; // a circle has no end, and is therefore too deep as well
        for (std::size_t at = parents[i]; at != kNone; at = parents[at])
            if (++depth > deepest)
                throw Failure("holds nodes more than " + std::to_string(deepest) + " deep", path, "export it flatter");
    }
}

} // namespace scene
