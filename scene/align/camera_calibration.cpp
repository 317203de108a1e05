#include "scene/align/camera_calibration.h"

#include "scene/errors.h"
#include "scene/picture_codec.h"

#include <algorithm>
#include <cmath>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace scene {

namespace {

constexpr int kLeastBoards = 3;
constexpr int kNarrowestWindow = 2, kWidestWindow = 11;
constexpr double kWindowShare = 0.25;        ///< of the way to the next corner
constexpr double kMostFocalDeviation = 0.03; ///< share of the focal length: beyond, boards do not hold it
/// Cosine between the normals of the two boards that differ most: boards that all stand alike fit any focal length, and
/// least squares then ends at a great one that it takes to be exact.
constexpr double kMostAlike = 0.985;

using Corners = std::vector<cv::Point2f>;

/// Shortest way between corners that are neighbours on the board, in pixels.
double spacingOf(const Corners& corners, const BoardOptions& options) {
    double shortest = 1e9;
    for (int y = 0; y < options.rows; ++y)
        for (int x = 0; x < options.columns; ++x) {
            const auto i = static_cast<std::size_t>(y * options.columns + x);
            if (x + 1 < options.columns) shortest = std::min(shortest, cv::norm(corners[i + 1] - corners[i]));
            if (y + 1 < options.rows)
                shortest =
                    std::min(shortest, cv::norm(corners[i + static_cast<std::size_t>(options.columns)] - corners[i]));
        }
    return shortest;
}

/// Empty if there is no board, or only a part of one.
Corners findCorners(const cv::Mat& grey, const BoardOptions& options) {
    Corners corners;
    if (!cv::findChessboardCorners(grey, {options.columns, options.rows}, corners,
                                   cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE))
        return {};
    const int window =
        options.windowPixels > 0
            ? options.windowPixels
            : std::clamp(static_cast<int>(kWindowShare * spacingOf(corners, options)), kNarrowestWindow, kWidestWindow);
    cv::cornerSubPix(grey, corners, {window, window}, {-1, -1},
                     {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 100, 1e-4});
    return corners;
}

std::vector<cv::Point3f> boardCorners(const BoardOptions& options) {
    std::vector<cv::Point3f> corners;
    const auto square = static_cast<float>(options.squareMetres);
    for (int y = 0; y < options.rows; ++y)
        for (int x = 0; x < options.columns; ++x)
            corners.emplace_back(static_cast<float>(x) * square, static_cast<float>(y) * square, 0.0f);
    return corners;
}

/// Where on the board's plane the camera sees what stands at these pixels.
std::vector<cv::Point2d> seenOnBoard(const Corners& corners, const cv::Matx33d& k, const cv::Mat& lens,
                                     const cv::Mat& turn, const cv::Mat& place) {
    std::vector<cv::Point2f> straight;
    cv::undistortPoints(corners, straight, k, lens);
    cv::Matx33d cameraFromBoard;
    cv::Rodrigues(turn, cameraFromBoard);
    const cv::Vec3d t(place.at<double>(0), place.at<double>(1), place.at<double>(2));
    const cv::Vec3d eye = -(cameraFromBoard.t() * t);
    std::vector<cv::Point2d> seen;
    for (const cv::Point2f& p : straight) {
        const cv::Vec3d ray = cameraFromBoard.t() * cv::Vec3d(p.x, p.y, 1);
        const double s = -eye[2] / ray[2];
        seen.emplace_back(eye[0] + s * ray[0], eye[1] + s * ray[1]);
    }
    return seen;
}

double leastCosine(const std::vector<cv::Mat>& turns) {
    std::vector<cv::Vec3d> normals;
    for (const cv::Mat& turn : turns) {
        cv::Matx33d rotation;
        cv::Rodrigues(turn, rotation);
        normals.emplace_back(rotation(0, 2), rotation(1, 2), rotation(2, 2));
    }
    double least = 1;
    for (const cv::Vec3d& a : normals)
        for (const cv::Vec3d& b : normals)
            least = std::min(least, a.dot(b));
    return least;
}

/// What is seen in the pictures; those of no use are told why.
struct Boards {
    cv::Size size;
    std::vector<Corners> corners;
    std::vector<std::size_t> pictures; ///< which of them each board stands in
};

Boards findBoards(const BoardOptions& options, std::vector<BoardPicture>& pictures) {
    Boards boards;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        BoardPicture& picture = pictures[i];
        const cv::Mat grey = readPicture(picture.path, PictureKind::grey);
        if (grey.empty()) {
            picture.why = "cannot be read as a picture";
            continue;
        }
        if (boards.size.empty()) boards.size = grey.size();
        if (grey.size() != boards.size) {
            picture.why = "is of another size than the first picture";
            continue;
        }
        Corners corners = findCorners(grey, options);
        if (corners.empty()) {
            picture.why = "shows no whole board of " + std::to_string(options.columns) + " x " +
                          std::to_string(options.rows) + " inner corners";
            continue;
        }
        picture.isFound = true;
        boards.corners.push_back(std::move(corners));
        boards.pictures.push_back(i);
    }
    return boards;
}

