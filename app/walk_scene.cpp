#include "app/walk_scene.h"

#include "app/damage_teller.h"
#include "app/desk_window.h"
#include "app/kept_settings.h"
#include "app/output_file.h"
#include "app/say.h"
#include "app/stage_store.h"
#include "app/walk.h"

#include "scene/errors.h"
#include "scene/scene_file.h"
#include "scene/unfinished_file.h"

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <exception>
#include <optional>
#include <thread>

#include <unistd.h>

namespace app {

namespace {

constexpr int kWindowWidth = 1280, kWindowHeight = 800;

/// Ctrl-C ends the walk as the walker would: what was recorded is written.
class EndBySignal {
  public:
    EndBySignal() {
        Walk::forgetAskedToEnd();
        struct sigaction action {};
        action.sa_handler = [](int) { Walk::askToEnd(); };
        sigaction(SIGINT, &action, &previousInt_);
        sigaction(SIGTERM, &action, &previousTerm_);
    }
    ~EndBySignal() {
        sigaction(SIGINT, &previousInt_, nullptr);
        sigaction(SIGTERM, &previousTerm_, nullptr);
    }
    EndBySignal(const EndBySignal&) = delete;
    EndBySignal& operator=(const EndBySignal&) = delete;

  private:
    struct sigaction previousInt_ {
    }, previousTerm_{};
};

bool hasDisplay() {
    const auto isSet = [](const char* name) {
        const char* const value = std::getenv(name);
        return value != nullptr && *value != '\0';
    };
    return isSet("DISPLAY") || isSet("WAYLAND_DISPLAY");
}

/// The window in this thread, the walk in another: neither holds the other up.
void walkBesideWindow(const scene::Scene& scene, WalkOptions options, xr::Window& window) {
    const KeptSettings kept(input::settingsFile(), say);
    options.settings = kept.read();
    Desk desk(Walk::knobsOf(options));
    xr::DesktopOptions desktopOptions;
    desktopOptions.eyeHeightMetres = options.settings.eyeHeightMetres;
    desktopOptions.eyeDistanceMetres = options.draw.eyeDistanceMetres;
    desktopOptions.width = window.width(), desktopOptions.height = window.height();
    xr::Desktop desktop(desktopOptions);
    DeskSide side{desk, desktop};
    std::exception_ptr failure;
    std::thread walker([&] {
        try {
            Walk(scene, options, &side).run();
        } catch (...) {
            failure = std::current_exception();
        }
        desk.leave();
    });
    try {
        const DeskEnd end = runDeskWindow(window, desk, desktop);
        if (end == DeskEnd::left) Walk::askToEnd();
        if (end == DeskEnd::windowClosed && !desk.facts().isAtDesk)
            std::fprintf(stderr, "the window is closed; the walk goes on in the headset (Ctrl-C ends it)\n");
        window.hide();
    } catch (...) {
        Walk::askToEnd();
        desktop.close();
        walker.join();
        throw;
    }
    walker.join();
    kept.keep(desk.knobs().settings);
    if (failure) std::rethrow_exception(failure);
}

void walkAlone(const scene::Scene& scene, WalkOptions options) {
    // Without a display nothing may depend on who runs it.
    if (!options.isHeadless) options.settings = KeptSettings(input::settingsFile(), say).read();
    Walk(scene, options, nullptr).run();
}

/// The window if there can be one: needed at the desk, welcome beside a headset.
std::unique_ptr<xr::Window> openWindow(const WalkOptions& options) {
    if (options.isHeadless) return nullptr;
    if (!options.isAtDesk && !hasDisplay()) return nullptr;
    try {
        return std::make_unique<xr::Window>("Revisit", kWindowWidth, kWindowHeight);
    } catch (const scene::Failure& failure) {
        if (options.isAtDesk) throw;
        sayPlainly(std::string("no mirror: ") + failure.what());
        return nullptr;
    }
}

/// Of a walk that was killed there are pictures alone: those may be drawn again.
void checkWalkFolder(const WalkOptions& options) {
    const auto isWalks = [](const nlohmann::json& report) {
        return isDrawnReport(report) && report.contains("hidden_share"); // what displays hide: of walks alone
    };
    checkReplaceableReport(options.out, isDrawnReport);
    checkReplaceableBeside(options.out, isWalks, std::array<std::string, 1>{"cameras.json"});
    if (options.pictureEvery == 0) return;
    const std::vector<std::string> all = picturesIn(options.out);
    const std::ptrdiff_t pictures = std::ranges::count_if(
        all, [](const std::string& name) { return name.starts_with("frame-") && name.ends_with(".png"); });
    if (pictures == 0) return;
    if (std::ssize(all) > pictures && reportIn(options.out, isWalks).is_null())
        throw scene::Failure("holds pictures of frames, among others, that no finished walk speaks of and that may be "
                             "replaced",
                             options.out, "name another folder with --out");
    sayNote("'" + options.out.string() + "' holds pictures of an earlier walk, " + std::to_string(pictures) +
            " of them: those that this one does not draw again stay, and report.json will not speak of them.");
}

/// Found out before the walk, since what is recorded is written after it.
bool mayBeWritten(const std::filesystem::path& file) {
    std::error_code ignored;
    if (std::filesystem::is_other(file, ignored)) return ::access(file.c_str(), W_OK) == 0; // it is written to
    const std::filesystem::path folder = std::filesystem::absolute(endOfLinks(file), ignored).parent_path();
    return !std::filesystem::is_directory(file, ignored) && ::access(folder.c_str(), W_OK) == 0;
}

} // namespace

void walkScene(const WalkOptions& options) {
    if (options.isHeadless && options.path.empty())
        throw scene::Failure("leads nowhere", std::string("--path"), "name a file");
    if (!options.record.empty())
        checkReplaceableFile(options.record, std::array{options.path}, [](const nlohmann::json& of) {
            return of.is_object() && of.contains("space") && of.contains("poses");
        });
    if (!options.out.empty()) checkWalkFolder(options);
    const scene::Scene scene = scene::openScene(options.scene, scene::DamagedHeads::leftOut);
    for (const std::string& sentence : DamageTeller::lost(scene))
        say(sentence);
    if (!options.out.empty()) {
        std::error_code error;
        std::filesystem::create_directories(options.out, error);
        if (error)
            throw scene::Failure("cannot be made (" + error.message() + ")", options.out,
                                 "check that the folder may be written");
    }
    if (!options.record.empty() && !mayBeWritten(options.record))
        throw scene::Failure("cannot be written", options.record, scene::kWriteRemedy);
    xr::hushLoader();
    const EndBySignal endBySignal;
    if (const std::unique_ptr<xr::Window> window = openWindow(options))
        walkBesideWindow(scene, options, *window);
    else
        walkAlone(scene, options);
}

} // namespace app
