#include "tests/xr/monado.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <stdexcept>
#include <string_view>

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/inotify.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

namespace xr {

namespace {

namespace fs = std::filesystem;

const fs::path kMonado = REVISIT_MONADO;
constexpr std::chrono::seconds kPatience{20};

[[noreturn]] void fail(const std::string& what) {
    throw std::runtime_error("Monado: " + what + ": " + std::strerror(errno));
}

/// Closes it when it goes.
struct Descriptor {
    int number;
    explicit Descriptor(int opened) : number(opened) {}
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    ~Descriptor() {
        if (number >= 0) close(number);
    }
};

std::string nameOf(Variant variant) {
    return variant == Variant::inproc ? "inproc" : "service";
}

std::string contentOf(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// Settings that would lead OpenXR, Monado or Vulkan elsewhere than the test says.
bool isOurs(std::string_view setting) {
    constexpr std::array kNames{"DISPLAY=",          "WAYLAND_DISPLAY=", "XDG_RUNTIME_DIR=",    "XDG_CONFIG_HOME=",
                                "VK_ICD_FILENAMES=", "VK_DRIVER_FILES=", "VK_ADD_DRIVER_FILES="};
    constexpr std::array kBeginnings{"XR_", "XRT_", "OXR_", "P_OVERRIDE_", "SIMULATED_", "IPC_", "U_PACING_"};
    const auto begins = [&](std::string_view beginning) { return setting.starts_with(beginning); };
    return std::any_of(kNames.begin(), kNames.end(), begins) ||
           std::any_of(kBeginnings.begin(), kBeginnings.end(), begins);
}

/// The renderer in software: its file is named after the machine in some versions of Mesa, and not in others.
fs::path lavapipe() {
    for (const char* folder : {"/etc/vulkan/icd.d", "/usr/share/vulkan/icd.d", "/usr/local/share/vulkan/icd.d"}) {
        std::error_code absent;
        for (const auto& entry : fs::directory_iterator(folder, absent))
            if (entry.path().filename().string().starts_with("lvp_icd") && entry.path().extension() == ".json")
                return entry.path();
    }
    throw std::runtime_error("Monado: no lavapipe among Vulkan's drivers; install mesa-vulkan-drivers");
}

} // namespace

bool isMonadoThere() {
    return fs::exists(kMonado / ".stamp");
}

Monado::Monado(Variant variant, const MonadoOptions& options) : variant_(variant), options_(options) {
    for (const char* name : {"run", "config", "config/monado"}) {
        fs::create_directory(folder_ / name);
        fs::permissions(folder_ / name, fs::perms::owner_all);
    }
    if ((folder_ / "run/monado_comp_ipc").string().size() >= sizeof(sockaddr_un::sun_path))
        throw std::runtime_error("Monado: " + folder_.path().string() + " is too long for a socket; shorten TMPDIR");

    // Bound but not listened to, a port is given to nobody else who asks for any; and Monado, which asks for this one,
    // gets it all the same, since both sides allow it to be reused.
    reservation_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const int on = 1;
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    auto* const asked = reinterpret_cast<sockaddr*>(&address);
    if (reservation_ < 0 || setsockopt(reservation_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on)) != 0 ||
        bind(reservation_, asked, size) != 0 || getsockname(reservation_, asked, &size) != 0)
        fail("cannot find a free port");
    port_ = ntohs(address.sin_port);

