#include "app/frame_pictures.h"

#include "app/stage_store.h"

#include "scene/errors.h"

#include <opencv2/imgcodecs.hpp>

namespace app {

namespace {

/// Encoded in memory first: OpenCV's own writing of files says more than one line where the disk is full, and does not
/// notice when it fills up at the very end.
void write(const std::filesystem::path& path, const cv::Mat& picture, const std::vector<int>& parameters = {}) {
    std::vector<std::uint8_t> bytes;
    if (!cv::imencode(path.extension().string(), picture, bytes, parameters))
        throw scene::Failure("cannot be encoded", path, "choose a smaller --size");
    writeWhole(path, std::as_bytes(std::span(bytes)));
}

} // namespace

void writePictures(const render::EyeImage& image, const std::filesystem::path& folder, const std::string& name,
                   bool aux) {
    cv::Mat3b colour(image.colour.height(), image.colour.width());
    for (int y = 0; y < colour.rows; ++y)
        for (int x = 0; x < colour.cols; ++x) {
            const scene::Rgb8 c = image.colour(x, y);
            colour(y, x) = {c.b, c.g, c.r};
        }
    constexpr int kFastDeflate = 1;
    write(folder / (name + ".png"), colour, {cv::IMWRITE_PNG_COMPRESSION, kFastDeflate});
    if (!aux) return;
    cv::Mat1f depth(image.depthMetres.height(), image.depthMetres.width());
    cv::Mat1b pixelClass(image.pixelClass.height(), image.pixelClass.width());
    for (int y = 0; y < depth.rows; ++y) {
        std::copy(image.depthMetres.row(y).begin(), image.depthMetres.row(y).end(), depth[y]);
        std::copy(image.pixelClass.row(y).begin(), image.pixelClass.row(y).end(), pixelClass[y]);
    }
    write(folder / (name + "-depth.tiff"), depth);
    write(folder / (name + "-class.png"), pixelClass);
}

} // namespace app
