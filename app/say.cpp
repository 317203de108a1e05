#include "app/say.h"
#include "scene/errors.h"

#include <cstdio>

namespace app {

void say(const std::string& sentence) {
    sayPlainly("revisit: " + sentence);
}

void sayNote(const std::string& remark) {
    sayPlainly("note: " + remark);
}

void sayPlainly(const std::string& sentence) {
    std::fprintf(stderr, "%s\n", scene::onOneLine(sentence).c_str());
}

} // namespace app
