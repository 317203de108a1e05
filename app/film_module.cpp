// The library librevisit_film: films through OpenCV.

#include "app/film_writer.h"

#include <opencv2/videoio.hpp>

namespace app {

namespace {

class OpenCvFilm : public FilmWriter {
  public:
    OpenCvFilm(const char* file, int rate, int width, int height)
        : writer_(file, cv::CAP_OPENCV_MJPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), rate, {width, height}) {}

    bool isOpen() const { return writer_.isOpened(); }
    void write(const cv::Mat& picture) override { writer_.write(picture); }

  private:
    cv::VideoWriter writer_;
};

} // namespace

FilmWriter* revisitOpenFilm(const char* file, int rate, int width, int height) try {
    auto film = std::make_unique<OpenCvFilm>(file, rate, width, height);
    return film->isOpen() ? film.release() : nullptr;
} catch (const cv::Exception&) {
    return nullptr;
}

} // namespace app
