#include "scene/import/photo.h"

#include "scene/errors.h"
#include "scene/import/camera_file.h"
#include "scene/picture_codec.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace scene {

namespace {

/// Neighbouring depth values farther apart than this share of the nearer one belong to different surfaces.
constexpr float kSilhouetteStep = 0.05f;

/// Samples of depth along a side for each of colour's pixels, at most: a header must not claim memory without end.
constexpr double kFinestDepth = 4;

std::string sizeText(int width, int height) {
    return std::to_string(width) + "x" + std::to_string(height);
}

/// check is told the picture's size before memory is taken for it, wherever its header tells.
cv::Mat pictureFrom(const std::filesystem::path& path, PictureKind kind,
                    const std::function<void(PictureSize)>& check) {
    if (!std::filesystem::is_regular_file(path))
        throw Failure("no such picture", path, "check the path in the capture's list of frames");
    const std::vector<std::uint8_t> bytes = readPictureBytes(path);
    if (const std::optional<PictureSize> size = sizeInHeader(bytes)) check(*size);
    cv::Mat picture = decodePicture(bytes, kind);
    if (picture.empty())
        throw Failure("picture is empty, damaged or of an unknown format", path,
                      "export it again as PNG, JPEG or TIFF, or leave it out of the list");
    check({picture.cols, picture.rows});
    return picture;
}

void checkColourSize(PictureSize size, const PhotoSource& source) {
    if (size.width != source.camera.width || size.height != source.camera.height)
        throw Failure("picture is " + sizeText(size.width, size.height) + " but its camera is " +
                          sizeText(source.camera.width, source.camera.height),
                      source.colourPath, "correct the size in the capture's camera");
}

void checkDepthSize(PictureSize size, const PhotoSource& source) {
    const Camera& camera = source.camera;
    const double scaleX = static_cast<double>(size.width) / camera.width,
                 scaleY = static_cast<double>(size.height) / camera.height;
    const std::string sizes =
        "depth is " + sizeText(size.width, size.height) + " but colour is " + sizeText(camera.width, camera.height);
    if (std::abs(scaleX / scaleY - 1) > 0.02)
        throw Failure(sizes + ", another shape", source.depthPath, "register depth to the colour picture first");
    if (scaleX > kFinestDepth)
        throw Failure(sizes + ", more than " + std::to_string(static_cast<int>(kFinestDepth)) + " times as wide",
                      source.depthPath, "export depth at the size of the colour picture");
}

/// Depth in metres as stored; 0 where nothing came back.
cv::Mat1f readDepth(const PhotoSource& source) {
    const cv::Mat stored =
        pictureFrom(source.depthPath, PictureKind::asStored, [&](PictureSize size) { checkDepthSize(size, source); });
    if (stored.channels() != 1)
        throw Failure("depth picture has " + std::to_string(stored.channels()) + " channels", source.depthPath,
                      "depth is one channel of 16 bit steps or 32 bit floats");
    cv::Mat1f metres;
    if (stored.depth() == CV_16U)
        stored.convertTo(metres, CV_32F, source.depthUnitMetres.value_or(0.001));
    else if (stored.depth() == CV_32F)
        stored.convertTo(metres, CV_32F, source.depthUnitMetres.value_or(1.0));
    else
        throw Failure("depth picture has neither 16 bit steps nor 32 bit floats", source.depthPath,
                      "export depth as 16 bit PNG or 32 bit float TIFF");
    for (int y = 0; y < metres.rows; ++y)
        for (float& value : std::span<float>(metres[y], static_cast<std::size_t>(metres.cols)))
            if (!std::isfinite(value) || value <= 0 || !std::isfinite(1 / value)) value = 0;
    return metres;
}

/// Bilinear where the four neighbours are one surface, else the nearest of them.
float sampleDepth(const cv::Mat1f& depth, double x, double y) {
    const int x0 = std::clamp(static_cast<int>(std::floor(x - 0.5)), 0, depth.cols - 1);
    const int y0 = std::clamp(static_cast<int>(std::floor(y - 0.5)), 0, depth.rows - 1);
    const int x1 = std::min(x0 + 1, depth.cols - 1), y1 = std::min(y0 + 1, depth.rows - 1);
    const float a = depth(y0, x0), b = depth(y0, x1), c = depth(y1, x0), d = depth(y1, x1);
    const float nearest = std::min(std::min(a, b), std::min(c, d)), farthest = std::max(std::max(a, b), std::max(c, d));
    const auto s = static_cast<float>(std::clamp(x - 0.5 - x0, 0.0, 1.0));
    const auto t = static_cast<float>(std::clamp(y - 0.5 - y0, 0.0, 1.0));
    if (nearest > 0 && farthest - nearest <= kSilhouetteStep * nearest) {
        // Disparity, not depth, is affine on a plane.
        const float top = (1 - s) / a + s / b, bottom = (1 - s) / c + s / d;
        return 1 / ((1 - t) * top + t * bottom);
    }
    return t < 0.5f ? (s < 0.5f ? a : b) : (s < 0.5f ? c : d);
}

/// Where in the distorted picture each pixel of the pinhole is found; identity for a pinhole.
struct Undistortion {
    cv::Mat1f x, y;
    bool isIdentity = true;

