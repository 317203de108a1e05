#include "scene/align/edge_pictures.h"

#include "scene/median.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr float kDiffusionStep = 0.2f, kDiffusionContrast = 8; ///< contrast: of 255, over the three channels
constexpr int kDiffusionSteps = 12;
constexpr double kPhotographSigma = 0.8, kRangeSigma = 1.0, kReflectanceSigma = 1.0, kCreaseSigma = 1.6,
                 kTextureSigma = 1.5; ///< pixels
constexpr int kSurface = 9,
              kSurfacePixels =
                  13;       ///< pixels across: of what is no edge but a surface; of the disparity to compare with
constexpr int kOpenRim = 9; ///< pixels across: of what is left out where range ends in nothing
constexpr float kTimesUsual = 2.2f;   ///< so many times the usual slope an edge counts half
constexpr float kLeastColourStep = 3; ///< a pixel, of 255
constexpr float kLeastTextureStep = 0.3f;
constexpr float kLeastGreyStep = 3;      ///< the same of evened reflectance
constexpr float kLeastRangeStep = 8e-3f; ///< of disparity, relative, a pixel
constexpr float kLeastBend = 2e-3f;      ///< second difference, relative
constexpr double kEdgeBroad = 4;         ///< times a level's sigma: what is taken off

cv::Mat3f matOf(const EdgeImage& image) {
    // OpenCV has no pictures that are lent for reading alone; nothing writes to this one.
    return {image.height(), image.width(),
            const_cast<cv::Vec3f*>(reinterpret_cast<const cv::Vec3f*>(image.pixels().data()))};
}

cv::Mat3b matOf(const Image<Rgb8>& image) {
    cv::Mat3b mat(image.height(), image.width());
    for (int y = 0; y < mat.rows; ++y)
        for (int x = 0; x < mat.cols; ++x)
            mat(y, x) = {image(x, y).r, image(x, y).g, image(x, y).b};
    return mat;
}

EdgeImage imageOf(const cv::Mat3f& mat) {
    EdgeImage image(mat.cols, mat.rows);
    for (int y = 0; y < mat.rows; ++y)
        for (int x = 0; x < mat.cols; ++x)
            image(x, y) = {mat(y, x)[0], mat(y, x)[1], mat(y, x)[2]};
    return image;
}

float saturated(float strength, float half) {
    return strength * strength / (strength * strength + half * half);
}

/// The gradients of a picture's channels together (Di Zenzo, "A note on the gradient of a multi-image", 1986): in each
/// pixel the strength, and the doubled angle times it.
cv::Mat3f slopesOf(const cv::Mat& picture) {
    cv::Mat dx, dy;
    cv::Scharr(picture, dx, CV_32F, 1, 0, 1.0 / 32);
    cv::Scharr(picture, dy, CV_32F, 0, 1, 1.0 / 32);
    const int channels = picture.channels();
    cv::Mat3f slopes(picture.rows, picture.cols);
    for (int y = 0; y < picture.rows; ++y) {
        const auto* const gx = dx.ptr<float>(y);
        const auto* const gy = dy.ptr<float>(y);
        for (int x = 0; x < picture.cols; ++x) {
            float xx = 0, xy = 0, yy = 0;
            for (int c = x * channels; c < (x + 1) * channels; ++c)
                xx += gx[c] * gx[c], xy += gx[c] * gy[c], yy += gy[c] * gy[c];
            const float squares = xx + yy, strength = std::sqrt(squares);
            const float per = squares > 0 ? strength / squares : 0;
            slopes(y, x) = {strength, (xx - yy) * per, 2 * xy * per};
        }
    }
    return slopes;
}

/// Strengths against what is usual in the picture; where mask is given, it alone says what is usual, and outside there
/// are no edges.
cv::Mat3f edgesOf(const cv::Mat3f& slopes, float least, const cv::Mat1b& mask = {}) {
    std::vector<float> strengths;
    for (int y = 0; y < slopes.rows; ++y)
        for (int x = 0; x < slopes.cols; ++x)
            if (mask.empty() || mask(y, x)) strengths.push_back(slopes(y, x)[0]);
    const float half = std::max(least, kTimesUsual * medianOf(strengths));
    cv::Mat3f edges(slopes.rows, slopes.cols, cv::Vec3f());
    for (int y = 0; y < slopes.rows; ++y)
        for (int x = 0; x < slopes.cols; ++x) {
            const cv::Vec3f& s = slopes(y, x);
            if (s[0] > 0 && (mask.empty() || mask(y, x))) edges(y, x) = s * (saturated(s[0], half) / s[0]);
        }
    return edges;
}

