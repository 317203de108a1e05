#pragma once
// Films of pictures: motion JPEG in AVI files.

#include <memory>
#include <string>

namespace cv {
class Mat;
}

namespace app {

class FilmWriter {
  public:
    virtual ~FilmWriter() = default;
    /// A picture of the film's size, 8 bits each of blue, green, red.
    virtual void write(const cv::Mat& picture) = 0;
};

/// Pictures a second; width and height in pixels. Null where no film can be made. What writes films is loaded with the
/// first one: a hundred libraries hang on it, which would make every start of the program half as long again.
std::unique_ptr<FilmWriter> openFilm(const std::string& file, int rate, int width, int height);

/// What the library of film_module.cpp is asked for by name; null where no film can be made. The caller owns it.
extern "C" FilmWriter* revisitOpenFilm(const char* file, int rate, int width, int height);

} // namespace app
