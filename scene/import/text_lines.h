#pragma once
// The lines of a text file of any size, through a window of bounded memory; numbers without iostreams.

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace scene {

/// Reads forward only. Lines end at '\n'; a '\r' before it is dropped.
class TextLines {
  public:
    /// Starts at a byte. Failure: not there, not a file, cannot be opened.
    TextLines(const std::filesystem::path& path, std::uint64_t startByte);

    /// The next line, valid until the next call; false at the end of the file. Failure: a line longer than 64
    /// KiB.
    bool next(std::string_view& text);

    /// Passes over lines and returns how many there were: fewer than count only at the end of the file.
    std::uint64_t skip(std::uint64_t count);

    /// The place of the line that next() gave last, for Failure: its number, or its byte if the start was not
    /// the file's.
    std::string where() const;

    std::uint64_t byte() const { return byte_; } ///< of the file, just after that line
    std::uint64_t fileBytes() const { return fileBytes_; }

  private:
    bool fill();

    std::filesystem::path path_;
    std::ifstream stream_;
    std::vector<char> window_;
    std::size_t at_ = 0, end_ = 0;
    std::size_t line_ = 0; ///< since the start; the first is 1
    std::uint64_t startByte_ = 0, lineByte_ = 0, byte_ = 0, fileBytes_ = 0;
};

/// The numbers of a line, parted by blanks. Returns how many there are: numbers.size() + 1 if there are more
/// than fit, and -1 if something there is not a number.
int parseNumbers(std::string_view text, std::span<double> numbers);

} // namespace scene
