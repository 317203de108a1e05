#pragma once
// The OpenXR runtime Monado with a head and controllers that a test steers (RemoteHead in tests/xr/remote_head.h).

#include "tests/scene/scratch_folder.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <sys/types.h>

namespace xr {

/// Whether ./dev has put it there (cmake/get_monado.sh); a test skips where it has not.
bool isMonadoThere();

enum class Variant {
    inproc,  ///< within the program under test
    service, ///< in a process of its own, which a test may kill
};

struct MonadoOptions {
    /// Of the compositor, which shows nothing: frames per second, and what it recommends for each eye.
    int hertz = 90, width = 320, height = 240;
    /// Whether OpenXR's validation layer stands before it (validationMessages()).
    bool validation = false;
};

/// Folders, a port and settings of its own, so that many may run at once; gone with it.
class Monado {
  public:
    explicit Monado(Variant variant, const MonadoOptions& options = {});
    ~Monado();
    Monado(const Monado&) = delete;
    Monado& operator=(const Monado&) = delete;

    /// For RemoteHead; no other program is given it as long as this lives.
    std::uint16_t port() const { return port_; }

    /// NAME=VALUE, all of it: this program's own without what would lead OpenXR elsewhere, lavapipe as the only
    /// graphics device, no display.
    std::vector<std::string> environment() const;
    /// The command that runs another in that environment.
    std::vector<std::string> around(const std::vector<std::string>& command) const;

    /// The service: start() returns when it can be connected to, and throws std::runtime_error if it does not come to
    /// that; kill() gives it no chance to say goodbye, and returns when it is gone.
    void start();
    void kill();
    void restart();
    /// What it wrote since it was started last.
    std::string serviceOutput() const;

    /// What the validation layer found in the programs that ran so far.
    std::string validationMessages() const;

  private:
    std::vector<std::string> settings() const;
    void waitUntilStarted(int serviceDescriptor) const;

    scene::ScratchFolder folder_;
    Variant variant_;
    MonadoOptions options_;
    int reservation_ = -1;
    std::uint16_t port_ = 0;
    pid_t service_ = 0;
};

} // namespace xr
