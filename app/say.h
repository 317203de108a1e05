#pragma once
// What the program says beside its results.

#include <string>

namespace app {

/// One line to standard error, whatever names of files are in it: "revisit: ...", "note: ..." or as it is.
void say(const std::string& sentence);
void sayNote(const std::string& remark);
void sayPlainly(const std::string& sentence);

} // namespace app
