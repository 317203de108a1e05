#pragma once
// Pictures that the program drew, against those a camera took from the same place.

#include <filesystem>
#include <functional>
#include <string>

#include <nlohmann/json.hpp>

#include <opencv2/core.hpp>

namespace app {

nlohmann::json readJson(const std::filesystem::path& path);

/// Decibels over the pixels that are not 0 in `where`.
double psnr(const cv::Mat3b& a, const cv::Mat3b& b, const cv::Mat1b& where);

struct Agreement {
    int pictures = 0;
    double meanPsnr = 0;                      ///< over the pictures, each over its seen pixels
    double seenShare = 0;                     ///< of all pixels
    double coveredPsnr = 0, coveredShare = 0; ///< the same over pixels that are seen or filled
};

/// The held-out cameras of a scene, drawn into `frames` with --aux, against the pictures that truthOf names for each.
Agreement compareHeldOut(const std::filesystem::path& scene, const std::filesystem::path& frames,
                         const std::function<std::filesystem::path(const std::string&)>& truthOf);

} // namespace app
