#include "xr/desktop.h"

#include "xr/convert.h"

#include <algorithm>
#include <cmath>

namespace xr {

namespace {

constexpr double kSteepest = 1.5; ///< radians

} // namespace

Desktop::Desktop(const DesktopOptions& options) : now_(options), wanted_(options) {}

Frame Desktop::begin() {
    Frame frame;
    double tilt = 0;
    {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return isAsked_ || isClosed_; });
        isAsked_ = false;
        if (isClosed_) {
            frame.kind = Frame::Kind::end;
            return frame;
        }
        now_ = wanted_;
        tilt = tilt_;
    }
    frame.kind = Frame::Kind::draw;
    frame.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    const double s = std::sin(tilt), c = std::cos(tilt);
    frame.trackingFromHead = {glm::dmat3(1, 0, 0, 0, c, s, 0, -s, c), {0, now_.eyeHeightMetres, 0}};

    const double focal = now_.height / (2 * std::tan(now_.fieldOfViewRadians / 2));
    const scene::Camera camera{now_.width, now_.height, focal, focal, now_.width / 2.0, now_.height / 2.0};
    const scene::Pose trackingFromEye = frame.trackingFromHead * scene::headFromCamera();
    frame.eyes.fill({camera, trackingFromEye});
    if (now_.eyes == 2) {
        const auto [left, right] = scene::eyesOf(camera, trackingFromEye, now_.eyeDistanceMetres);
        frame.eyes = {left, right};
    }
    return frame;
}

void Desktop::resize(int width, int height, int eyes, double eyeHeightMetres) {
    const std::scoped_lock lock(mutex_);
    wanted_.width = std::max(width, 1), wanted_.height = std::max(height, 1);
    wanted_.eyeHeightMetres = eyeHeightMetres;
    wanted_.eyes = std::clamp(eyes, 1, static_cast<int>(kEyes));
}

void Desktop::ask() {
    {
        const std::scoped_lock lock(mutex_);
        isAsked_ = true;
    }
    changed_.notify_one();
}

void Desktop::tilt(double radians) {
    const std::scoped_lock lock(mutex_);
    tilt_ = std::clamp(tilt_ + radians, -kSteepest, kSteepest);
}

void Desktop::close() {
    {
        const std::scoped_lock lock(mutex_);
        isClosed_ = true;
    }
    changed_.notify_one();
}

} // namespace xr
