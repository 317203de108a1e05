#include "scene/import/scan_name.h"

#include <algorithm>

namespace scene {
namespace {

constexpr std::size_t kMaxBytes = 100;

bool isContinuationByte(char c) {
    return (static_cast<unsigned char>(c) & 0xc0) == 0x80;
}

std::string fitForFile(const std::string& wanted) {
    std::string name;
    for (const char c : wanted) {
        const auto byte = static_cast<unsigned char>(c);
        const bool plain = (byte >= '0' && byte <= '9') || (byte >= 'a' && byte <= 'z') ||
                           (byte >= 'A' && byte <= 'Z') || c == '-' || c == '_' || c == '.';
        name += plain || byte >= 0x80 ? c : '_';
    }
    if (name.size() > kMaxBytes) {
        std::size_t end = kMaxBytes;
        while (end > 0 && isContinuationByte(name[end]))
            --end;
        name.resize(end);
    }
    if (!name.empty() && name[0] == '.') name[0] = '_';
    const bool empty = std::all_of(name.begin(), name.end(), [](char c) { return c == '_'; });
    return empty ? std::string() : name;
}

} // namespace

std::string scanName(const std::string& wanted, const std::string& fallback, std::set<std::string>& taken) {
    std::string name = fitForFile(wanted);
    if (name.empty()) name = fitForFile(fallback);
    if (name.empty()) name = "scan";
    std::string unique = name;
    for (int i = 2; !taken.insert(unique).second; ++i)
        unique = name + "-" + std::to_string(i);
    return unique;
}

} // namespace scene
