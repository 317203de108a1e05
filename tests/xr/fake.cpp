#include "tests/xr/fake.h"

namespace xr {

Fake::Fake() {
    scene::writeFile(manifest(),
                     R"({"file_format_version": "1.0.0", "runtime": {"library_path": ")" REVISIT_FAKE_RUNTIME R"("}})");
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
