#pragma once
// Libraries of ours that are loaded when they are first needed, since much hangs on them that every start of the
// program would wait for.

namespace scene {

/// A function of a library that lies in the program's run path (lib, beside bin), which stays loaded. Throws Failure
/// that says why there is none.
void* functionOfLibrary(const char* library, const char* function);

} // namespace scene
