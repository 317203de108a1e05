#pragma once
// Steers the head and the controllers of Monado's driver `remote` (Monado in tests/xr/monado.h), over TCP on this
// machine.

#include "scene/pose.h"

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace xr {

/// As OpenXR gives it: a unit quaternion (x, y, z, w), and metres.
struct RemotePose {
    std::array<float, 4> orientation{0, 0, 0, 1};
    std::array<float, 3> position{};
};

RemotePose remotePose(const scene::Pose& bFromA);

struct RemoteEye {
    /// Radians from the eye's -Z axis; left and down of it are negative.
    float left = 0, right = 0, up = 0, down = 0;
    RemotePose headFromEye;
};

/// What a hand holds: OpenXR takes it for a Valve Index controller.
struct RemoteController {
    bool active = true; ///< false: switched off, its pose is not known
    RemotePose stageFromGrip{};
    float trigger = 0, squeeze = 0; ///< 0 to 1; the trigger clicks at 1
    std::array<float, 2> stick{};   ///< right and ahead, -1 to 1
    bool stickClick = false, a = false, b = false;
};

/// The floor of stage space is at y = 0; local space is 1.6 m above it.
struct RemoteState {
    RemotePose stageFromHead{.position = {0, 1.6f, 0}};
    /// Left and right; without them, 85 degrees across each, and 63 mm between them.
    std::optional<std::array<RemoteEye, 2>> eyes = std::nullopt;
    RemoteController left{.stageFromGrip = {.position = {-0.2f, 1.3f, -0.5f}}};
    RemoteController right{.stageFromGrip = {.position = {0.2f, 1.3f, -0.5f}}};
};

/// Monado's struct r_remote_data: 8 bytes that name it, the head, the controllers; little endian.
inline constexpr std::size_t kRemotePacketBytes = 376;
using RemotePacket = std::array<std::byte, kRemotePacketBytes>;
RemotePacket packetOf(const RemoteState& state);

/// A connection; Monado listens to one at a time. What was sent last holds on when it is gone.
class RemoteHead {
  public:
    /// Monado listens once it has made its devices: with the service when that has started, within a program when that
    /// has made its instance, and a while later. Throws std::runtime_error when the time is over.
    explicit RemoteHead(std::uint16_t port, std::chrono::milliseconds patience = std::chrono::seconds(20));
    ~RemoteHead();
    RemoteHead(const RemoteHead&) = delete;
    RemoteHead& operator=(const RemoteHead&) = delete;

    /// Returns when Monado has taken it: whatever is asked of OpenXR afterwards is answered from this state.
    void send(const RemoteState& state);

  private:
    void receive(std::byte* bytes, std::size_t count);

    std::chrono::milliseconds patience_;
    int socket_ = -1;
};

} // namespace xr
