#include "app/frame_pictures.h"

#include "scene/errors.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace app {

namespace {

void write(const std::filesystem::path& path, const cv::Mat& picture, const std::vector<int>& parameters = {}) {
    bool isWritten = false;
    try {
        isWritten = cv::imwrite(path.string(), picture, parameters);
    } catch (const cv::Exception&) {
    }
    if (!isWritten)
        throw scene::Failure("cannot be written", path, "check that the disk has room and the folder may be written");
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
