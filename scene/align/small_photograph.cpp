#include "scene/align/small_photograph.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace scene {

namespace {

constexpr int kMostPixelsAcross = 1200;

} // namespace

SmallPhotograph smallPhotograph(const Image<Rgb8>& picture, const Camera& camera) {
    const int across = std::max(camera.width, camera.height);
    if (across <= kMostPixelsAcross) return {picture, camera};
    const double scale = static_cast<double>(kMostPixelsAcross) / across;
    const auto sizeOf = [&](int pixels) { return std::max(1, static_cast<int>(std::lround(pixels * scale))); };
    SmallPhotograph small;
    small.camera = resized(camera, sizeOf(camera.width), sizeOf(camera.height));
    small.picture = Image<Rgb8>(small.camera.width, small.camera.height);
    // OpenCV has no pictures that are lent for reading alone; nothing writes to this one.
    const cv::Mat3b from(picture.height(), picture.width(),
                         const_cast<cv::Vec3b*>(reinterpret_cast<const cv::Vec3b*>(picture.pixels().data())));
    cv::Mat3b to(small.camera.height, small.camera.width, reinterpret_cast<cv::Vec3b*>(small.picture.pixels().data()));
    cv::resize(from, to, to.size(), 0, 0, cv::INTER_AREA);
    return small;
}

} // namespace scene
