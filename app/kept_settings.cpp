#include "app/kept_settings.h"

#include "app/stage_store.h"

#include "scene/errors.h"

#include <utility>

namespace app {

namespace fs = std::filesystem;

KeptSettings::KeptSettings(fs::path file, std::function<void(const std::string&)> tell)
    : file_(std::move(file)), tell_(std::move(tell)) {
    try {
        read_ = input::readSettings(file_);
    } catch (const scene::Failure& failure) {
        tell_(std::string(failure.what()) + "; until then settings are not kept");
        isBroken_ = true;
    }
}

void KeptSettings::keep(const input::Settings& settings) const {
    if (isBroken_) return;
    try {
        if (input::textOf(settings, {}) == input::textOf(read_, {})) return;
        if (file_.empty())
            throw scene::Failure("are not kept: there is no home for them", std::string("settings"),
                                 "set HOME or XDG_CONFIG_HOME");
        const std::string text = input::textOf(settings, file_);
        std::error_code error;
        fs::create_directories(file_.parent_path(), error); // writing tells
        writeWhole(file_, text);                            // through a link: some keep their settings elsewhere
    } catch (const scene::Failure& failure) {
        tell_(failure.what());
    }
}

} // namespace app
