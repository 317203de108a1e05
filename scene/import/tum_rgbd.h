#pragma once
// RGB-D sequences in the TUM benchmark's layout: rgb.txt, depth.txt and groundtruth.txt list time stamps.
// Sturm, Engelhard, Endres, Burgard, Cremers: "A benchmark for the evaluation of RGB-D SLAM systems", 2012.

#include "scene/import/capture.h"

namespace scene {

/// Appends the colour pictures of a TUM folder that have a depth picture and a pose within 20 ms; the pose is
/// interpolated to the picture's time. Depth steps are 1/5000 m. Intrinsics: intrinsics.txt ("fx fy cx cy [k1 k2 p1 p2
/// k3]", centre of the first pixel at 0, as the benchmark counts) if it is there, else those published for freiburg1, 2
/// and 3 by the folder's name, else the sensor's default; the latter two leave a remark.
void listTumRgbd(const std::filesystem::path& folder, Capture& capture);

} // namespace scene
