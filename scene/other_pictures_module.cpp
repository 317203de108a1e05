// The library librevisit_pictures: pictures through OpenCV.

#include "scene/picture_codec.h"

#include <opencv2/imgcodecs.hpp>

namespace scene {

void revisitDecodePicture(const std::uint8_t* bytes, std::size_t count, PictureKind kind, cv::Mat* picture) try {
    const int mode = kind == PictureKind::colour ? cv::IMREAD_COLOR
                     : kind == PictureKind::grey ? cv::IMREAD_GRAYSCALE
                                                 : cv::IMREAD_UNCHANGED;
    const cv::Mat1b encoded(1, static_cast<int>(count), const_cast<std::uint8_t*>(bytes));
    *picture = cv::imdecode(encoded, mode | cv::IMREAD_IGNORE_ORIENTATION);
} catch (const cv::Exception&) { // as any other picture that cannot be decoded
    picture->release();
}

} // namespace scene
