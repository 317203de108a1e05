#include "scene/import/scan_photos.h"

#include "scene/errors.h"
#include "scene/import/camera_file.h"
#include "scene/import/e57.h"

#include <algorithm>
#include <array>
#include <limits>

#include <glm/geometric.hpp>

namespace scene {

namespace {

std::string pixelsText(int width, int height) {
    return std::to_string(width) + "x" + std::to_string(height);
}

const char* nameOf(E57ImageKind kind) {
    switch (kind) {
    case E57ImageKind::visualReference:
        return "without a camera";
    case E57ImageKind::pinhole:
        return "pinhole";
    case E57ImageKind::spherical:
        return "spherical";
    case E57ImageKind::cylindrical:
        break;
    }
    return "cylindrical";
}

/// Photographs for one reason not used; the first by its name.
struct Unused {
    std::string first;
    int count = 0;

    void add(const std::string& name) {
        if (count++ == 0) first = name;
    }
    void tell(const std::filesystem::path& path, const std::string& why, std::vector<std::string>& remarks) const {
        if (count == 1) remarks.push_back(path.string() + ": photograph '" + first + "' is not used: " + why + ".");
        if (count > 1)
            remarks.push_back(path.string() + ": " + std::to_string(count) + " photographs, the first '" + first +
                              "', are not used: " + why + ".");
    }
};

/// Some files give millimetres for metres: what comes of it is no camera that anybody has.
bool isPlausible(const Camera& camera) {
    constexpr double kNarrowest = 0.009, kWidest = 23; // width over focal length: 0.5 and 170 degrees
    constexpr double kFarthestCentre = 20; // of the larger side: farther than that of a small piece of a picture
    const double across = camera.width / camera.fx, down = camera.height / camera.fy;
    return std::min(across, down) >= kNarrowest && std::max(across, down) <= kWidest &&
           std::max(std::abs(camera.cx), std::abs(camera.cy)) <=
               kFarthestCentre * std::max(camera.width, camera.height);
}

/// A photograph that cannot be read must not take the scans with it.
std::vector<E57Image> imagesOf(const std::filesystem::path& path, std::vector<std::string>& remarks) {
    try {
        return listE57Images(path);
    } catch (const Failure& failure) {
        remarks.push_back(std::string(failure.what()) + "; its photographs are not used.");
        return {};
    }
}

std::optional<std::size_t> findScanOf(const E57Image& image, std::span<const ScanSource> scans) {
    std::optional<std::size_t> nearest;
    double least = kBesideMetres;
    for (std::size_t i = 0; i < scans.size(); ++i) {
        if (image.scanInFile && scans[i].indexInFile != *image.scanInFile) continue;
        const double metres = glm::distance(scans[i].worldFromScanner.translation, image.worldFromCamera.translation);
        if (metres <= least) least = metres, nearest = i;
    }
    return nearest;
}

} // namespace

std::vector<ScanPhoto> listScanPhotos(const std::filesystem::path& path, std::span<const ScanSource> scans,
                                      std::size_t firstScan, std::vector<std::string>& remarks) {
    std::vector<ScanPhoto> photos;
    std::array<Unused, 4> otherKinds;
    Unused poseless, cameraless, alone;
    std::vector<bool> hasPhoto(scans.size(), false);
    for (const E57Image& image : imagesOf(path, remarks)) {
        if (image.kind != E57ImageKind::pinhole) {
            otherKinds[static_cast<std::size_t>(image.kind)].add(image.name);
            continue;
        }
        if (!image.hasPose) {
            poseless.add(image.name);
            continue;
        }
        if (!isUsable(image.camera) || !isPlausible(image.camera)) {
            cameraless.add(image.name);
            continue;
        }
        const auto scan = findScanOf(image, scans);
        if (!scan) {
            alone.add(image.name);
            continue;
        }
        hasPhoto[*scan] = true;
        photos.push_back(
            {image.name, image.path, image.indexInFile, image.camera, {}, image.worldFromCamera, firstScan + *scan});
    }
    for (const E57ImageKind kind : {E57ImageKind::spherical, E57ImageKind::cylindrical, E57ImageKind::visualReference})
        otherKinds[static_cast<std::size_t>(kind)].tell(
            path, std::string("of a kind (") + nameOf(kind) + ") that cannot be laid on a scan", remarks);
    poseless.tell(path, "the file gives no pose for it", remarks);
    cameraless.tell(path, "its focal length and pixel size make no camera", remarks);
    alone.tell(path, "no scan stands at its place", remarks);
    if (photos.empty()) return photos;
    for (std::size_t i = 0; i < scans.size(); ++i)
        if (!hasPhoto[i])
            remarks.push_back(path.string() + ": scan '" + scans[i].name +
                              "' has no photograph; it keeps the colours or the intensity of its own.");
    return photos;
}

Image<Rgb8> readScanPhoto(const ScanPhoto& photo) {
    E57Image image;
    image.name = photo.name;
    image.path = photo.path;
    image.indexInFile = photo.indexInFile;
    Image<Rgb8> picture = readE57Image(image);
    if (picture.width() != photo.camera.width || picture.height() != photo.camera.height)
        throw Failure("photograph '" + photo.name + "' is " + pixelsText(picture.width(), picture.height()) +
                          " but its camera is " + pixelsText(photo.camera.width, photo.camera.height),
                      photo.path, "export its photographs again");
    return picture;
}

void useCameraFile(Capture& capture, const std::filesystem::path& file) {
    const CameraFile camera = readCameraFile(file);
    if (capture.scanPhotos.empty())
        throw Failure("is for photographs that stand beside scans in E57 files, and there are none that can be used",
                      "--camera " + file.string(), "leave it out");
    if (!isPlausible(camera.camera))
        throw Failure("is of no camera that anybody has: its focal length or centre is out of proportion to " +
                          pixelsText(camera.camera.width, camera.camera.height) + " pixels",
                      "--camera " + file.string(), "correct its intrinsics, which are in pixels");
    for (ScanPhoto& photo : capture.scanPhotos) {
        if (photo.camera.width != camera.camera.width || photo.camera.height != camera.camera.height)
            throw Failure("is of pictures of " + pixelsText(camera.camera.width, camera.camera.height) +
                              ", but photograph '" + photo.name + "' is " +
                              pixelsText(photo.camera.width, photo.camera.height),
                          "--camera " + file.string(), "give the file of the camera that took it");
        photo.camera = camera.camera;
        photo.distortion = camera.distortion;
    }
}

} // namespace scene
