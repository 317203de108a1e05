#pragma once
// How the world's failures are told: one exception type that says what is wrong, where, and what to do about
// it.
//
// Three kinds of failure, three answers: our own mistakes are asserted, ordinary absence is std::optional,
// and a file, a device or an option that cannot be used throws Failure. The program prints what() as one line
// and exits with status 1.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace scene {

class Failure : public std::runtime_error {
  public:
    /// what: the fault, in lower case without a full stop. where: path, with byte or line where known.
    /// remedy: what the user can do. Printed as "where: what; remedy", one line whatever names are in it.
    Failure(const std::string& what, const std::string& where, const std::string& remedy);
    Failure(const std::string& what, const std::filesystem::path& where, const std::string& remedy);
};

/// For what is told in one line: characters that control a terminal, as names of files may hold, become "\\x0a".
std::string onOneLine(const std::string& text);

/// "PATH, line 12" or "PATH, byte 4096": a place inside a file, for Failure.
std::string atLine(const std::filesystem::path& path, std::size_t line);
std::string atByte(const std::filesystem::path& path, std::uint64_t byte);

} // namespace scene
