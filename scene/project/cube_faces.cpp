#include "scene/project/cube_faces.h"

#include "scene/project/colour_mean.h"
#include "scene/project/cube_layout.h"
#include "scene/project/grid_mesh.h"
#include "scene/project/loose_points.h"
#include "scene/project/open_sky.h"
#include "scene/project/pixel_clusters.h"
#include "scene/project/scan_grid.h"

#include <algorithm>
#include <cassert>
#include <iterator>
#include <span>

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
    tbb::parallel_for(0, mesh.height(), [&](int y) {
        for (int x = 0; x < mesh.width(); ++x) {
            const MeshPixel shown = mesh(x, y);
            if (shown == 0) continue;
            image.disparity(x, y) = disparityOf(shown);
            const ColourMean mean =
                colourAt(scan, cornersOf(grid, triangleOf(shown)), frame, face, image.camera, x + 0.5, y + 0.5);
            image.colour(x, y) = mean.colour();
            image.flags(x, y) = mean.flags();
        }
    });
}

// Between the samples: rays that met the sky.
void paintSky(const OpenSky& sky, const CubeFrame& frame, int face, DepthImage& image) {
    if (sky.isEmpty()) return;
    const glm::dmat3 scannerFromFace = glm::transpose(frame.faceFromScanner[static_cast<std::size_t>(face)]);
    tbb::parallel_for(0, image.camera.height, [&](int y) {
        for (int x = 0; x < image.camera.width; ++x)
            if ((image.flags(x, y) & kNoSurface) != 0 &&
                sky.isOpen(scannerFromFace * rayThrough(image.camera, x + 0.5, y + 0.5)))
                image.flags(x, y) = kOpenSky;
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

// Cuts the rows and columns away that hold no sample and no sky; the camera's centre moves along.
bool cropToUsed(DepthImage& image, int& x0, int& y0) {
    int x1 = -1, y1 = -1;
    x0 = image.camera.width, y0 = image.camera.height;
    for (int y = 0; y < image.camera.height; ++y) {
        const auto row = image.flags.row(y);
        for (int x = 0; x < image.camera.width; ++x) {
            const std::uint8_t flags = row[static_cast<std::size_t>(x)];
            if ((flags & kNoSurface) != 0 && !isOpenSky(flags)) continue;
            x0 = std::min(x0, x), x1 = std::max(x1, x);
            y0 = std::min(y0, y), y1 = std::max(y1, y);
        }
    }
    if (x1 < x0) return false;
    const int width = x1 - x0 + 1, height = y1 - y0 + 1;
    image.colour = cropped(image.colour, x0, y0, width, height);
    image.disparity = cropped(image.disparity, x0, y0, width, height);
    image.flags = cropped(image.flags, x0, y0, width, height);
    image.camera.width = width;
    image.camera.height = height;
    image.camera.cx -= x0;
    image.camera.cy -= y0;
    return true;
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

/// The images of a face, which its points make. Adds to the report what became of them.
std::vector<DepthImage> layersOf(const Scan& scan, const ScanGrid* grid, const OpenSky& sky, const CubeFrame& frame,
                                 int face, const Camera& camera, std::span<const std::uint32_t> points,
                                 const CubeFaceOptions& options, CubeFaceReport& report) {
    std::vector<DepthImage> layers{emptyFace(scan, frame, face, camera)};
    PixelClusters clusters;
    {
        Image<MeshPixel> mesh;
        if (grid) {
            mesh = drawGrid(scan, *grid, frame, face, camera);
            paintMesh(scan, *grid, frame, face, mesh, layers[0]);
        }
        clusters = placePoints(scan, frame, face, points, grid, mesh, options, layers[0]);
    }
    report.held += clusters.held;
    report.dropped += clusters.dropped;
    report.pixels += clusters.pixels;

    paintSky(sky, frame, face, layers[0]);
    int x0 = 0, y0 = 0;
    if (!cropToUsed(layers[0], x0, y0)) return {}; // sky between its pixels
    const Camera used = layers[0].camera;
    for (const LayerSample& sample : clusters.further) {
        while (layers.size() <= static_cast<std::size_t>(sample.layer)) {
            DepthImage next = emptyFace(scan, frame, face, used);
            next.name += "-" + std::to_string(layers.size() + 1);
            layers.push_back(std::move(next));
        }
        DepthImage& image = layers[static_cast<std::size_t>(sample.layer)];
        const int x = sample.x - x0, y = sample.y - y0;
        image.disparity(x, y) = sample.disparity;
        image.colour(x, y) = sample.colour;
        image.flags(x, y) = sample.flags;
    }
    return layers;
}

} // namespace

CubeFaceReport projectToCubeFaces(const Scan& scan, const CubeFaceOptions& options, const TakeFace& take) {
    assert(scan.colours.size() == scan.pointsInScanner.size());
    assert(scan.isColoured.empty() || scan.isColoured.size() == scan.pointsInScanner.size());
    CubeFaceReport report;
    report.points = static_cast<std::int64_t>(scan.pointsInScanner.size());
    if (scan.pointsInScanner.empty()) return report;

    const std::optional<ScanGrid> grid = gridOf(scan, options.sameSurface);
    const glm::dvec3 viewpoint = grid ? glm::dvec3(0.0) : viewpointOf(scan);
    report.isFromElsewhere = viewpoint != glm::dvec3(0.0);
    const CubeFrame frame = cubeFrame(scan, viewpoint);
    const AngularSteps steps = grid ? grid->steps : looseSteps(scan, frame.copInScanner);
    report.columnStepRadians = steps.horizontal;
    report.rowStepRadians = steps.vertical;
    const OpenSky sky = grid && options.opensSky ? OpenSky(scan, *grid) : OpenSky();
    report.skyShare = sky.share();
    const auto layouts = layOutFaces(scan, frame, steps, grid.has_value(), options, sky.directions());
    const auto points = pointsOfFaces(scan, frame);

    for (int face = 0; face < kFaceCount; ++face) {
        const auto& [camera, coarserThanScan] = layouts[static_cast<std::size_t>(face)];
        const auto& own = points[static_cast<std::size_t>(face)];
        if (camera.width == 0) continue;
        report.coarserThanScan |= coarserThanScan && !own.empty();
        std::vector<DepthImage> layers =
            layersOf(scan, grid ? &*grid : nullptr, sky, frame, face, camera, own, options, report);
        if (!layers.empty()) take(std::move(layers));
    }
    report.dropped = report.points - report.held;
    return report;
}

CubeFaces projectToCubeFaces(const Scan& scan, const CubeFaceOptions& options) {
    CubeFaces result;
    result.report = projectToCubeFaces(scan, options, [&](std::vector<DepthImage> layers) {
        std::ranges::move(layers, std::back_inserter(result.faces));
    });
    return result;
}

} // namespace scene