CameraCalibration calibratedBy(const std::vector<std::filesystem::path>& pictures, const BoardOptions& options) {
    CameraCalibration result;
    for (const std::filesystem::path& path : pictures)
        result.pictures.push_back({path, false, 0, 0, 0, {}});
    const Boards boards = findBoards(options, result.pictures);
    const std::string where = pictures.empty() ? "the pictures" : pictures.front().string() + " and the others";
    if (boards.corners.size() < kLeastBoards) {
        const auto unused = std::find_if(result.pictures.begin(), result.pictures.end(),
                                         [](const BoardPicture& picture) { return !picture.isFound; });
        std::string what = "a board was found in " + std::to_string(boards.corners.size()) + " of " +
                           std::to_string(pictures.size()) + " pictures, and " + std::to_string(kLeastBoards) +
                           " are needed";
        if (unused != result.pictures.end()) what += " (" + unused->path.filename().string() + " " + unused->why + ")";
        throw Failure(what, where, "take more pictures of the whole board, and say how many inner corners it has");
    }

    const std::vector<std::vector<cv::Point3f>> onBoard(boards.corners.size(), boardCorners(options));
    cv::Mat k, lens, deviations, boardDeviations, perBoard;
    std::vector<cv::Mat> turns, places;
    result.rmsPixels = cv::calibrateCamera(onBoard, boards.corners, boards.size, k, lens, turns, places, deviations,
                                           boardDeviations, perBoard);
    const cv::Matx33d matrix = k;
    result.focalDeviation = std::max(deviations.at<double>(0), deviations.at<double>(1));
    result.centreDeviation = std::max(deviations.at<double>(2), deviations.at<double>(3));
    if (leastCosine(turns) > kMostAlike || !(result.focalDeviation < kMostFocalDeviation * matrix(0, 0)) ||
        !std::isfinite(result.rmsPixels))
        throw Failure("boards do not tell the focal length: all stand alike to the camera", where,
                      "tilt the board this way and that, and bring it near and far");
    // OpenCV counts pixel centres at whole numbers.
    result.camera = {boards.size.width, boards.size.height, matrix(0, 0),
                     matrix(1, 1),      matrix(0, 2) + 0.5, matrix(1, 2) + 0.5};
    const auto coefficient = [&](int i) { return lens.at<double>(i); };
    result.distortion = {coefficient(0), coefficient(1), coefficient(2), coefficient(3), coefficient(4)};

    double corners = 0;
    for (std::size_t b = 0; b < boards.corners.size(); ++b) {
        BoardPicture& picture = result.pictures[boards.pictures[b]];
        Corners shown;
        cv::projectPoints(onBoard[b], turns[b], places[b], k, lens, shown);
        const std::vector<cv::Point2d> seen = seenOnBoard(boards.corners[b], matrix, lens, turns[b], places[b]);
        for (std::size_t i = 0; i < shown.size(); ++i) {
            const double pixels = cv::norm(shown[i] - boards.corners[b][i]);
            const double metres = cv::norm(seen[i] - cv::Point2d(onBoard[b][i].x, onBoard[b][i].y));
            picture.meanPixels += pixels / static_cast<double>(shown.size());
            picture.meanMetres += metres / static_cast<double>(shown.size());
            picture.worstPixels = std::max(picture.worstPixels, pixels);
            result.meanPixels += pixels;
            result.meanMetres += metres;
            result.worstPixels = std::max(result.worstPixels, pixels);
            result.worstMetres = std::max(result.worstMetres, metres);
            corners += 1;
        }
    }
    result.meanPixels /= corners;
    result.meanMetres /= corners;
    return result;
}

} // namespace

CameraCalibration calibrateCamera(const std::vector<std::filesystem::path>& pictures, const BoardOptions& options) {
    try {
        return calibratedBy(pictures, options);
    } catch (const cv::Exception& exception) {
        throw Failure("cannot be calibrated from (" + std::string(exception.err) + ")",
                      pictures.empty() ? "the pictures" : pictures.front().string() + " and the others",
                      "leave --corner-window to itself, or take other pictures");
    }
}

} // namespace scene
