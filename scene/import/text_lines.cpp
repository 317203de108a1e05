#include "scene/import/text_lines.h"

#include "scene/errors.h"

#include <algorithm>
#include <charconv>
#include <cstring>

namespace scene {
namespace {

constexpr std::size_t kWindowBytes = 1 << 20, kMaxLineBytes = 1 << 16;

bool isBlank(char c) {
    return c == ' ' || c == '\t';
}

} // namespace

TextLines::TextLines(const std::filesystem::path& path, std::uint64_t startByte)
    : path_(path), window_(kWindowBytes), startByte_(startByte), lineByte_(startByte), byte_(startByte) {
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status)) throw Failure("is not there", path, "check the path");
    if (!std::filesystem::is_regular_file(status)) throw Failure("is not a file", path, "name a file");
    fileBytes_ = std::filesystem::file_size(path, error);
    stream_.open(path, std::ios::binary);
    if (error || !stream_) throw Failure("cannot be opened", path, "check its permissions");
    stream_.seekg(static_cast<std::streamoff>(startByte));
}

bool TextLines::fill() {
    std::memmove(window_.data(), window_.data() + at_, end_ - at_);
    end_ -= at_;
    at_ = 0;
    stream_.read(window_.data() + end_, static_cast<std::streamsize>(window_.size() - end_));
    end_ += static_cast<std::size_t>(stream_.gcount());
    return stream_.gcount() > 0;
}

bool TextLines::next(std::string_view& text) {
    const char* newline = nullptr;
    for (;;) {
        newline = static_cast<const char*>(std::memchr(window_.data() + at_, '\n', end_ - at_));
        if (newline) break;
        if (end_ - at_ > kMaxLineBytes)
            throw Failure("has a line longer than " + std::to_string(kMaxLineBytes) + " bytes; it is not text",
                          atByte(path_, byte_), "name a scan in E57 or PTX");
        if (!fill()) break;
    }
    if (!newline && at_ == end_) return false;
    const char* const begin = window_.data() + at_;
    const std::size_t length = newline ? static_cast<std::size_t>(newline - begin) : end_ - at_;
    lineByte_ = byte_;
    at_ += length + (newline ? 1 : 0);
    byte_ += length + (newline ? 1 : 0);
    ++line_;
    text = {begin, length};
    if (!text.empty() && text.back() == '\r') text.remove_suffix(1);
    return true;
}

std::string TextLines::where() const {
    return startByte_ == 0 ? atLine(path_, line_) : atByte(path_, lineByte_);
}

std::uint64_t TextLines::skip(std::uint64_t count) {
    std::string_view text;
    std::uint64_t skipped = 0;
    while (skipped < count && next(text))
        ++skipped;
    return skipped;
}

int parseNumbers(std::string_view text, std::span<double> numbers) {
    const char *at = text.data(), *const end = at + text.size();
    for (std::size_t count = 0;; ++count) {
        while (at != end && isBlank(*at))
            ++at;
        if (at == end) return static_cast<int>(count);
        if (count == numbers.size()) return static_cast<int>(count) + 1;
        if (*at == '+') ++at; // which from_chars does not know
        const auto [rest, error] = std::from_chars(at, end, numbers[count]);
        if (error == std::errc::result_out_of_range)
            numbers[count] = 0.0; // too small or too large for a double: nothing a scanner measured
        else if (error != std::errc())
            return -1;
        if (rest != end && !isBlank(*rest)) return -1;
        at = rest;
    }
}

} // namespace scene
