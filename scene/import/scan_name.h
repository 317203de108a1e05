#pragma once
// Names for scans, from whatever a file calls them.

#include <set>
#include <string>

namespace scene {

/// wanted (or, where nothing of it remains, fallback) made fit for a file name: letters, digits, '-', '_',
/// '.' and anything beyond ASCII stay, the rest becomes '_'; no leading dot, at most 100 bytes; "-2", "-3",
/// ... where taken has it already. The result is put into taken.
std::string scanName(const std::string& wanted, const std::string& fallback, std::set<std::string>& taken);

} // namespace scene
