#pragma once
// PTX (Leica's text format for scans on a grid) read: several clouds in a file, each with ten header lines.
//
//     columns                          the number of columns, then of rows; points stand column by column
//     rows
//     x y z                            the scanner's place
//     x y z  (three lines)             the scanner's axes
//     4 x 4 numbers (four lines)       worldFromPoints, for row vectors: the translation is the LAST line
//     x y z [intensity [r g b]]        columns * rows of them; 0 0 0 is no return; intensity 0..1, colour
//     0..255
//
// Points are about the scanner in most files. Where the 4 x 4 is the identity and the scanner's place is not
// the origin, they are in the world already and are brought back about the scanner.

#include "scene/import/capture.h"
#include "scene/scan.h"

#include <filesystem>
#include <string>
#include <vector>

namespace scene {

/// The clouds of a file, found by its headers and by counting lines. A uniform scale in a transform is taken into the
/// points unless it is so near 1 that it may be rounding; a remark tells of either. Failure: not PTX, cut off, a
/// transform that is no rigid motion, counts that the file's bytes cannot hold.
std::vector<ScanSource> listPtx(const std::filesystem::path& path, std::vector<std::string>& remarks);

/// One cloud. Points without return are absent; points that are not finite are counted in invalidPoints.
/// Points with a national grid's offsets inside are treated as in e57.h. Failure: as listPtx, and a line that
/// is not numbers.
Scan readPtxScan(const ScanSource& source);

} // namespace scene
