// The library librevisit_pictures: pictures through OpenCV.

#include "scene/picture_codec.h"

#include <iostream>

#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>

namespace scene {

namespace {

/// OpenCV tells what it cannot decode to std::cerr, partly past its own log. Who asked says so in one line, and nothing
/// else of ours speaks there.
bool silence() {
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    std::cerr.setstate(std::ios::failbit);
    return true;
}

} // namespace

void revisitDecodePicture(const std::uint8_t* bytes, std::size_t count, PictureKind kind, cv::Mat* picture) try {
    [[maybe_unused]] static const bool isSilent = silence();
    const int mode = kind == PictureKind::colour ? cv::IMREAD_COLOR
                     : kind == PictureKind::grey ? cv::IMREAD_GRAYSCALE
                                                 : cv::IMREAD_UNCHANGED;
    const cv::Mat1b encoded(1, static_cast<int>(count), const_cast<std::uint8_t*>(bytes));
    *picture = cv::imdecode(encoded, mode | cv::IMREAD_IGNORE_ORIENTATION);
} catch (const cv::Exception&) { // as any other picture that cannot be decoded
    picture->release();
}

} // namespace scene