/// The greatest disparity about each pixel, so far that edges fade out before it changes.
cv::Mat1f greatestAbout(const cv::Mat1f& disparity) {
    cv::Mat1f greatest;
    cv::dilate(disparity, greatest, cv::Mat::ones(kSurfacePixels, kSurfacePixels, CV_8U));
    cv::max(greatest, cv::Scalar(1e-6), greatest);
    return greatest;
}

/// Steps of disparity, relative: where it changes faster than anywhere beside in a piece as wide as a surface. A
/// plane's own slope is the same all over it, and an opening leaves it.
cv::Mat3f stepsOf(const cv::Mat1f& disparity, const cv::Mat1f& greatest) {
    cv::Mat1f smooth;
    cv::GaussianBlur(disparity, smooth, {}, kRangeSigma);
    cv::Mat3f steps = slopesOf(smooth);
    cv::Mat1f strengths(steps.rows, steps.cols), usual;
    for (int y = 0; y < steps.rows; ++y)
        for (int x = 0; x < steps.cols; ++x)
            strengths(y, x) = steps(y, x)[0];
    cv::morphologyEx(strengths, usual, cv::MORPH_OPEN, cv::Mat::ones(kSurface, kSurface, CV_8U));
    for (int y = 0; y < steps.rows; ++y)
        for (int x = 0; x < steps.cols; ++x)
            if (strengths(y, x) > 0)
                steps(y, x) *= (strengths(y, x) - usual(y, x)) / (strengths(y, x) * greatest(y, x));
    return steps;
}

/// Second differences of disparity, relative: strength, and the doubled angle of the direction in which it bends most,
/// times it.
cv::Mat3f bendsOf(const cv::Mat1f& disparity, const cv::Mat1f& greatest) {
    cv::Mat1f smooth, dxx, dyy, dxy;
    cv::GaussianBlur(disparity, smooth, {}, kCreaseSigma);
    cv::Sobel(smooth, dxx, CV_32F, 2, 0, 1);
    cv::Sobel(smooth, dyy, CV_32F, 0, 2, 1);
    cv::Sobel(smooth, dxy, CV_32F, 1, 1, 3, 0.25);
    cv::Mat3f bends(disparity.rows, disparity.cols, cv::Vec3f());
    for (int y = 0; y < disparity.rows; ++y)
        for (int x = 0; x < disparity.cols; ++x) {
            const float xx = dxx(y, x), yy = dyy(y, x), xy = dxy(y, x);
            const float strength = std::sqrt(xx * xx + yy * yy + 2 * xy * xy) / greatest(y, x);
            const float across = xx - yy, turned = 2 * xy, length = std::hypot(across, turned);
            const float sign = xx + yy < 0 ? -1.0f : 1.0f, per = length > 0 ? sign * strength / length : 0;
            bends(y, x) = {strength, across * per, turned * per};
        }
    return bends;
}

/// Silhouettes and creases. A silhouette bends on both of its sides; beside one there is no crease.
cv::Mat3f rangeEdges(const cv::Mat1f& disparity) {
    const cv::Mat1f greatest = greatestAbout(disparity);
    cv::Mat3f edges = edgesOf(stepsOf(disparity, greatest), kLeastRangeStep);
    const cv::Mat3f creases = edgesOf(bendsOf(disparity, greatest), kLeastBend);
    cv::Mat1f silhouettes(edges.rows, edges.cols), beside;
    for (int y = 0; y < edges.rows; ++y)
        for (int x = 0; x < edges.cols; ++x)
            silhouettes(y, x) = edges(y, x)[0];
    cv::dilate(silhouettes, beside, cv::Mat::ones(kSurface, kSurface, CV_8U));
    for (int y = 0; y < edges.rows; ++y)
        for (int x = 0; x < edges.cols; ++x)
            edges(y, x) += (1 - beside(y, x)) * creases(y, x);
    return edges;
}

