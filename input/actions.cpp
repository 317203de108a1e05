#include "input/actions.h"

#include "scene/errors.h"

#include <cmath>
#include <cstring>
#include <vector>

namespace input {

namespace {

/// A stick at rest is not quite at nought.
constexpr double kDeadZone = 0.15;
/// A controller that was switched on is noticed after so many frames.
constexpr unsigned kReadsPerQuestion = 64;
/// The turning stick flies up and down when it is pushed clearly along its other axis.
constexpr double kClimbZone = 0.6;

[[noreturn]] void fail(const char* call, XrResult result) {
    throw scene::Failure(std::string("the runtime takes no controllers: ") + call + " gave " + std::to_string(result),
                         std::string("OpenXR"), "restart the headset's software");
}

void check(XrResult result, const char* call) {
    if (XR_FAILED(result)) fail(call, result);
}

bool isOfHand(Act act) {
    return act <= Act::pick;
}

XrActionType typeOf(Act act) {
    switch (kindOf(act)) {
    case ActKind::pose:
        return XR_ACTION_TYPE_POSE_INPUT;
    case ActKind::stick:
        return XR_ACTION_TYPE_VECTOR2F_INPUT;
    case ActKind::button:
        break;
    }
    return XR_ACTION_TYPE_BOOLEAN_INPUT;
}

double withDeadZone(float value) {
    const double v = static_cast<double>(value);
    if (!(std::abs(v) > kDeadZone)) return 0;
    return std::copysign((std::min(std::abs(v), 1.0) - kDeadZone) / (1 - kDeadZone), v);
}

} // namespace

Actions::Actions(XrInstance instance, const std::function<bool(const char*)>& hasExtension) : instance_(instance) {
    hands_ = {pathOf("/user/hand/left"), pathOf("/user/hand/right")};
    XrActionSetCreateInfo info{};
    info.type = XR_TYPE_ACTION_SET_CREATE_INFO;
    std::strcpy(info.actionSetName, "walking");
    std::strcpy(info.localizedActionSetName, "Walking");
    check(xrCreateActionSet(instance_, &info, &set_), "xrCreateActionSet");
    try {
        makeActions();
        suggest(hasExtension);
    } catch (...) {
        xrDestroyActionSet(set_);
        throw;
    }
}

Actions::~Actions() {
    for (const auto& hands : spaces_)
        for (XrSpace space : hands)
            if (space != XR_NULL_HANDLE) xrDestroySpace(space);
    xrDestroyActionSet(set_); // and its actions
}

XrPath Actions::pathOf(const char* text) const {
    XrPath path = XR_NULL_PATH;
    check(xrStringToPath(instance_, text, &path), "xrStringToPath");
    return path;
}

void Actions::makeActions() {
    for (int i = 0; i < kActs; ++i) {
        const Act act = static_cast<Act>(i);
        XrActionCreateInfo info{};
        info.type = XR_TYPE_ACTION_CREATE_INFO;
        info.actionType = typeOf(act);
        std::strncpy(info.actionName, nameOf(act), sizeof info.actionName - 1);
        std::strncpy(info.localizedActionName, titleOf(act), sizeof info.localizedActionName - 1);
        if (isOfHand(act)) {
            info.countSubactionPaths = kHands;
            info.subactionPaths = hands_.data();
        }
        check(xrCreateAction(set_, &info, &actions_[static_cast<std::size_t>(i)]), "xrCreateAction");
    }
}

void Actions::suggest(const std::function<bool(const char*)>& hasExtension) {
    bool isAnyTaken = false;
    for (const Profile& profile : profiles()) {
        if (profile.extension != nullptr && !hasExtension(profile.extension)) continue;
        std::vector<XrActionSuggestedBinding> bindings;
        for (const Binding& binding : profile.bindings)
            bindings.push_back({action(binding.act), pathOf(binding.path)});
        XrInteractionProfileSuggestedBinding suggestion{};
        suggestion.type = XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING;
        suggestion.interactionProfile = pathOf(profile.path);
        suggestion.countSuggestedBindings = static_cast<std::uint32_t>(bindings.size());
        suggestion.suggestedBindings = bindings.data();
        // A runtime need not know every controller.
        if (XR_SUCCEEDED(xrSuggestInteractionProfileBindings(instance_, &suggestion)))
            isAnyTaken = true;
        else
            refused_ += (refused_.empty() ? "" : ", ") + std::string(profile.title);
    }
    if (!isAnyTaken) fail("xrSuggestInteractionProfileBindings", XR_ERROR_PATH_UNSUPPORTED);
}

void Actions::attach(XrSession session, XrSpace tracking) {
    session_ = session, tracking_ = tracking;
    XrSessionActionSetsAttachInfo info{};
    info.type = XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO;
    info.countActionSets = 1;
    info.actionSets = &set_;
    check(xrAttachSessionActionSets(session_, &info), "xrAttachSessionActionSets");
    for (const Act act : {Act::aim, Act::grip})
        for (std::size_t hand = 0; hand < kHands; ++hand) {
            XrActionSpaceCreateInfo create{};
            create.type = XR_TYPE_ACTION_SPACE_CREATE_INFO;
            create.action = action(act);
            create.subactionPath = hands_[hand];
            create.poseInActionSpace.orientation.w = 1;
            check(xrCreateActionSpace(session_, &create, &space(act, hand)), "xrCreateActionSpace");
        }
}

XrActionStateBoolean Actions::button(Act act, XrPath hand) const {
    XrActionStateGetInfo get{};
    get.type = XR_TYPE_ACTION_STATE_GET_INFO;
    get.action = action(act);
    get.subactionPath = hand;
    XrActionStateBoolean state{};
    state.type = XR_TYPE_ACTION_STATE_BOOLEAN;
    if (XR_FAILED(xrGetActionStateBoolean(session_, &get, &state)) || !state.isActive) return {};
    return state;
}

bool Actions::isHeld(Act act, std::size_t hand) const {
    return button(act, hands_[hand]).currentState == XR_TRUE;
}

bool Actions::isHeld(Act act) const {
    return button(act, XR_NULL_PATH).currentState == XR_TRUE;
}

bool Actions::wasPressed(Act act) const {
    const XrActionStateBoolean state = button(act, XR_NULL_PATH);
    return state.currentState == XR_TRUE && state.changedSinceLastSync == XR_TRUE;
}

glm::dvec2 Actions::stick(Act act) const {
    XrActionStateGetInfo get{};
    get.type = XR_TYPE_ACTION_STATE_GET_INFO;
    get.action = action(act);
    XrActionStateVector2f state{};
    state.type = XR_TYPE_ACTION_STATE_VECTOR2F;
    if (XR_FAILED(xrGetActionStateVector2f(session_, &get, &state)) || !state.isActive) return glm::dvec2(0);
    return {withDeadZone(state.currentState.x), withDeadZone(state.currentState.y)};
}

bool Actions::locate(Act act, std::size_t hand, XrTime time, scene::Pose& trackingFromHand) {
    XrSpaceLocation location{};
    location.type = XR_TYPE_SPACE_LOCATION;
    constexpr XrSpaceLocationFlags kValid =
        XR_SPACE_LOCATION_POSITION_VALID_BIT | XR_SPACE_LOCATION_ORIENTATION_VALID_BIT;
    if (XR_FAILED(xrLocateSpace(space(act, hand), tracking_, time, &location)) ||
        (location.locationFlags & kValid) != kValid)
        return false;
    const auto& [q, p] = location.pose;
    trackingFromHand = scene::poseFromQuaternion({p.x, p.y, p.z}, q.x, q.y, q.z, q.w);
    return true;
}

void Actions::readHand(std::size_t hand, XrTime time, Hand& said) {
    const bool isAimed = locate(Act::aim, hand, time, said.trackingFromAim);
    said.isTracked = locate(Act::grip, hand, time, said.trackingFromGrip) && isAimed;
    said.teleports = isHeld(Act::teleport, hand);
    said.grabs = isHeld(Act::grab, hand);
    said.picks = isHeld(Act::pick, hand);
}

void Actions::read(XrTime time, Wants& wants) {
    const XrActiveActionSet active{set_, XR_NULL_PATH};
    XrActionsSyncInfo info{};
    info.type = XR_TYPE_ACTIONS_SYNC_INFO;
    info.countActiveActionSets = 1;
    info.activeActionSets = &active;
    if (xrSyncActions(session_, &info) != XR_SUCCESS) return; // no focus, or no session any more
    if (reads_++ % kReadsPerQuestion == 0) askForControllers();

    for (std::size_t hand = 0; hand < kHands; ++hand)
        readHand(hand, time, wants.hands[hand]);
    wants.move += stick(Act::move);
    const glm::dvec2 turn = stick(Act::turn);
    wants.turn += turn.x;
    if (std::abs(turn.y) > kClimbZone && std::abs(turn.x) < std::abs(turn.y) / 2) wants.climb += turn.y;
    wants.hurries = wants.hurries || isHeld(Act::hurry);
    wants.recentre = wants.recentre || wasPressed(Act::recentre);
    wants.home = wants.home || wasPressed(Act::home);
    wants.next = wants.next || wasPressed(Act::next);
    wants.previous = wants.previous || wasPressed(Act::previous);
    wants.undo = wants.undo || wasPressed(Act::undo);
}

void Actions::askForControllers() {
    for (std::size_t hand = 0; hand < kHands; ++hand) {
        controllers_[hand].clear();
        XrInteractionProfileState state{};
        state.type = XR_TYPE_INTERACTION_PROFILE_STATE;
        if (XR_FAILED(xrGetCurrentInteractionProfile(session_, hands_[hand], &state)) ||
            state.interactionProfile == XR_NULL_PATH)
            continue;
        char text[XR_MAX_PATH_LENGTH] = {};
        std::uint32_t length = 0;
        if (XR_FAILED(xrPathToString(instance_, state.interactionProfile, sizeof text, &length, text))) continue;
        controllers_[hand] = text;
        for (const Profile& profile : profiles())
            if (controllers_[hand] == profile.path) controllers_[hand] = profile.title;
    }
}

} // namespace input
