#pragma once
// Results of OpenXR calls: what nobody can go on from becomes a failure in words, a lost runtime something to catch.

#include <openxr/openxr.h>

#include <stdexcept>

namespace xr {

/// The runtime or the session is gone; the program need not be.
struct Lost : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Throws Lost if the runtime, the instance or the session is gone, scene::Failure for other errors; what: the call.
void check(XrResult result, const char* what);

} // namespace xr
