#include "app/picture_keeper.h"

#include "app/say.h"
#include "app/stage_store.h"
#include "scene/picture_codec.h"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <exception>
#include <filesystem>

#include <opencv2/imgproc.hpp>

namespace app {

namespace {

constexpr int kFilmRate = 30;

/// A new name: two in one second are told apart.
std::string nameNow(const char* ending) {
    const std::time_t now = std::time(nullptr);
    std::tm local{};
    localtime_r(&now, &local);
    char text[40];
    std::strftime(text, sizeof text, "revisit-%Y%m%d-%H%M%S", &local);
    std::string name = std::string(text) + ending;
    for (int i = 2; std::filesystem::exists(name); ++i)
        name = std::string(text) + "-" + std::to_string(i) + ending;
    return name;
}

cv::Mat sideBySide(std::span<const xr::WindowPicture> pictures) {
    int width = 0, height = 0;
    for (const xr::WindowPicture& picture : pictures)
        width += picture.width, height = std::max(height, picture.height);
    cv::Mat joined(std::max(height, 1), std::max(width, 1), CV_8UC3, cv::Scalar(0, 0, 0));
    int x = 0;
    for (const xr::WindowPicture& picture : pictures) {
        for (int v = 0; v < picture.height; ++v)
            for (int u = 0; u < picture.width; ++u) {
                const std::uint32_t p =
                    picture.pixels[static_cast<std::size_t>(v) * static_cast<std::size_t>(picture.width) +
                                   static_cast<std::size_t>(u)];
                joined.at<cv::Vec3b>(v, x + u) = {static_cast<std::uint8_t>(p >> 16), static_cast<std::uint8_t>(p >> 8),
                                                  static_cast<std::uint8_t>(p)};
            }
        x += picture.width;
    }
    return joined;
}

} // namespace

PictureKeeper::PictureKeeper() = default;

PictureKeeper::~PictureKeeper() {
    endFilm();
}

void PictureKeeper::keep(std::span<const xr::WindowPicture> pictures, const glm::dvec3& place) {
    if (pictures.empty()) return;
    const std::string name = nameNow(".png");
    bool isWritten = false;
    try {
        const std::vector<std::uint8_t> encoded = scene::encodePng(sideBySide(pictures));
        if (!encoded.empty()) writeWhole(name, std::as_bytes(std::span(encoded)));
        isWritten = !encoded.empty();
    } catch (const std::exception&) { // a walk does not end with a picture
        isWritten = false;
    }
    if (isWritten)
        std::fprintf(stderr, "kept %s, seen from %.3f %.3f %.3f m\n", name.c_str(), place.x, place.y, place.z);
    else
        say(name + ": cannot be written; check the folder and the space on its disk");
}

bool PictureKeeper::beginFilm() {
    endFilm();
    filmName_ = nameNow(".avi");
    isFilming_ = true;
    filmStart_ = std::chrono::steady_clock::now();
    filmFrames_ = 0;
    return true;
}

void PictureKeeper::addToFilm(std::span<const xr::WindowPicture> pictures) {
    if (!isFilming_ || pictures.empty()) return;
    cv::Mat frame = sideBySide(pictures);
    if (film_ == nullptr) {
        filmWidth_ = frame.cols, filmHeight_ = frame.rows;
        film_ = openFilm(filmName_, kFilmRate, filmWidth_, filmHeight_);
        if (film_ == nullptr) {
            say(filmName_ + ": no film can be made; check the folder and the space on its disk");
            isFilming_ = false;
            return;
        }
        filmStart_ = std::chrono::steady_clock::now();
    }
    if (frame.cols != filmWidth_ || frame.rows != filmHeight_)
        cv::resize(frame, frame, {filmWidth_, filmHeight_}, 0, 0, cv::INTER_AREA);
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - filmStart_;
    for (const int due = static_cast<int>(passed.count() * kFilmRate) + 1; filmFrames_ < due; ++filmFrames_)
        film_->write(frame);
}

void PictureKeeper::endFilm() {
    isFilming_ = false;
    if (film_ == nullptr) return;
    film_.reset();
    sayPlainly("kept " + filmName_);
}

} // namespace app
