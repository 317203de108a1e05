#include "tests/app/screen.h"

#include "tests/app/program.h"
#include "tests/scene/scratch_folder.h"

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <stdexcept>

#include <X11/Xlib.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace app {

namespace {

constexpr int kPatienceMilliseconds = 20000;

Outcome runHere(const std::vector<std::string>& command) {
    const scene::ScratchFolder scratch;
    return run(command, scratch.path());
}

} // namespace

bool canHaveScreen() {
    const auto isThere = [](const char* program) { return std::filesystem::exists(program); };
    return isThere("/usr/bin/Xvfb") && isThere("/usr/bin/xdotool") && isThere("/usr/bin/import");
}

Screen::Screen() {
    std::array<int, 2> says{};
    if (pipe(says.data()) != 0) throw std::runtime_error("no pipe");
    server_ = fork();
    if (server_ == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        close(says[0]);
        const std::string number = std::to_string(says[1]);
        execl("/usr/bin/Xvfb", "Xvfb", "-displayfd", number.c_str(), "-screen", "0", "1280x800x24", "-nolisten", "tcp",
              static_cast<char*>(nullptr));
        _exit(127);
    }
    close(says[1]);
    // It writes the number of the screen it found free, once it listens.
    pollfd readable{says[0], POLLIN, 0};
    std::string text;
    char letter = 0;
    // To the end of the line: it would not live with a reader who left early.
    while (server_ > 0 && poll(&readable, 1, kPatienceMilliseconds) == 1 && read(says[0], &letter, 1) == 1 &&
           letter != '\n')
        text += letter;
    close(says[0]);
    if (letter != '\n' || text.empty()) throw std::runtime_error("Xvfb does not start");
    display_ = ":" + text;
}

Screen::~Screen() {
    kill(server_, SIGKILL);
    waitpid(server_, nullptr, 0);
}

std::vector<std::string> Screen::around(const std::string& folder, const std::vector<std::string>& command) const {
    std::vector<std::string> words{"/usr/bin/env",    "--chdir=" + folder,   "-u",
                                   "WAYLAND_DISPLAY", "DISPLAY=" + display_, "XDG_CONFIG_HOME=" + folder + "/config"};
    words.insert(words.end(), command.begin(), command.end());
    return words;
}

bool Screen::focus(const std::string& title) {
    const Outcome found =
        runHere(around("/", {"/usr/bin/timeout", std::to_string(kPatienceMilliseconds / 1000), "/usr/bin/xdotool",
                             "search", "--sync", "--onlyvisible", "--name", "^" + title + "$"}));
    window_ = found.output.substr(0, found.output.find('\n'));
    if (found.status != 0 || window_.empty()) return false;
    act({"windowfocus", "--sync", window_});
    return true;
}

void Screen::act(const std::vector<std::string>& words) const {
    std::vector<std::string> command{"/usr/bin/timeout", "20", "/usr/bin/xdotool"};
    command.insert(command.end(), words.begin(), words.end());
    const Outcome acted = runHere(around("/", command));
    if (acted.status != 0) throw std::runtime_error("xdotool: " + acted.output);
}

bool Screen::grab(const std::string& file) const {
    return runHere(around("/", {"/usr/bin/import", "-window", window_, file})).status == 0;
}

void Screen::closeWindow() const {
    Display* const display = XOpenDisplay(display_.c_str());
    if (display == nullptr) throw std::runtime_error("the screen is gone");
    XEvent event{};
    event.xclient.type = ClientMessage;
    event.xclient.window = std::stoul(window_);
    event.xclient.message_type = XInternAtom(display, "WM_PROTOCOLS", False);
    event.xclient.format = 32;
    event.xclient.data.l[0] = static_cast<long>(XInternAtom(display, "WM_DELETE_WINDOW", False));
    XSendEvent(display, event.xclient.window, False, NoEventMask, &event);
    XCloseDisplay(display); // sends what waits
}

glm::dvec3 placeOfLastPicture(const std::string& said) {
    const std::string words = ", seen from ";
    const std::size_t at = said.rfind(words);
    if (at == std::string::npos) throw std::runtime_error("no picture was kept");
    std::istringstream numbers(said.substr(at + words.size()));
    glm::dvec3 place;
    if (!(numbers >> place.x >> place.y >> place.z)) throw std::runtime_error("no place: " + said.substr(at));
    return place;
}

} // namespace app
