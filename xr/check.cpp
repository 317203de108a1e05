#include "xr/check.h"

#include "scene/errors.h"

#include <string>

#include <openxr/openxr_reflection.h>

namespace xr {

namespace {

std::string nameOf(XrResult result) {
    switch (result) {
#define REVISIT_NAME(name, value)                                                                                      \
    case name:                                                                                                         \
        return #name;
        XR_LIST_ENUM_XrResult(REVISIT_NAME)
#undef REVISIT_NAME
                default : return "result " +
                          std::to_string(result);
    }
}

bool isLoss(XrResult result) {
    // A runtime whose service was killed answers with any of these.
    return result == XR_ERROR_INSTANCE_LOST || result == XR_ERROR_SESSION_LOST || result == XR_SESSION_LOSS_PENDING ||
           result == XR_ERROR_RUNTIME_FAILURE || result == XR_ERROR_RUNTIME_UNAVAILABLE;
}

} // namespace

void check(XrResult result, const char* what) {
    if (XR_SUCCEEDED(result) && result != XR_SESSION_LOSS_PENDING) return;
    const std::string text = std::string(what) + " failed (" + nameOf(result) + ")";
    if (isLoss(result)) throw Lost(text);
    throw scene::Failure(text, std::string("OpenXR runtime"), "restart the runtime, or update it");
}

} // namespace xr