/// One step of diffusion. OpenCV's own (ximgproc) gives other bytes on other numbers of threads.
cv::Mat3f diffused(const cv::Mat3f& picture) {
    cv::Mat3f result(picture.rows, picture.cols);
    constexpr float kPerSquare = 1 / (kDiffusionContrast * kDiffusionContrast);
    tbb::parallel_for(0, picture.rows, [&](int y) {
        const int above = std::max(y - 1, 0), below = std::min(y + 1, picture.rows - 1);
        for (int x = 0; x < picture.cols; ++x) {
            const cv::Vec3f here = picture(y, x);
            cv::Vec3f flow(0, 0, 0);
            const auto add = [&](int j, int i) {
                const cv::Vec3f step = picture(j, i) - here;
                flow += std::exp(-step.dot(step) * kPerSquare) * step;
            };
            add(above, x);
            add(below, x);
            add(y, std::max(x - 1, 0));
            add(y, std::min(x + 1, picture.cols - 1));
            result(y, x) = here + kDiffusionStep * flow;
        }
    });
    return result;
}

} // namespace

EdgeImage photographEdges(const Image<Rgb8>& photograph) {
    cv::Mat3f picture;
    matOf(photograph).convertTo(picture, CV_32F);
    for (int i = 0; i < kDiffusionSteps; ++i)
        picture = diffused(picture);
    cv::Mat smooth;
    cv::GaussianBlur(picture, smooth, {}, kPhotographSigma);
    return imageOf(edgesOf(slopesOf(smooth), kLeastColourStep));
}

EdgeImage textureEdges(const Image<Rgb8>& photograph) {
    cv::Mat numbers;
    matOf(photograph).convertTo(numbers, CV_32F);
    cv::GaussianBlur(numbers, numbers, {}, kTextureSigma);
    return imageOf(edgesOf(slopesOf(numbers), kLeastTextureStep));
}

EdgeImage scanEdges(const DepthImage& scan) {
    const int width = scan.camera.width, height = scan.camera.height;
    cv::Mat1f disparity(height, width, 0.0f), grey(height, width, 0.0f), weight(height, width, 0.0f);
    cv::Mat1b isSurfaceThere(height, width, std::uint8_t{0});
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            if (!isSurface(scan.flags(x, y))) continue;
            disparity(y, x) = scan.disparity(x, y);
            grey(y, x) = scan.colour(x, y).g;
            weight(y, x) = 1;
            isSurfaceThere(y, x) = 255;
        }
    cv::GaussianBlur(grey, grey, {}, kReflectanceSigma);
    cv::GaussianBlur(weight, weight, {}, kReflectanceSigma);
    grey /= cv::max(weight, 1e-3f);
    cv::Mat1b inside;
    cv::erode(isSurfaceThere, inside, cv::Mat::ones(5, 5, CV_8U));
    cv::Mat3f edges = edgesOf(slopesOf(grey), kLeastGreyStep, inside);
    edges += rangeEdges(disparity);
    return imageOf(edges);
}

EdgeImage withoutOpenRims(const EdgeImage& edges, const DepthImage& scan) {
    cv::Mat1b isOpen(edges.height(), edges.width()), near;
    for (int y = 0; y < isOpen.rows; ++y)
        for (int x = 0; x < isOpen.cols; ++x)
            isOpen(y, x) = isSurface(scan.flags(x, y)) ? 0 : 255;
    cv::dilate(isOpen, near, cv::Mat::ones(kOpenRim, kOpenRim, CV_8U));
    EdgeImage inside = edges;
    for (int y = 0; y < isOpen.rows; ++y)
        for (int x = 0; x < isOpen.cols; ++x)
            if (near(y, x)) inside(x, y) = glm::vec3(0);
    return inside;
}

