#pragma once
// What a capture consists of, read from its headers and manifests alone; pixels and points are read one item
// at a time, so that a capture of any size streams through the build.

#include "scene/camera.h"
#include "scene/distortion.h"
#include "scene/pose.h"
#include "scene/scanner_model.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace scene {

/// A photograph with its registered depth: two picture files. depthUnitMetres is what a depth value of 1 means; nothing
/// if the capture does not say: a millimetre in pictures of 16 bit steps, a metre in those of floats.
struct PhotoSource {
    std::string name; ///< unique within the capture
    std::filesystem::path colourPath, depthPath;
    Camera camera;
    Distortion distortion;
    Pose worldFromCamera;
    std::optional<double> depthUnitMetres;
};

enum class ScanFormat { e57, ptx };

/// One scan within a scan file.
struct ScanSource {
    std::string name; ///< unique within the capture
    std::filesystem::path path;
    ScanFormat format = ScanFormat::e57;
    int indexInFile = 0;
    std::uint64_t byteInFile = 0; ///< where its header starts (PTX); 0 otherwise
    Pose worldFromScanner;
    /// Where registration found it to stand; the file's own pose is then not used.
    std::optional<Pose> registeredWorldFromScanner = std::nullopt;
    /// Of a calibrated scanner: its points are computed anew.
    std::optional<ScannerReading> reading = std::nullopt;
    std::int64_t pointCount = 0; ///< as the file says, invalid ones included
    int rows = 0, columns = 0;   ///< 0: unstructured
};

/// A photograph that stands beside a scan in its file: it has no range of its own, but the scan has.
struct ScanPhoto {
    std::string name; ///< unique within the capture
    std::filesystem::path path;
    int indexInFile = 0;
    Camera camera;
    Distortion distortion; ///< E57 has no field for it; a camera file may (scene/import/camera_file.h)
    Pose worldFromCamera;  ///< as the file says, beside the scan's pose as the file says
    std::size_t scan = 0;  ///< index of its scan within the capture
};

struct Capture {
    std::vector<PhotoSource> photos;
    std::vector<ScanSource> scans;
    std::vector<ScanPhoto> scanPhotos;           ///< those of a scan one after another
    std::vector<std::filesystem::path> polygons; ///< scenes to be ray-traced
    std::vector<std::string> remarks;            ///< what was seen but cannot be used, in whole sentences for the user

    /// Neither scans nor polygons: those have their range and their colours from one place.
    bool isOfPhotographsAlone() const { return scans.empty() && polygons.empty(); }
};

} // namespace scene
