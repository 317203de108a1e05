#include "app/sizes.h"

#include <CLI/Error.hpp>

#include <charconv>
#include <cmath>

namespace app {

std::size_t parseBytes(const std::string& text) {
    constexpr std::size_t kSmallest = std::size_t{1} << 20;
    constexpr double kLargest = 1e15;
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    std::string unit(end, static_cast<const char*>(text.data() + text.size()));
    if (!unit.empty() && (unit.back() == 'B' || unit.back() == 'b')) unit.pop_back();
    double factor = 0;
    if (unit.empty()) factor = 1;
    if (unit == "K" || unit == "k") factor = 1024.0;
    if (unit == "M" || unit == "m") factor = 1024.0 * 1024;
    if (unit == "G" || unit == "g") factor = 1024.0 * 1024 * 1024;
    if (unit == "T" || unit == "t") factor = 1024.0 * 1024 * 1024 * 1024;
    const double bytes = value * factor;
    if (error != std::errc() || !(bytes >= static_cast<double>(kSmallest)) || !(bytes <= kLargest))
        throw CLI::ValidationError("--memory " + text, "is not a size of at least 1M; write e.g. 8G");
    return static_cast<std::size_t>(bytes);
}

std::pair<int, int> parseSize(const std::string& text, const std::string& option, const std::string& example) {
    constexpr int kLargest = 16384;
    int width = 0, height = 0;
    const char* end = text.data() + text.size();
    const auto [x, widthError] = std::from_chars(text.data(), end, width);
    bool isSize = widthError == std::errc() && x < end && *x == 'x';
    if (isSize) {
        const auto [last, heightError] = std::from_chars(x + 1, end, height);
        isSize = heightError == std::errc() && last == end;
    }
    if (!isSize || width < 1 || height < 1 || width > kLargest || height > kLargest)
        throw CLI::ValidationError(option + " " + text, "is not WxH with sides from 1 to 16384; write e.g. " + example);
    return {width, height};
}

} // namespace app
