#pragma once
// The photographs that stand beside scans in a file: which of them can be used, and which scan each belongs to.

#include "scene/image.h"
#include "scene/import/capture.h"

#include <span>

namespace scene {

/// Pinholes with a pose that belong to a scan: the one they name, else the one that stands nearest; either must stand
/// within kBesideMetres. scans: those of the same file, the first of which is capture.scans[firstScan]. Of what cannot
/// be used remarks gets a sentence for each kind, and of scans without a photograph, if others have some.
std::vector<ScanPhoto> listScanPhotos(const std::filesystem::path& path, std::span<const ScanSource> scans,
                                      std::size_t firstScan, std::vector<std::string>& remarks);

/// A photograph that stands farther from every scanner has seen what none of them saw.
inline constexpr double kBesideMetres = 0.5;

/// The picture as it was taken. Failure: no picture, or of another size than its camera.
Image<Rgb8> readScanPhoto(const ScanPhoto& photo);

/// Gives all photographs of scans the camera and lens of a file (scene/import/camera_file.h). Failure: there are none,
/// or one has another size.
void useCameraFile(Capture& capture, const std::filesystem::path& file);

} // namespace scene
