#pragma once
// Picture files for tests of photo import.

#include "scene/camera.h"

#include <cmath>
#include <filesystem>
#include <functional>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

namespace scene {

/// Colour by column and row: r = 3 x, g = 5 y, b = 7.
inline cv::Mat gradientPicture(int width, int height) {
    cv::Mat picture(height, width, CV_8UC3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            picture.at<cv::Vec3b>(y, x) = {7, static_cast<unsigned char>(5 * y), static_cast<unsigned char>(3 * x)};
    return picture;
}

/// 16 bit steps, the same everywhere.
inline cv::Mat flatDepth(int width, int height, int steps) {
    return cv::Mat(height, width, CV_16UC1, cv::Scalar(steps));
}

inline void writePicture(const std::filesystem::path& path, const cv::Mat& picture) {
    std::filesystem::create_directories(path.parent_path());
    ASSERT_TRUE(cv::imwrite(path.string(), picture)) << path;
}

} // namespace scene
