#pragma once
// Sizes as people write them on a command line.

#include <cstddef>
#include <string>
#include <utility>

namespace app {

/// "8G", "512M", "1.5G", "4096" -> bytes; K, M, G, T are powers of 1024. Throws CLI::ValidationError.
std::size_t parseBytes(const std::string& text);

/// "640x480" -> (640, 480), each from 1 to 16384. Throws CLI::ValidationError, which names the option.
std::pair<int, int> parseSize(const std::string& text, const std::string& option = "--size",
                              const std::string& example = "640x480");

} // namespace app