EdgeLevel blurredEdges(const EdgeImage& edges, double sigmaPixels) {
    EdgeLevel level;
    level.sigmaPixels = sigmaPixels;
    level.pixelsPerPixel =
        std::clamp(static_cast<int>(sigmaPixels / 2), 1, std::max(1, std::min(edges.width(), edges.height())));
    cv::Mat3f picture = matOf(edges), fine, broad;
    if (level.pixelsPerPixel > 1) {
        cv::Mat3f small;
        // Whole pixels: the rest at the right and lower rim is left out.
        const int n = level.pixelsPerPixel;
        const cv::Rect whole(0, 0, picture.cols / n * n, picture.rows / n * n);
        cv::resize(picture(whole), small, {}, 1.0 / n, 1.0 / n, cv::INTER_AREA);
        picture = small;
    }
    const double sigma = sigmaPixels / level.pixelsPerPixel;
    cv::GaussianBlur(picture, fine, {}, sigma);
    cv::GaussianBlur(picture, broad, {}, kEdgeBroad * sigma);
    fine -= broad;
    double squares = 0;
    for (int y = 0; y < fine.rows; ++y)
        for (int x = 0; x < fine.cols; ++x)
            squares += fine(y, x).dot(fine(y, x));
    const double deviation = std::sqrt(squares / std::max<double>(1, static_cast<double>(fine.total())));
    if (deviation > 0) fine *= 1 / deviation;
    level.edges = Image<glm::vec4>(fine.cols, fine.rows);
    for (int y = 0; y < fine.rows; ++y)
        for (int x = 0; x < fine.cols; ++x)
            level.edges(x, y) = {fine(y, x)[0], fine(y, x)[1], fine(y, x)[2], 0.0f};
    return level;
}

std::vector<EdgePoint> edgePoints(const EdgeImage& edges, int columns, int rows, int mostInPart) {
    constexpr float kLeast = 0.1f;
    constexpr int kPictureRim = 4; ///< where the picture ends is no edge
    std::vector<EdgePoint> points, part;
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            part.clear();
            const int x0 = std::max(edges.width() * column / columns, kPictureRim),
                      x1 = std::min(edges.width() * (column + 1) / columns, edges.width() - kPictureRim);
            const int y0 = std::max(edges.height() * row / rows, kPictureRim),
                      y1 = std::min(edges.height() * (row + 1) / rows, edges.height() - kPictureRim);
            for (int y = y0; y < y1; ++y)
                for (int x = x0; x < x1; ++x) {
                    const glm::vec3& e = edges(x, y);
                    if (e.x < kLeast) continue;
                    const float angle = 0.5f * std::atan2(e.z, e.y), nx = std::cos(angle), ny = std::sin(angle);
                    const auto strengthAt = [&](float t) {
                        const float px = static_cast<float>(x) + t * nx, py = static_cast<float>(y) + t * ny;
                        const int ix = static_cast<int>(px), iy = static_cast<int>(py);
                        const float fx = px - static_cast<float>(ix), fy = py - static_cast<float>(iy);
                        return (1 - fy) * ((1 - fx) * edges(ix, iy).x + fx * edges(ix + 1, iy).x) +
                               fy * ((1 - fx) * edges(ix, iy + 1).x + fx * edges(ix + 1, iy + 1).x);
                    };
                    const float before = strengthAt(-1), after = strengthAt(1);
                    if (e.x < before || e.x <= after) continue;
                    const float bend = before + after - 2 * e.x;
                    const float t = bend < 0 ? std::clamp(0.5f * (before - after) / bend, -0.5f, 0.5f) : 0;
                    const float length = std::max(std::hypot(e.y, e.z), 1e-6f);
                    part.push_back({static_cast<float>(x) + 0.5f + t * nx, static_cast<float>(y) + 0.5f + t * ny, e.x,
                                    e.y / length, e.z / length});
                }
            const auto most = std::min(std::ssize(part), static_cast<std::ptrdiff_t>(mostInPart));
            std::partial_sort(part.begin(), part.begin() + most, part.end(),
                              [](const EdgePoint& a, const EdgePoint& b) {
                                  if (a.strength != b.strength) return a.strength > b.strength;
                                  return a.y != b.y ? a.y < b.y : a.x < b.x;
                              });
            points.insert(points.end(), part.begin(), part.begin() + most);
        }
    return points;
}

Image<Rgb8> pictureOfEdges(const EdgeImage& edges) {
    Image<Rgb8> picture(edges.width(), edges.height());
    for (int y = 0; y < edges.height(); ++y)
        for (int x = 0; x < edges.width(); ++x) {
            const glm::vec3& e = edges(x, y);
            const auto byte = [](float v) { return static_cast<std::uint8_t>(std::clamp(v, 0.0f, 255.0f)); };
            picture(x, y) = {byte(180 * e.x + 120 * e.y), byte(180 * e.x), byte(180 * e.x + 120 * e.z)};
        }
    return picture;
}

} // namespace scene
