#include "input/locomotion.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <glm/geometric.hpp>

namespace input {

namespace {

constexpr double kDegree = std::numbers::pi / 180;

/// After a pause, as if only so much had passed: nobody is carried on unseen.
constexpr double kLongestStep = 0.1;
/// A stick turns once when it passes the first, and again only after it was below the second.
constexpr double kSnapAt = 0.7, kArmedBelow = 0.3;
constexpr double kSpeedStep = 1.5, kSlowest = 0.05, kFastest = 200;
constexpr double kScaleStep = 1.1, kSmallestScale = 1e-3, kLargestScale = 1e4;
/// Hands nearer to each other than this, horizontally, neither turn nor scale.
constexpr double kHandsApart = 0.05;

bool isFinite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

bool isFinite(const scene::Pose& pose) {
    return isFinite(pose.translation) && isFinite(pose.rotation[0]) && isFinite(pose.rotation[1]) &&
           isFinite(pose.rotation[2]);
}

double finiteOr0(double value) {
    return std::isfinite(value) ? value : 0;
}

bool isUsable(const Hand& hand) {
    return hand.isTracked && isFinite(hand.trackingFromAim) && isFinite(hand.trackingFromGrip);
}

Rig withScale(const Rig& rig, double scale, const glm::dvec3& fixedInTracking) {
    Rig result = rig;
    result.scale = std::clamp(scale, kSmallestScale, kLargestScale);
    result.origin += rig.toWalk(fixedInTracking) - result.toWalk(fixedInTracking);
    return result;
}

/// Two points of tracking space are brought to two of walk space, as nearly as turning about the vertical, scaling and
/// moving can: exactly in the horizontal, on average in height.
Rig broughtTo(const Rig& rig, const std::array<glm::dvec3, 2>& inTracking, const std::array<glm::dvec3, 2>& inWalk) {
    const glm::dvec3 from = inTracking[1] - inTracking[0], to = inWalk[1] - inWalk[0];
    const double fromLength = std::hypot(from.x, from.z), toLength = std::hypot(to.x, to.z);
    Rig result = rig;
    if (fromLength > kHandsApart && toLength > kHandsApart * rig.scale) {
        result.scale = std::clamp(toLength / fromLength, kSmallestScale, kLargestScale);
        // A turn to the left by yaw takes x towards -z.
        result.yaw = std::remainder(std::atan2(-to.z, to.x) - std::atan2(-from.z, from.x), 2 * std::numbers::pi);
    }
    result.origin += (inWalk[0] + inWalk[1] - result.toWalk(inTracking[0]) - result.toWalk(inTracking[1])) / 2.0;
    return result;
}

void grab(Locomotion& state, const Wants& wants) {
    std::array<bool, kHands> grabs{};
    bool hasChanged = false;
    for (std::size_t i = 0; i < kHands; ++i) {
        grabs[i] = wants.hands[i].grabs && isUsable(wants.hands[i]);
        hasChanged = hasChanged || grabs[i] != state.held[i].has_value();
    }
    if (hasChanged) {
        // One hand more or less: what each holds is where each is now, so that nothing jumps.
        for (std::size_t i = 0; i < kHands; ++i) {
            state.held[i].reset();
            if (grabs[i]) state.held[i] = state.rig.toWalk(wants.hands[i].trackingFromGrip.translation);
        }
        return;
    }
    if (grabs[0] && grabs[1]) {
        state.rig = broughtTo(
            state.rig, {wants.hands[0].trackingFromGrip.translation, wants.hands[1].trackingFromGrip.translation},
            {*state.held[0], *state.held[1]});
        return;
    }
    for (std::size_t i = 0; i < kHands; ++i)
        if (grabs[i])
            state.rig.origin += *state.held[i] - state.rig.toWalk(wants.hands[i].trackingFromGrip.translation);
}

/// Returns whether it turned smoothly.
bool turn(Locomotion& state, const Wants& wants, const LocomotionSettings& settings, double seconds) {
    const glm::dvec3& head = wants.trackingFromHead.translation;
    const double stick = std::clamp(finiteOr0(wants.turn), -1.0, 1.0);
    const double by = finiteOr0(wants.turnBy);
    if (by != 0) state.rig = turned(state.rig, -by, head);
    if (settings.snapDegrees > 0) {
        if (std::abs(stick) < kArmedBelow) state.isTurnArmed = true;
        if (state.isTurnArmed && std::abs(stick) > kSnapAt) {
            state.isTurnArmed = false;
            state.rig = turned(state.rig, -std::copysign(settings.snapDegrees * kDegree, stick), head);
        }
        return false;
    }
    if (stick != 0) state.rig = turned(state.rig, -stick * settings.turnDegreesPerSecond * kDegree * seconds, head);
    return stick != 0;
}

/// Returns whether it moved.
bool move(Locomotion& state, const Wants& wants, const LocomotionSettings& settings, double seconds) {
    glm::dvec2 stick{finiteOr0(wants.move.x), finiteOr0(wants.move.y)};
    const double length = glm::length(stick);
    if (length > 1) stick /= length;
    const double climb = std::clamp(finiteOr0(wants.climb), -1.0, 1.0);
    if (length == 0 && climb == 0) return false;
    const glm::dmat3 head = state.rig.rotation() * wants.trackingFromHead.rotation;
    const double heading = headingOf(head);
    const glm::dvec3 right{std::cos(heading), 0, -std::sin(heading)};
    const glm::dvec3 ahead = settings.flies ? -head[2] : glm::dvec3{-std::sin(heading), 0, -std::cos(heading)};
    const double speed = speedOf(state, settings) * (wants.hurries ? settings.hurryFactor : 1.0);
    state.rig.origin += (right * stick.x + ahead * stick.y + glm::dvec3{0, climb, 0}) * (speed * seconds);
    return true;
}

void changeSize(Locomotion& state, const Wants& wants) {
    state.speedFactor = std::clamp(state.speedFactor * std::pow(kSpeedStep, finiteOr0(wants.speedUp)), 0.01, 100.0);
    state.rig.origin.y += finiteOr0(wants.riseBy) * state.rig.scale;
    if (finiteOr0(wants.scaleUp) == 0) return;
    const glm::dvec3& head = wants.trackingFromHead.translation;
    state.rig = withScale(state.rig, state.rig.scale * std::pow(kScaleStep, -wants.scaleUp), {head.x, 0, head.z});
}

void teleport(Locomotion& state, const Wants& wants, const LocomotionSettings& settings,
              const Surroundings& surroundings) {
    const std::optional<TeleportTarget> shown = state.target;
    state.target.reset();
    for (std::size_t i = 0; i < kHands; ++i) {
        const Hand& hand = wants.hands[i];
        const bool was = std::exchange(state.wasTeleporting[i], hand.teleports && isUsable(hand));
        if (was && !state.wasTeleporting[i] && shown && shown->hand == i && shown->isAllowed && !hand.teleports) {
            const double heading = headingOf(state.rig.rotation() * wants.trackingFromHead.rotation);
            state.rig = rigWithFeetAt(wants.trackingFromHead, shown->to, heading, state.rig.scale);
        }
        if (!state.wasTeleporting[i] || state.target) continue;
        const scene::Pose walkFromAim = state.rig.toWalk(hand.trackingFromAim);
        const glm::dvec3 direction = glm::normalize(-walkFromAim.rotation[2]);
        const double reach = settings.reachMetres * state.rig.scale;
        TeleportTarget target{i, walkFromAim.translation, walkFromAim.translation + reach * direction, false};
        const std::optional<Surface> surface =
            surroundings.hit ? surroundings.hit(walkFromAim.translation, direction) : std::nullopt;
        if (surface && isFinite(surface->position)) {
            target.to = surface->position;
            target.isAllowed = glm::distance(target.from, target.to) <= reach &&
                               surface->normal.y >= std::cos(settings.steepestDegrees * kDegree);
        }
        state.target = target;
    }
}

void jump(Locomotion& state, const Wants& wants, const Surroundings& surroundings) {
    const scene::Pose& head = wants.trackingFromHead;
    if (wants.recentre) {
        // Wherever the wearer has drifted to in the room: the head comes to the rig's own place and heading.
        const glm::dvec3 now = state.rig.toWalk(head.translation);
        state.rig =
            rigWithHeadAt(head, {state.rig.origin.x, now.y, state.rig.origin.z}, state.rig.yaw, state.rig.scale);
    }
    if (wants.home) {
        state.rig = rigWithFeetAt(head, surroundings.homeFeet, surroundings.homeHeading, 1);
        state.capture.reset();
    }
    const std::size_t count = surroundings.captures.size();
    if (count > 0 && wants.next != wants.previous) {
        const std::size_t last = state.capture.value_or(wants.next ? count - 1 : 0) % count;
        state.capture = (last + (wants.next ? 1 : count - 1)) % count;
        const scene::Pose& place = surroundings.captures[*state.capture];
        state.rig = rigWithHeadAt(head, place.translation, headingOf(place.rotation), 1);
    }
}

void narrow(Locomotion& state, bool isMoving, const LocomotionSettings& settings, double seconds) {
    const double wanted = isMoving && settings.hasVignette ? 1 : 0;
    const double time = wanted > state.vignette ? settings.vignetteRiseSeconds : settings.vignetteFallSeconds;
    state.vignette = wanted + (state.vignette - wanted) * std::exp(-seconds / std::max(time, 1e-3));
    if (wanted == 0 && state.vignette < 0.01) state.vignette = 0;
}

} // namespace

double speedOf(const Locomotion& state, const LocomotionSettings& settings) {
    return std::clamp(settings.metresPerSecond * state.speedFactor, kSlowest, kFastest) * state.rig.scale;
}

Locomotion step(const Locomotion& before, const Wants& wants, const LocomotionSettings& settings,
                const Surroundings& surroundings) {
    Locomotion state = before;
    if (!isFinite(wants.trackingFromHead)) return state;
    const double seconds = std::clamp(finiteOr0(wants.seconds), 0.0, kLongestStep);
    grab(state, wants);
    const bool isTurning = turn(state, wants, settings, seconds);
    const bool isGoing = move(state, wants, settings, seconds);
    changeSize(state, wants);
    teleport(state, wants, settings, surroundings);
    jump(state, wants, surroundings);
    narrow(state, isTurning || isGoing, settings, seconds);
    // After a jump the hands hold what is before them now, and not the world they left.
    if (wants.recentre || wants.home || wants.next || wants.previous) state.held = {};
    return state;
}

} // namespace input
