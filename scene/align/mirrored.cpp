#include "scene/align/mirrored.h"

namespace scene {

ScanView mirrored(const ScanView& view) {
    ScanView result = view;
    const int width = view.panorama.width();
    for (int y = 0; y < view.panorama.height(); ++y)
        for (int x = 0; x < width; ++x) {
            // Azimuth a becomes pi - a.
            PanoramaCell& cell = result.panorama.cells((3 * width / 2 - 1 - x) % width, y);
            cell = view.panorama.cells(x, y);
            cell.point.x = -cell.point.x;
            cell.normal.x = -cell.normal.x;
        }
    for (ScanPlane& plane : result.planes) {
        plane.normal.x = -plane.normal.x;
        plane.middle.x = -plane.middle.x;
        for (int axis = 1; axis < 3; ++axis)
            plane.covariance[0][axis] = -plane.covariance[0][axis],
            plane.covariance[axis][0] = -plane.covariance[axis][0];
    }
    lookAbout(result.panorama);
    listPlanes(result);
    return result;
}

bool isMirrorOf(const ScanView& a, const ScanView& b, const PairOptions& options) {
    return registerPair(a, mirrored(b), std::nullopt, options).verdict == PairVerdict::registered;
}

} // namespace scene
