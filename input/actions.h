#pragma once
// What controllers say, through OpenXR: one action set, and bindings suggested for the controllers people have
// (input/bindings.h).

#include "input/bindings.h"
#include "input/wants.h"

#include <openxr/openxr.h>

#include <array>
#include <functional>
#include <string>

namespace input {

/// Lives between an instance and a session: made after the instance, attached once to each session. Instance, session
/// and space must outlive it. A session that is lost says nothing more; whoever waits for its frames learns why.
class Actions {
  public:
    /// hasExtension: whether the instance was made with it. Throws scene::Failure if the runtime takes no actions.
    Actions(XrInstance instance, const std::function<bool(const char*)>& hasExtension);
    ~Actions();
    Actions(const Actions&) = delete;
    Actions& operator=(const Actions&) = delete;

    /// Before the session's first frame. tracking: the space of wants.h.
    void attach(XrSession session, XrSpace tracking);

    /// Adds to wants what the controllers say, with the hands where they will be at that time. Without focus, nothing.
    void read(XrTime time, Wants& wants);

    /// What each hand holds; empty: nothing that is known. Asked anew now and then by read.
    const std::string& controller(std::size_t hand) const { return controllers_[hand]; }

    /// Profiles the runtime refused, though it has what they need: for the curious.
    const std::string& refusedProfiles() const { return refused_; }

  private:
    void makeActions();
    void suggest(const std::function<bool(const char*)>& hasExtension);
    XrPath pathOf(const char* text) const;
    XrAction action(Act act) const { return actions_[static_cast<std::size_t>(act)]; }
    XrSpace& space(Act act, std::size_t hand) { return spaces_[act == Act::aim ? 0 : 1][hand]; }
    bool isHeld(Act act, std::size_t hand) const;
    bool isHeld(Act act) const;
    /// True in the one frame in which it was pressed.
    bool wasPressed(Act act) const;
    glm::dvec2 stick(Act act) const;
    bool locate(Act act, std::size_t hand, XrTime time, scene::Pose& trackingFromHand);
    void readHand(std::size_t hand, XrTime time, Hand& said);
    void askForControllers();
    XrActionStateBoolean button(Act act, XrPath hand) const;

    XrInstance instance_ = XR_NULL_HANDLE;
    XrSession session_ = XR_NULL_HANDLE;
    XrSpace tracking_ = XR_NULL_HANDLE;
    XrActionSet set_ = XR_NULL_HANDLE;
    std::array<XrAction, kActs> actions_{};
    std::array<XrPath, kHands> hands_{};
    std::array<std::array<XrSpace, kHands>, 2> spaces_{}; ///< aim, grip
    std::array<std::string, kHands> controllers_;
    std::string refused_;
    unsigned reads_ = 0; ///< that had the focus
};

} // namespace input
