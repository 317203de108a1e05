#pragma once
// The panel over the window: what the walk costs, and every knob (Dear ImGui).

#include "app/desk.h"

#include <array>

namespace app {

/// What concerns the window alone.
struct PanelState {
    bool isOpen = true;
    bool isFilming = false;
    /// Where it was last drawn, in the window: x, y, width, height; nothing while it is closed.
    std::array<float, 4> area{};
    bool startsHere = false; ///< said once: walks through this scene begin here
    enum class View { walker, left, both } view = View::walker;
};

/// Between ImGui's frames. Changes state and knobs as its user says.
void drawPanel(const WalkFacts& facts, PanelState& state, Knobs& knobs);

} // namespace app