    scene::writeFile(folder_ / "config/monado/config_v0.json",
                     R"({"active": "remote", "remote": {"version": 0, "port": )" + std::to_string(port_) +
                         R"(, "view_count": 2}})");
}

Monado::~Monado() {
    kill();
    close(reservation_);
}

std::vector<std::string> Monado::settings() const {
    const std::string driver = lavapipe().string();
    std::vector<std::string> settings{
        "XR_RUNTIME_JSON=" + (kMonado / nameOf(variant_) / "share/openxr/1/openxr_monado.json").string(),
        "XDG_RUNTIME_DIR=" + (folder_ / "run").string(),
        "XDG_CONFIG_HOME=" + (folder_ / "config").string(),
        "VK_ICD_FILENAMES=" + driver, // what loaders before 1.3.207 read
        "VK_DRIVER_FILES=" + driver,
        "XRT_COMPOSITOR_NULL=1",
        "XRT_COMPOSITOR_NULL_HZ=" + std::to_string(options_.hertz),
        "XRT_COMPOSITOR_NULL_WIDTH=" + std::to_string(options_.width),
        "XRT_COMPOSITOR_NULL_HEIGHT=" + std::to_string(options_.height),
    };
    if (options_.validation) {
        settings.push_back("XR_ENABLE_API_LAYERS=XR_APILAYER_LUNARG_core_validation");
        settings.push_back("XR_CORE_VALIDATION_EXPORT_TYPE=text");
        settings.push_back("XR_CORE_VALIDATION_FILE_NAME=" + (folder_ / "validation.txt").string());
    }
    return settings;
}

std::vector<std::string> Monado::environment() const {
    std::vector<std::string> all = settings();
    for (char** variable = environ; *variable; ++variable)
        if (!isOurs(*variable)) all.emplace_back(*variable);
    return all;
}

std::vector<std::string> Monado::around(const std::vector<std::string>& command) const {
    std::vector<std::string> words{"/usr/bin/env"};
    for (char** variable = environ; *variable; ++variable) {
        const std::string setting = *variable;
        if (isOurs(setting)) words.insert(words.end(), {"-u", setting.substr(0, setting.find('='))});
    }
    const std::vector<std::string> own = settings();
    words.insert(words.end(), own.begin(), own.end());
    words.insert(words.end(), command.begin(), command.end());
    return words;
}

void Monado::start() {
    if (variant_ != Variant::service) throw std::logic_error("Monado: only the service is started");
    if (service_ != 0) throw std::logic_error("Monado: the service runs already");
    // One that was killed leaves its socket behind, and the next one refuses to start because of it.
    fs::remove(folder_ / "run/monado_comp_ipc");

    const std::string program = (kMonado / "service/bin/monado-service").string();
    std::vector<std::string> variables = environment();
    variables.push_back("XRT_NO_STDIN=1"); // else it ends as soon as it can read something there
    variables.push_back("IPC_LOG=info");   // says that it has started, whatever XRT_LOG says
    std::vector<char*> pointers;
    for (std::string& variable : variables)
        pointers.push_back(variable.data());
    pointers.push_back(nullptr);
    char* const arguments[] = {const_cast<char*>(program.c_str()), nullptr};
    const Descriptor output(open((folder_ / "service.txt").c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
    if (output.number < 0) fail("cannot write a file for its output");

    service_ = fork();
    if (service_ < 0) {
        service_ = 0;
        fail("cannot start a process");
    }
    if (service_ == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL); // not to outlive a test that crashed
        dup2(output.number, STDOUT_FILENO);
        dup2(output.number, STDERR_FILENO);
        execve(program.c_str(), arguments, pointers.data());
        _exit(127);
    }
    const Descriptor ended(static_cast<int>(syscall(SYS_pidfd_open, service_, 0)));
    try {
        waitUntilStarted(ended.number);
    } catch (...) {
        kill();
        throw;
    }
}

/// It says so when its socket is listened to; a socket's file is there a little earlier.
void Monado::waitUntilStarted(int serviceDescriptor) const {
    const Descriptor changes(inotify_init1(IN_CLOEXEC));
    if (inotify_add_watch(changes.number, (folder_ / "service.txt").c_str(), IN_MODIFY) < 0)
        fail("cannot watch its output");
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    while (serviceOutput().find("service has started") == std::string::npos) {
        const auto left =
            std::chrono::duration_cast<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
        std::array<pollfd, 2> events{{{changes.number, POLLIN, 0}, {serviceDescriptor, POLLIN, 0}}};
        const int count = poll(events.data(), events.size(), static_cast<int>(std::max<long>(left.count(), 0)));
        if (count == 0 || events[1].revents != 0)
            throw std::runtime_error("Monado: the service " + std::string(count == 0 ? "hangs" : "ended") +
                                     " before it had started. It wrote:\n" + serviceOutput());
        std::array<char, 4096> ignored;
        if (events[0].revents != 0 && read(changes.number, ignored.data(), ignored.size()) < 0)
            fail("cannot watch its output");
    }
}

void Monado::kill() {
    if (service_ == 0) return;
    ::kill(service_, SIGKILL);
    waitpid(service_, nullptr, 0);
    service_ = 0;
}

void Monado::restart() {
    kill();
    start();
}

std::string Monado::serviceOutput() const {
    return contentOf(folder_ / "service.txt");
}

std::string Monado::validationMessages() const {
    return contentOf(folder_ / "validation.txt");
}

} // namespace xr
