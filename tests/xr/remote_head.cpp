#include "tests/xr/remote_head.h"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace xr {

namespace {

// The sizes of Monado's structs, part by part.
constexpr std::size_t kPoseBytes = 4 * 4 + 3 * 4;
constexpr std::size_t kViewBytes = 4 * 4 + kPoseBytes + 4;
constexpr std::size_t kHeadBytes = 2 * kViewBytes + kPoseBytes + 4;
constexpr std::size_t kControllerBytes = kPoseBytes + 2 * 3 * 4 + 5 * 4 + 8 * 4 + 16;
static_assert(kViewBytes == 48 && kHeadBytes == 128 && kControllerBytes == 120);
static_assert(8 + kHeadBytes + 2 * kControllerBytes == kRemotePacketBytes);
static_assert(sizeof(float) == 4);

/// Writes one value after the other, little endian.
class Writer {
  public:
    void text(const char (&word)[9]) {
        for (int i = 0; i < 8; ++i)
            byte(static_cast<unsigned char>(word[i]));
    }
    void flag(bool value) { byte(value ? 1 : 0); }
    void number(float value) {
        for (auto bits = std::bit_cast<std::uint32_t>(value), i = 0u; i < 4; ++i, bits >>= 8)
            byte(static_cast<unsigned char>(bits & 0xff));
    }
    template <std::size_t N>
    void numbers(const std::array<float, N>& values) {
        for (const float value : values)
            number(value);
    }
    void zeros(std::size_t count) { at_ += count; }

    void pose(const RemotePose& pose) {
        numbers(pose.orientation);
        numbers(pose.position);
    }
    void eye(const RemoteEye& eye) {
        numbers<4>({eye.left, eye.right, eye.up, eye.down});
        pose(eye.headFromEye);
        zeros(4);
    }
    void controller(const RemoteController& hand) {
        pose(hand.stageFromGrip);
        zeros(2 * 3 * 4); // its velocities
        zeros(5 * 4);     // how far the fingers are curled
        numbers<3>({hand.trigger, hand.squeeze, 0});
        numbers(hand.stick);
        zeros(3 * 4); // the track pad
        flag(false);  // the hand itself is not tracked
        flag(hand.active);
        zeros(2); // the system button: click and touch, as for those that follow
        for (const bool pressed : {hand.a, hand.b}) {
            flag(pressed);
            flag(pressed);
        }
        flag(hand.trigger >= 1);
        flag(hand.trigger > 0);
        flag(hand.stickClick);
        flag(hand.stickClick || hand.stick != std::array<float, 2>{});
        zeros(4); // the track pad's touch, and three that say nothing
    }

    RemotePacket finished() const {
        if (at_ != kRemotePacketBytes)
            throw std::logic_error("a packet for Monado of " + std::to_string(at_) + " bytes");
        return packet_;
    }

  private:
    void byte(unsigned char value) { packet_.at(at_++) = static_cast<std::byte>(value); }

    RemotePacket packet_{};
    std::size_t at_ = 0;
};

using Clock = std::chrono::steady_clock;

[[noreturn]] void failSetting(const std::string& what) {
    throw std::runtime_error("Monado's remote head: " + what + ": " + std::strerror(errno));
}

/// Blocks on loopback for no longer than it takes to be accepted or refused. -1 if nobody listens there yet.
int connectTo(std::uint16_t port) {
    const int descriptor = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (descriptor < 0) failSetting("cannot make a socket");
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0) {
        // A packet is a message: it must not wait for the next to fill a segment.
        const int on = 1;
        setsockopt(descriptor, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
        return descriptor;
    }
    const int reason = errno;
    close(descriptor);
    errno = reason;
    if (reason != ECONNREFUSED) failSetting("cannot connect to port " + std::to_string(port));
    return -1;
}

} // namespace

RemotePose remotePose(const scene::Pose& bFromA) {
    const glm::dvec4 q = scene::quaternionOf(bFromA);
    const glm::dvec3 t = bFromA.translation;
    return {{static_cast<float>(q.x), static_cast<float>(q.y), static_cast<float>(q.z), static_cast<float>(q.w)},
            {static_cast<float>(t.x), static_cast<float>(t.y), static_cast<float>(t.z)}};
}

RemotePacket packetOf(const RemoteState& state) {
    Writer writer;
    writer.text("mndrmt3\0");
    for (int eye = 0; eye < 2; ++eye)
        writer.eye(state.eyes ? (*state.eyes)[eye] : RemoteEye{});
    writer.pose(state.stageFromHead);
    writer.flag(state.eyes.has_value());
    writer.zeros(3);
    writer.controller(state.left);
    writer.controller(state.right);
    return writer.finished();
}

RemoteHead::RemoteHead(std::uint16_t port, std::chrono::milliseconds patience) : patience_(patience) {
    const Clock::time_point deadline = Clock::now() + patience;
    // No event tells that another process listens to a port; asking costs nothing.
    while ((socket_ = connectTo(port)) < 0) {
        if (Clock::now() > deadline) failSetting("nobody listens to port " + std::to_string(port));
        poll(nullptr, 0, 2);
    }
    // It greets with the state it starts from and the one it has.
    RemotePacket greeting;
    for (int i = 0; i < 2; ++i)
        receive(greeting.data(), greeting.size());
}

RemoteHead::~RemoteHead() {
    if (socket_ >= 0) close(socket_);
}

void RemoteHead::send(const RemoteState& state) {
    const RemotePacket packet = packetOf(state);
    // Shorter than any socket's buffer, which is empty: the last packet was taken.
    if (::send(socket_, packet.data(), packet.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(packet.size()))
        failSetting("cannot send");
    // As get_monado.sh corrects it, Monado sends back what it took.
    RemotePacket taken;
    receive(taken.data(), taken.size());
    if (taken != packet) throw std::runtime_error("Monado's remote head: took another packet than was sent");
}

void RemoteHead::receive(std::byte* bytes, std::size_t count) {
    const Clock::time_point deadline = Clock::now() + patience_;
    while (count > 0) {
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
        pollfd readable{socket_, POLLIN, 0};
        if (poll(&readable, 1, static_cast<int>(std::max<long>(left, 0))) == 0) {
            errno = ETIMEDOUT;
            failSetting("no answer");
        }
        const ssize_t received = recv(socket_, bytes, count, 0);
        if (received == 0) errno = ECONNRESET;
        if (received < 0 && errno == EINTR) continue;
        if (received <= 0) failSetting("no answer");
        bytes += received;
        count -= static_cast<std::size_t>(received);
    }
}

} // namespace xr