    bool isSeen(int column, int row, const Camera& camera) const {
        const double atX = static_cast<double>(x(row, column)) + 0.5, atY = static_cast<double>(y(row, column)) + 0.5;
        return atX >= 0 && atY >= 0 && atX < camera.width && atY < camera.height;
    }
};

Undistortion findUndistortion(const PhotoSource& source) {
    Undistortion map;
    if (source.distortion == Distortion{}) return map;
    const Camera& camera = source.camera;
    // OpenCV counts pixel centres at whole numbers.
    const cv::Matx33d k(camera.fx, 0, camera.cx - 0.5, 0, camera.fy, camera.cy - 0.5, 0, 0, 1);
    const Distortion& d = source.distortion;
    const cv::Vec<double, 5> coefficients(d.k1, d.k2, d.p1, d.p2, d.k3);
    cv::initUndistortRectifyMap(k, coefficients, cv::noArray(), k, {camera.width, camera.height}, CV_32FC1, map.x,
                                map.y);
    map.isIdentity = false;
    // Beyond where the lens folds the picture over itself nothing new is seen.
    const double within = oneToOneWithin(camera, d);
    for (int y = 0; y < camera.height && std::isfinite(within); ++y)
        for (int x = 0; x < camera.width; ++x)
            if (glm::length(glm::dvec2(rayThrough(camera, x + 0.5, y + 0.5))) >= within)
                map.x(y, x) = map.y(y, x) = static_cast<float>(-2 * (camera.width + camera.height));
    return map;
}

} // namespace

void keepWithinPicture(DepthImage& image, const PhotoSource& source) {
    const Undistortion lens = findUndistortion(source);
    if (lens.isIdentity) return;
    for (int y = 0; y < image.camera.height; ++y)
        for (int x = 0; x < image.camera.width; ++x)
            if (!lens.isSeen(x, y, image.camera)) image.disparity(x, y) = 0, image.flags(x, y) = kNoSurface;
}

DepthImage readPhoto(const PhotoSource& source) {
    const Camera& camera = source.camera;
    cv::Mat colour =
        pictureFrom(source.colourPath, PictureKind::colour, [&](PictureSize size) { checkColourSize(size, source); });
    const cv::Mat1f depth = readDepth(source);
    const double scaleX = static_cast<double>(depth.cols) / camera.width,
                 scaleY = static_cast<double>(depth.rows) / camera.height;

    const Undistortion lens = findUndistortion(source);
    if (!lens.isIdentity) {
        cv::Mat straight;
        cv::remap(colour, straight, lens.x, lens.y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
        colour = straight;
    }

    DepthImage image;
    image.name = source.name;
    image.camera = camera;
    image.worldFromCamera = source.worldFromCamera;
    image.colour = Image<Rgb8>(camera.width, camera.height);
    image.disparity = Image<float>(camera.width, camera.height, 0.0f);
    image.flags = Image<std::uint8_t>(camera.width, camera.height, 0);
    const bool isPixelByPixel = lens.isIdentity && depth.size() == colour.size();
    const auto depthAt = [&](int x, int y) {
        if (isPixelByPixel) return depth(y, x);
        const double atX = lens.isIdentity ? x + 0.5 : static_cast<double>(lens.x(y, x)) + 0.5;
        const double atY = lens.isIdentity ? y + 0.5 : static_cast<double>(lens.y(y, x)) + 0.5;
        const bool isSeen = lens.isIdentity || lens.isSeen(x, y, camera);
        return isSeen ? sampleDepth(depth, atX * scaleX, atY * scaleY) : 0;
    };
    for (int y = 0; y < camera.height; ++y) {
        for (int x = 0; x < camera.width; ++x) {
            const auto& bgr = colour.at<cv::Vec3b>(y, x);
            image.colour(x, y) = {bgr[2], bgr[1], bgr[0]};
            const float z = depthAt(x, y);
            if (z > 0)
                image.disparity(x, y) = 1 / z;
            else
                image.flags(x, y) = kNoSurface;
        }
    }
    return image;
}

} // namespace scene
