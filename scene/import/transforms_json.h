#pragma once
// RGB-D captures listed by a transforms.json as nerfstudio writes it: intrinsics for all frames or for each, poses as
// camera-to-world with OpenGL axes (x right, y up, z back), depth files beside the pictures.

#include "scene/import/capture.h"

namespace scene {

/// Appends the frames of the manifest. Frames without a depth file and unusable poses are a Failure that names the
/// frame.
void listTransformsJson(const std::filesystem::path& manifest, Capture& capture);

} // namespace scene
