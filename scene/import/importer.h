#pragma once
// The door to other people's formats: what the user names -> what the capture consists of.

#include "scene/import/capture.h"

#include <span>

namespace scene {

/// Lists everything in the inputs, reading headers and manifests only. An input is a transforms.json or a folder with
/// one, a folder in TUM layout, an .e57 or a .ptx file, or, alone, a polygon scene. Names are made unique. Throws
/// Failure for anything else, and for cameras and places that no capture has: a field of view of hairs or of half the
/// sky, a centre far outside of the picture, farther off than any coordinates of the earth are. (Photographs beside
/// scans are then left out instead.)
Capture openCapture(std::span<const std::filesystem::path> inputs);

/// Indices into the capture's photos and scanPhotos, ascending.
struct HeldOut {
    std::vector<std::size_t> photos, scanPhotos;
    bool empty() const { return photos.empty() && scanPhotos.empty(); }
};

/// Which photographs --hold-out keeps out of the scene: "every:N:FIRST" (each N-th, counted over the photos and then
/// over those beside scans, from FIRST on) or a text file with a name on each line: the image's, or as the picture's
/// file is called, with or without extension. Throws Failure for a name the capture has not.
HeldOut findHeldOut(const Capture& capture, const std::string& rule);

} // namespace scene
