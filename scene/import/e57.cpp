#include "scene/import/e57.h"

#include "scene/errors.h"
#include "scene/import/e57_file.h"
#include "scene/import/scan_name.h"
#include "scene/picture_codec.h"

#include <cmath>
#include <limits>
#include <map>
#include <set>

#include <opencv2/imgproc.hpp>

namespace scene {
namespace {

bool isPointList(const std::optional<e57::Node>& node) {
    return node && node->type() == e57::E57_COMPRESSED_VECTOR;
}

bool hasCoordinates(const e57::StructureNode& prototype) {
    const auto hasAll = [&](const char* a, const char* b, const char* c) {
        return prototype.isDefined(a) && prototype.isDefined(b) && prototype.isDefined(c);
    };
    return hasAll("cartesianX", "cartesianY", "cartesianZ") ||
           hasAll("sphericalRange", "sphericalAzimuth", "sphericalElevation");
}

// Rows or columns from the header's index bounds; 0 if it does not say or says nonsense.
int extentOf(const e57::StructureNode& scan, const std::string& axis) {
    const auto bounds = childOf(scan, "indexBounds");
    if (!bounds || bounds->type() != e57::E57_STRUCTURE) return 0;
    const e57::StructureNode node(*bounds);
    const auto minimum = numberOf(node, axis + "Minimum"), maximum = numberOf(node, axis + "Maximum");
    if (!minimum || !maximum) return 0;
    const double extent = *maximum - *minimum + 1;
    return extent >= 1 && extent <= std::numeric_limits<int>::max() ? static_cast<int>(extent) : 0;
}

std::string ordinalOf(const std::filesystem::path& path, std::int64_t index, std::int64_t count) {
    const std::string stem = path.stem().string();
    return count > 1 ? stem + "-" + std::to_string(index + 1) : stem;
}

// The camera of a pinhole representation: focal length and pixel sizes are in metres, the principal point in
// pixels.
Camera cameraOf(const e57::StructureNode& pinhole, int width, int height) {
    const double focalLength = numberOf(pinhole, "focalLength").value_or(0);
    Camera camera{width,
                  height,
                  focalLength / numberOf(pinhole, "pixelWidth").value_or(0),
                  focalLength / numberOf(pinhole, "pixelHeight").value_or(0),
                  numberOf(pinhole, "principalPointX").value_or(width / 2.0),
                  numberOf(pinhole, "principalPointY").value_or(height / 2.0)};
    return isUsable(camera) ? camera : Camera{};
}

struct Representation {
    E57ImageKind kind;
    e57::StructureNode node;
};

std::optional<Representation> representationOf(const e57::StructureNode& image) {
    constexpr std::pair<const char*, E57ImageKind> kKinds[] = {
        {"pinholeRepresentation", E57ImageKind::pinhole},
        {"sphericalRepresentation", E57ImageKind::spherical},
        {"cylindricalRepresentation", E57ImageKind::cylindrical},
        {"visualReferenceRepresentation", E57ImageKind::visualReference}};
    for (const auto& [name, kind] : kKinds)
        if (const auto node = childOf(image, name)) return Representation{kind, e57::StructureNode(*node)};
    return std::nullopt;
}

std::optional<e57::BlobNode> pictureOf(const e57::StructureNode& representation) {
    for (const char* name : {"jpegImage", "pngImage"})
        if (const auto node = childOf(representation, name)) return e57::BlobNode(*node);
    return std::nullopt;
}

int pixelsOf(const e57::StructureNode& node, const char* name) {
    const double pixels = numberOf(node, name).value_or(0);
    return pixels >= 1 && pixels <= 1 << 20 ? static_cast<int>(pixels) : 0;
}

// E57 has a camera look along -Z with Y up; ours look along +Z with Y down.
Pose turnedAsOurs(const Pose& worldFromE57Camera) {
    return worldFromE57Camera * Pose{glm::dmat3(1, 0, 0, 0, -1, 0, 0, 0, -1), glm::dvec3(0.0)};
}

} // namespace

std::vector<ScanSource> listE57(const std::filesystem::path& path, std::vector<std::string>& remarks) {
    std::vector<ScanSource> sources;
    withE57Failures(path, [&] {
        e57::ImageFile file = openE57(path);
        std::set<std::string> names;
        const std::int64_t count = childCountOf(file, "data3D");
        for (std::int64_t i = 0; i < count; ++i) {
            const e57::StructureNode node = structureAt(file, "data3D", i, path);
            ScanSource source;
            source.path = path;
            source.format = ScanFormat::e57;
            source.indexInFile = static_cast<int>(i);
            source.name = scanName(textOf(node, "name"), ordinalOf(path, i, count), names);
            const auto points = childOf(node, "points");
            if (!isPointList(points)) {
                remarks.push_back(path.string() + " has a scan '" + source.name + "' without points; it is left out.");
                continue;
            }
            const e57::CompressedVectorNode pointList(*points);
            if (!hasCoordinates(e57::StructureNode(pointList.prototype()))) {
                remarks.push_back(path.string() + " has a scan '" + source.name +
                                  "' without coordinates; it is left out.");
                continue;
            }
            source.worldFromScanner = poseOf(node, "scan '" + source.name + "'", path);
            source.pointCount = pointList.childCount();
            source.rows = extentOf(node, "row");
            source.columns = extentOf(node, "column");
            if (source.rows == 0 || source.columns == 0) source.rows = source.columns = 0;
            sources.push_back(std::move(source));
        }
        if (!sources.empty()) return;
        const bool hasPhotographs = childCountOf(file, "images2D") > 0;
        remarks.push_back(path.string() + (hasPhotographs
                                               ? " holds photographs but no scan; photographs alone have no depth."
                                               : " holds no scan."));
    });
    return sources;
}

std::vector<E57Image> listE57Images(const std::filesystem::path& path) {
    std::vector<E57Image> images;
    withE57Failures(path, [&] {
        const auto fileBytes = static_cast<std::int64_t>(std::filesystem::file_size(path));
        e57::ImageFile file = openE57(path);
        std::set<std::string> names;
        std::map<std::string, int> scanOfGuid;
        for (std::int64_t i = 0; i < childCountOf(file, "data3D"); ++i) {
            const std::string guid = textOf(structureAt(file, "data3D", i, path), "guid");
            if (!guid.empty()) scanOfGuid.emplace(guid, static_cast<int>(i));
        }
        const std::int64_t count = childCountOf(file, "images2D");
        for (std::int64_t i = 0; i < count; ++i) {
            const e57::StructureNode node = structureAt(file, "images2D", i, path);
            const auto representation = representationOf(node);
            if (!representation) continue;
            const auto picture = pictureOf(representation->node);
            if (!picture) continue;
            E57Image image;
            image.path = path;
            image.indexInFile = static_cast<int>(i);
            image.kind = representation->kind;
            image.name = scanName(textOf(node, "name"), "image-" + std::to_string(i + 1), names);
            image.width = pixelsOf(representation->node, "imageWidth");
            image.height = pixelsOf(representation->node, "imageHeight");
            image.hasPose = image.kind != E57ImageKind::visualReference && node.isDefined("pose");
            if (image.hasPose) image.worldFromCamera = poseOf(node, "image '" + image.name + "'", path);
            if (image.kind == E57ImageKind::pinhole) {
                image.worldFromCamera = turnedAsOurs(image.worldFromCamera);
                image.camera = cameraOf(representation->node, image.width, image.height);
            } else if (image.kind != E57ImageKind::visualReference) {
                image.pixelWidthRadians = numberOf(representation->node, "pixelWidth").value_or(0);
                if (image.kind == E57ImageKind::spherical)
                    image.pixelHeightRadians = numberOf(representation->node, "pixelHeight").value_or(0);
            }
            if (const auto scan = scanOfGuid.find(textOf(node, "associatedData3DGuid")); scan != scanOfGuid.end())
                image.scanInFile = scan->second;
            image.byteCount = picture->byteCount();
            if (image.byteCount < 0 || image.byteCount > fileBytes)
                throw Failure("claims " + std::to_string(image.byteCount) + " bytes for image '" + image.name +
                                  "', more than the file has",
                              path, "copy or export the scan again");
            images.push_back(std::move(image));
        }
    });
    return images;
}

std::vector<std::uint8_t> readE57ImageBytes(const E57Image& image) {
    std::vector<std::uint8_t> bytes;
    withE57Failures(image.path, [&] {
        const auto fileBytes = static_cast<std::int64_t>(std::filesystem::file_size(image.path));
        e57::ImageFile file = openE57(image.path);
        const auto representation = representationOf(structureAt(file, "images2D", image.indexInFile, image.path));
        auto picture = representation ? pictureOf(representation->node) : std::nullopt;
        if (!picture || picture->byteCount() < 0 || picture->byteCount() > fileBytes)
            throw Failure("has no picture in image '" + image.name + "'", image.path, "copy or export the scan again");
        bytes.resize(static_cast<std::size_t>(picture->byteCount()));
        if (!bytes.empty()) picture->read(bytes.data(), 0, bytes.size());
    });
    return bytes;
}

Image<Rgb8> readE57Image(const E57Image& image) {
    const std::vector<std::uint8_t> bytes = readE57ImageBytes(image);
    const cv::Mat bgr = decodePicture(bytes, PictureKind::colour);
    if (bgr.empty())
        throw Failure("image '" + image.name + "' is no picture that can be decoded", image.path,
                      "export its photographs as JPEG or PNG");
    Image<Rgb8> picture(bgr.cols, bgr.rows);
    for (int y = 0; y < bgr.rows; ++y)
        for (int x = 0; x < bgr.cols; ++x) {
            const auto& pixel = bgr.at<cv::Vec3b>(y, x);
            picture(x, y) = {pixel[2], pixel[1], pixel[0]};
        }
    return picture;
}

} // namespace scene
