#include "app/desk.h"

#include <utility>

namespace app {

Knobs Desk::knobs() const {
    const std::scoped_lock lock(mutex_);
    return knobs_;
}

void Desk::turn(const Knobs& knobs) {
    const std::scoped_lock lock(mutex_);
    knobs_ = knobs;
}

void Desk::say(const input::DeskSays& says) {
    const std::scoped_lock lock(mutex_);
    input::DeskSays sum = says;
    const input::Wants& before = says_.wants;
    input::Wants& wants = sum.wants;
    // What is held counts as it is now; what was said once, until it was heard.
    wants.turnBy += before.turnBy, wants.speedUp += before.speedUp, wants.scaleUp += before.scaleUp;
    wants.riseBy += before.riseBy;
    wants.recentre = wants.recentre || before.recentre, wants.home = wants.home || before.home;
    wants.next = wants.next || before.next, wants.previous = wants.previous || before.previous;
    wants.undo = wants.undo || before.undo;
    // A click may be over before it is heard.
    picksNow_ = says.picks, teleportsNow_ = says.teleports;
    sum.picks = says.picks || says_.picks, sum.teleports = says.teleports || says_.teleports;
    sum.tilt += says_.tilt;
    sum.commands |= says_.commands;
    says_ = sum;
}

input::DeskSays Desk::hear() {
    const std::scoped_lock lock(mutex_);
    const input::DeskSays heard = says_;
    input::Wants& wants = says_.wants;
    wants.turnBy = wants.speedUp = wants.scaleUp = wants.riseBy = 0;
    wants.recentre = wants.home = wants.next = wants.previous = wants.undo = false;
    says_.picks = picksNow_, says_.teleports = teleportsNow_;
    says_.tilt = 0;
    says_.commands.reset();
    return heard;
}

void Desk::show(render::FramePictures& pictures) {
    const std::scoped_lock lock(mutex_);
    std::swap(pictures_, pictures);
    hasPictures_ = true;
    wantsPicture_ = false;
}

bool Desk::take(render::FramePictures& pictures) {
    const std::scoped_lock lock(mutex_);
    if (!hasPictures_) return false;
    std::swap(pictures_, pictures);
    hasPictures_ = false;
    return true;
}

void Desk::tell(const WalkFacts& facts) {
    const std::scoped_lock lock(mutex_);
    facts_ = facts;
}

WalkFacts Desk::facts() const {
    const std::scoped_lock lock(mutex_);
    return facts_;
}

} // namespace app
