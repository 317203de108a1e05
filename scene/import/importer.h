#pragma once
// The door to other people's formats: what the user names -> what the capture consists of.

#include "scene/import/capture.h"

#include <span>

namespace scene {

/// Lists everything in the inputs, reading headers and manifests only. An input is a transforms.json or a folder with
/// one, a folder in TUM layout, an .e57 or a .ptx file, or, alone, a polygon scene. Names are made unique. Throws
/// Failure for anything else.
Capture openCapture(std::span<const std::filesystem::path> inputs);

/// Which photos --hold-out keeps out of the scene: "every:N:FIRST" (each N-th, counted over the photos, from FIRST on)
/// or a text file with a name on each line. Returns their indices, ascending. Throws Failure for a name the capture has
/// not.
std::vector<std::size_t> findHeldOut(const Capture& capture, const std::string& rule);

} // namespace scene
