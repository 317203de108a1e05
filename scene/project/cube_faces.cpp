#include "scene/project/cube_faces.h"

#include "scene/project/cube_layout.h"
#include "scene/project/grid_mesh.h"
#include "scene/project/loose_points.h"
#include "scene/project/pixel_clusters.h"
#include "scene/project/scan_grid.h"

#include <algorithm>
#include <cassert>

#include <glm/matrix.hpp>
#include <tbb/parallel_for.h>

namespace scene {
namespace {

DepthImage emptyFace(const Scan& scan, const CubeFrame& frame, int face, const Camera& camera) {
    DepthImage image;
    image.name = scan.name + "-" + kFaceNames[static_cast<std::size_t>(face)];
    image.camera = camera;
    const Pose scannerFromFace{glm::transpose(frame.faceFromScanner[static_cast<std::size_t>(face)]),
                               frame.copInScanner};
    image.worldFromCamera = scan.worldFromScanner * scannerFromFace;
    image.colour = Image<Rgb8>(camera.width, camera.height);
    image.disparity = Image<float>(camera.width, camera.height);
    image.flags = Image<std::uint8_t>(camera.width, camera.height, kNoSurface);
    return image;
}

// The mesh's disparity and colour at the pixel centres.
void paintMesh(const Scan& scan, const ScanGrid& grid, const CubeFrame& frame, int face, const Image<MeshPixel>& mesh,
               DepthImage& image) {
    const std::uint8_t flags = scan.hasColour ? std::uint8_t{0} : std::uint8_t{kNoColour};
    tbb::parallel_for(0, mesh.height(), [&](int y) {
        for (int x = 0; x < mesh.width(); ++x) {
            const MeshPixel shown = mesh(x, y);
            if (shown == 0) continue;
            image.disparity(x, y) = disparityOf(shown);
            image.colour(x, y) =
                colourAt(scan, cornersOf(grid, triangleOf(shown)), frame, face, image.camera, x + 0.5, y + 0.5);
            image.flags(x, y) = flags;
        }
    });
}

template <class T>
Image<T> cropped(const Image<T>& image, int x0, int y0, int width, int height) {
    Image<T> part(width, height);
    for (int y = 0; y < height; ++y) {
        const auto from = image.row(y0 + y).subspan(static_cast<std::size_t>(x0), static_cast<std::size_t>(width));
        std::copy(from.begin(), from.end(), part.row(y).begin());
    }
    return part;
}

// Cuts the rows and columns away that hold no sample; the camera's centre moves along.
void cropToUsed(DepthImage& image, int& x0, int& y0) {
    int x1 = -1, y1 = -1;
    x0 = image.camera.width, y0 = image.camera.height;
    for (int y = 0; y < image.camera.height; ++y) {
        const auto row = image.flags.row(y);
        for (int x = 0; x < image.camera.width; ++x) {
            if (row[static_cast<std::size_t>(x)] & kNoSurface) continue;
            x0 = std::min(x0, x), x1 = std::max(x1, x);
            y0 = std::min(y0, y), y1 = std::max(y1, y);
        }
    }
    assert(x1 >= x0 && y1 >= y0);
    const int width = x1 - x0 + 1, height = y1 - y0 + 1;
    image.colour = cropped(image.colour, x0, y0, width, height);
    image.disparity = cropped(image.disparity, x0, y0, width, height);
    image.flags = cropped(image.flags, x0, y0, width, height);
    image.camera.width = width;
    image.camera.height = height;
    image.camera.cx -= x0;
    image.camera.cy -= y0;
}

// The points of each face, in the scan's order.
std::array<std::vector<std::uint32_t>, kFaceCount> pointsOfFaces(const Scan& scan, const CubeFrame& frame) {
    std::vector<std::int8_t> faceOf(scan.pointsInScanner.size());
    tbb::parallel_for(std::size_t{0}, faceOf.size(), [&](std::size_t i) {
        faceOf[i] = static_cast<std::int8_t>(frame.faceOf(scan.pointsInScanner[i]));
    });
    std::array<std::vector<std::uint32_t>, kFaceCount> points;
    for (std::size_t i = 0; i < faceOf.size(); ++i)
        if (faceOf[i] >= 0) points[static_cast<std::size_t>(faceOf[i])].push_back(static_cast<std::uint32_t>(i));
    return points;
}

} // namespace

CubeFaces projectToCubeFaces(const Scan& scan, const CubeFaceOptions& options) {
    assert(scan.colours.size() == scan.pointsInScanner.size());
    CubeFaces result;
    CubeFaceReport& report = result.report;
    report.points = static_cast<std::int64_t>(scan.pointsInScanner.size());
    if (scan.pointsInScanner.empty()) return result;

    const std::optional<ScanGrid> grid = gridOf(scan, options.sameSurface);
    const CubeFrame frame = cubeFrame(scan, grid ? glm::dvec3(0.0) : viewpointOf(scan));
    const AngularSteps steps = grid ? grid->steps : looseSteps(scan, frame.copInScanner);
    report.columnStepRadians = steps.horizontal;
    report.rowStepRadians = steps.vertical;
    const auto layouts = layOutFaces(scan, frame, steps, grid.has_value(), options);
    const auto points = pointsOfFaces(scan, frame);

    // One face after the other: the images of a dense scan are large, and each face is parallel within.
    for (int face = 0; face < kFaceCount; ++face) {
        const auto& [camera, coarserThanScan] = layouts[static_cast<std::size_t>(face)];
        const auto& own = points[static_cast<std::size_t>(face)];
        if (own.empty()) continue;
        report.coarserThanScan |= coarserThanScan;
        DepthImage first = emptyFace(scan, frame, face, camera);
        Image<MeshPixel> mesh;
        if (grid) {
            mesh = drawGrid(scan, *grid, frame, face, camera);
            paintMesh(scan, *grid, frame, face, mesh, first);
        }
        const PixelClusters clusters =
            placePoints(scan, frame, face, own, grid ? &*grid : nullptr, mesh, options, first);
        report.held += clusters.held;
        report.dropped += clusters.dropped;
        report.pixels += clusters.pixels;

        int x0 = 0, y0 = 0;
        cropToUsed(first, x0, y0);
        const Camera used = first.camera;
        result.faces.push_back(std::move(first));
        const std::size_t firstOfFace = result.faces.size() - 1;
        for (const LayerSample& sample : clusters.further) {
            while (result.faces.size() <= firstOfFace + static_cast<std::size_t>(sample.layer)) {
                DepthImage next = emptyFace(scan, frame, face, used);
                next.name += "-" + std::to_string(result.faces.size() - firstOfFace + 1);
                result.faces.push_back(std::move(next));
            }
            DepthImage& image = result.faces[firstOfFace + static_cast<std::size_t>(sample.layer)];
            const int x = sample.x - x0, y = sample.y - y0;
            image.disparity(x, y) = sample.disparity;
            image.colour(x, y) = sample.colour;
            image.flags(x, y) = scan.hasColour ? std::uint8_t{0} : std::uint8_t{kNoColour};
        }
    }
    report.dropped = report.points - report.held;
    return result;
}

} // namespace scene
