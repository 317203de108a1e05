#pragma once
// E57 (ASTM E2807) read: its scans, one at a time, and the photographs that stand beside them.

#include "scene/camera.h"
#include "scene/image.h"
#include "scene/import/capture.h"
#include "scene/scan.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace scene {

/// The scans of a file by its headers alone; no point is read. rows and columns are what the header says of
/// the grid. remarks gets a sentence for each thing that cannot be used (a scan without coordinates,
/// photographs without a pose). Failure: not an E57 file, damaged, a pose that is none.
std::vector<ScanSource> listE57(const std::filesystem::path& path, std::vector<std::string>& remarks);

/// One scan. Cartesian and spherical coordinates of any number type; colour scaled to 8 bit by the file's
/// limits, else intensity in grey, else mid-grey. Points that the file marks invalid and points that are not
/// finite are counted, not kept. Points with a national grid's offsets inside are moved near an origin of
/// their own (local_origin.h), and are then unstructured, for the grid's angles were about a scanner whose
/// place the file does not tell. Failure: as listE57, and a count of points that the file's bytes cannot
/// hold.
Scan readE57Scan(const ScanSource& source);

/// The same with the intensities as the file has them; NaN where it marks one invalid.
ScanWithIntensity readE57ScanWithIntensity(const ScanSource& source);

enum class E57ImageKind { visualReference, pinhole, spherical, cylindrical };

/// A photograph embedded in the file. camera is a pinhole's; the others have angular pixels instead.
struct E57Image {
    std::string name; ///< unique within the file
    std::filesystem::path path;
    int indexInFile = 0;
    E57ImageKind kind = E57ImageKind::visualReference;
    int width = 0, height = 0; ///< as the header says
    bool hasPose = false;      ///< a visual reference has none
    Pose worldFromCamera;      ///< pinhole: x right, y down, z forward; others: the file's own axes (x forward, z
                               ///< up)
    Camera camera;             ///< pinhole; all 0 where the header's numbers make no camera
    double pixelWidthRadians = 0,
           pixelHeightRadians = 0; ///< spherical; cylindrical has pixelWidthRadians alone
    std::int64_t byteCount = 0;    ///< of the encoded picture; proved against the file's size
    std::optional<int> scanInFile; ///< the scan that it says it belongs to, as ScanSource::indexInFile
};

/// The photographs of a file, by its headers alone. Failure: as listE57, and a picture longer than the file.
std::vector<E57Image> listE57Images(const std::filesystem::path& path);

/// The encoded picture (JPEG or PNG), byte for byte.
std::vector<std::uint8_t> readE57ImageBytes(const E57Image& image);

/// The picture, decoded. Failure: its bytes are no picture.
Image<Rgb8> readE57Image(const E57Image& image);

} // namespace scene
