#include "app/desk.h"

#include <cmath>
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

namespace {

/// What is said once counts until it is heard, and only then.
void forgetWhatIsSaidOnce(input::DeskSays& says) {
    input::Wants& wants = says.wants;
    wants.turnBy = wants.speedUp = wants.scaleUp = wants.riseBy = 0;
    wants.recentre = wants.home = wants.next = wants.previous = wants.undo = false;
    says.tilt = 0;
    says.commands.reset();
}

double stronger(double a, double b) {
    return std::abs(a) > std::abs(b) ? a : b;
}

} // namespace

void Desk::say(const input::DeskSays& says) {
    const std::scoped_lock lock(mutex_);
    const input::DeskSays before = std::exchange(says_, says);
    now_ = says;
    input::Wants& wants = says_.wants;
    const input::Wants& was = before.wants;
    wants.turnBy += was.turnBy, wants.speedUp += was.speedUp, wants.scaleUp += was.scaleUp;
    wants.riseBy += was.riseBy;
    wants.recentre = wants.recentre || was.recentre, wants.home = wants.home || was.home;
    wants.next = wants.next || was.next, wants.previous = wants.previous || was.previous;
    wants.undo = wants.undo || was.undo;
    says_.tilt += before.tilt;
    says_.commands |= before.commands;
    // A click or a key's stroke may be over before it is heard.
    wants.turn = stronger(wants.turn, was.turn), wants.climb = stronger(wants.climb, was.climb);
    wants.move = {stronger(wants.move.x, was.move.x), stronger(wants.move.y, was.move.y)};
    // Shift means what it meant when the button was pressed.
    if (before.picks) wants.hurries = was.hurries;
    says_.picks = says_.picks || before.picks, says_.teleports = says_.teleports || before.teleports;
}

input::DeskSays Desk::hear() {
    const std::scoped_lock lock(mutex_);
    forgetWhatIsSaidOnce(now_);
    return std::exchange(says_, now_);
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
