#include "tests/xr/fake.h"

#include <cstdlib>
#include <stdexcept>

#include <dlfcn.h>

namespace xr {

Fake::Fake() {
    scene::writeFile(manifest(),
                     R"({"file_format_version": "1.0.0", "runtime": {"library_path": ")" REVISIT_FAKE_RUNTIME R"("}})");
}

void Fake::enter() const {
    for (const char* elsewhere : {"DISPLAY", "WAYLAND_DISPLAY", "XR_ENABLE_API_LAYERS"})
        unsetenv(elsewhere);
    setenv("XR_RUNTIME_JSON", manifest().c_str(), 1);
    setenv("XR_LOADER_DEBUG", "none", 1);
    tell("");
    library_ = dlopen(REVISIT_FAKE_RUNTIME, RTLD_NOW | RTLD_LOCAL);
    if (library_ == nullptr) throw std::runtime_error(dlerror());
}

void Fake::tell(const std::string& words) {
    setenv("REVISIT_FAKE", words.c_str(), 1);
}

int Fake::alive() const {
    return reinterpret_cast<int (*)()>(dlsym(library_, "fakeRuntimeAlive"))();
}

XrRect2Di Fake::shown() const {
    XrRect2Di shown{};
    reinterpret_cast<void (*)(XrRect2Di*)>(dlsym(library_, "fakeRuntimeShown"))(&shown);
    return shown;
}

std::vector<std::string> Fake::around(const std::string& words, const std::vector<std::string>& command) const {
    std::vector<std::string> all{"/usr/bin/env",
                                 "-u",
                                 "DISPLAY",
                                 "-u",
                                 "WAYLAND_DISPLAY",
                                 "-u",
                                 "XR_ENABLE_API_LAYERS",
                                 "REVISIT_FAKE=" + words,
                                 "XR_RUNTIME_JSON=" + manifest().string()};
    all.insert(all.end(), command.begin(), command.end());
    return all;
}

} // namespace xr
