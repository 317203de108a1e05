#pragma once
// The window at the desk: shows what the walker sees, hears keys and mouse, keeps pictures and films.

#include "app/desk.h"

#include "xr/desktop.h"
#include "xr/window.h"

namespace app {

enum class DeskEnd {
    walkOver,
    windowClosed, ///< by the button in its frame: whoever wears a headset may walk on
    left          ///< by the key: the walk is to end
};

/// Until the walk is over or the window is closed; in the thread that runs main. desktop is told of the window's size,
/// of the pictures that are wanted, and in the end that it is over.
DeskEnd runDeskWindow(xr::Window& window, Desk& desk, xr::Desktop& desktop);

} // namespace app
