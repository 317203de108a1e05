#include "scene/late_library.h"

#include "scene/errors.h"

#include <dlfcn.h>

namespace scene {

void* functionOfLibrary(const char* library, const char* function) {
    void* const handle = dlopen(library, RTLD_NOW | RTLD_LOCAL);
    void* const found = handle != nullptr ? dlsym(handle, function) : nullptr;
    if (found != nullptr) return found;
    const char* const why = dlerror();
    throw Failure("cannot be loaded (" + std::string(why != nullptr ? why : "it lacks what it should have") + ")",
                  std::string(library), "keep the program's folders bin and lib beside each other, or build again");
}

} // namespace scene
