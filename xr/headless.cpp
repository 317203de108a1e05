#include "xr/headless.h"

#include "xr/convert.h"

#include <cmath>

namespace xr {

Headless::Headless(Path path, const HeadlessOptions& options) : path_(std::move(path)), options_(options) {
    const double focal = options.width / (2 * std::tan(options.fieldOfViewRadians / 2));
    camera_ = {options.width, options.height, focal, focal, options.width / 2.0, options.height / 2.0};
}

Frame Headless::begin() {
    Frame frame;
    frame.seconds = static_cast<double>(frame_) / options_.framesPerSecond;
    const std::optional<scene::Pose> head = path_(frame.seconds);
    if (!head) {
        frame.kind = Frame::Kind::end;
        return frame;
    }
    ++frame_;
    frame.kind = Frame::Kind::draw;
    frame.trackingFromHead = *head;
    const auto [left, right] = scene::eyesOf(camera_, *head * scene::headFromCamera(), options_.eyeDistanceMetres);
    frame.eyes = {left, right};
    return frame;
}

} // namespace xr
