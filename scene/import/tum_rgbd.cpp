#include "scene/import/tum_rgbd.h"

#include "scene/errors.h"
#include "scene/picture_codec.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <sstream>
#include <vector>

#include <glm/gtc/quaternion.hpp>

#include <opencv2/core.hpp>

namespace scene {

namespace {

constexpr double kMaxTimeDifference = 0.02; ///< seconds, as the benchmark's own association
constexpr double kDepthUnit = 1.0 / 5000.0; ///< metres per step, fixed by the benchmark

struct StampedFile {
    double time = 0;
    std::string path;
};

struct StampedPose {
    double time = 0;
    glm::dvec3 translation{};
    glm::dquat rotation{};
};

/// The words of each line that is neither empty nor a comment, with the line's number.
template <class Take>
void readLines(const std::filesystem::path& path, Take take) {
    std::ifstream file(path);
    if (!file) throw Failure("cannot be opened", path, "a TUM sequence has rgb.txt, depth.txt and groundtruth.txt");
    std::string line;
    for (std::size_t number = 1; std::getline(file, line); ++number) {
        std::istringstream words(line);
        std::vector<std::string> list;
        for (std::string word; words >> word;)
            list.push_back(word);
        if (!list.empty() && list.front()[0] != '#') take(list, number);
    }
}

double toNumber(const std::string& word, const std::filesystem::path& path, std::size_t line) {
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
        throw Failure("'" + word + "' is not a number", atLine(path, line), "repair the line or remove it");
    return value;
}

template <class Stamped>
void sortByTime(std::vector<Stamped>& list) {
    std::stable_sort(list.begin(), list.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
}

std::vector<StampedFile> readFileList(const std::filesystem::path& path) {
    std::vector<StampedFile> files;
    readLines(path, [&](const std::vector<std::string>& words, std::size_t line) {
        if (words.size() < 2) throw Failure("has no file name", atLine(path, line), "write: timestamp file");
        files.push_back({toNumber(words[0], path, line), words[1]});
    });
    sortByTime(files);
    return files;
}

std::vector<StampedPose> readPoses(const std::filesystem::path& path) {
    std::vector<StampedPose> poses;
    readLines(path, [&](const std::vector<std::string>& words, std::size_t line) {
        if (words.size() < 8)
            throw Failure("is not a pose", atLine(path, line), "write: timestamp tx ty tz qx qy qz qw");
        double v[8];
        for (std::size_t i = 0; i < 8; ++i)
            v[i] = toNumber(words[i], path, line);
        glm::dquat rotation;
        rotation.x = v[4], rotation.y = v[5], rotation.z = v[6], rotation.w = v[7];
        const double length = glm::length(rotation);
        if (!(length > 0.5 && length < 2.0))
            throw Failure("quaternion is not of length 1", atLine(path, line), "repair the line or remove it");
        poses.push_back({v[0], {v[1], v[2], v[3]}, rotation / length});
    });
    sortByTime(poses);
    return poses;
}

const StampedFile* findNearest(const std::vector<StampedFile>& files, double time) {
    const auto after = std::lower_bound(files.begin(), files.end(), time,
                                        [](const StampedFile& file, double t) { return file.time < t; });
    const StampedFile* best = nullptr;
    if (after != files.end()) best = &*after;
    if (after != files.begin() && (!best || time - std::prev(after)->time < best->time - time))
        best = &*std::prev(after);
    return best && std::abs(best->time - time) <= kMaxTimeDifference ? best : nullptr;
}

std::optional<Pose> poseAt(const std::vector<StampedPose>& poses, double time) {
    const auto after = std::lower_bound(poses.begin(), poses.end(), time,
                                        [](const StampedPose& pose, double t) { return pose.time < t; });
    if (after == poses.end() || (after == poses.begin() && after->time - time > kMaxTimeDifference)) {
        if (poses.empty() || std::abs(poses.back().time - time) > kMaxTimeDifference) return std::nullopt;
        return Pose{glm::mat3_cast(poses.back().rotation), poses.back().translation};
    }
    if (after == poses.begin()) return Pose{glm::mat3_cast(after->rotation), after->translation};
    const StampedPose& a = *std::prev(after);
    const StampedPose& b = *after;
    if (std::min(time - a.time, b.time - time) > kMaxTimeDifference) return std::nullopt;
    const double t = b.time > a.time ? (time - a.time) / (b.time - a.time) : 0.0;
    return Pose{glm::mat3_cast(glm::slerp(a.rotation, b.rotation, t)), glm::mix(a.translation, b.translation, t)};
}

struct Intrinsics {
    double fx, fy, cx, cy;
    Distortion distortion;
};

Intrinsics findIntrinsics(const std::filesystem::path& folder, std::vector<std::string>& remarks) {
    const std::filesystem::path file = folder / "intrinsics.txt";
    if (std::filesystem::exists(file)) {
        std::vector<double> v;
        readLines(file, [&](const std::vector<std::string>& words, std::size_t line) {
            for (const std::string& word : words)
                v.push_back(toNumber(word, file, line));
        });
        if (v.size() < 4) throw Failure("has fewer than four numbers", file, "write: fx fy cx cy [k1 k2 p1 p2 k3]");
        v.resize(9, 0.0);
        return {v[0], v[1], v[2], v[3], {v[4], v[5], v[6], v[7], v[8]}};
    }
    const std::string name = std::filesystem::absolute(folder).string();
    const auto isFrom = [&](const char* camera) { return name.find(camera) != std::string::npos; };
    const std::string remark = folder.string() + ": has no intrinsics.txt; ";
    if (isFrom("freiburg1")) {
        remarks.push_back(remark + "taken to be the benchmark's freiburg1 camera.");
        return {517.3, 516.5, 318.6, 255.3, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}};
    }
    if (isFrom("freiburg2")) {
        remarks.push_back(remark + "taken to be the benchmark's freiburg2 camera.");
        return {520.9, 521.0, 325.1, 249.7, {0.2312, -0.7849, -0.0033, -0.0001, 0.9172}};
    }
    if (isFrom("freiburg3")) {
        remarks.push_back(remark + "taken to be the benchmark's freiburg3 camera.");
        return {535.4, 539.2, 320.1, 247.6, {}};
    }
    remarks.push_back(remark + "taken to be the sensor's default, fx = fy = 525, centre 319.5, 239.5.");
    return {525.0, 525.0, 319.5, 239.5, {}};
}

/// Empty if the picture cannot be read.
cv::Size sizeOf(const std::filesystem::path& picture) {
    const std::vector<std::uint8_t> bytes = readPictureBytes(picture);
    if (const std::optional<PictureSize> size = sizeInHeader(bytes)) return {size->width, size->height};
    return decodePicture(bytes, PictureKind::colour).size();
}

} // namespace

void listTumRgbd(const std::filesystem::path& folder, Capture& capture) {
    const std::vector<StampedFile> colours = readFileList(folder / "rgb.txt");
    const std::vector<StampedFile> depths = readFileList(folder / "depth.txt");
    const std::vector<StampedPose> poses = readPoses(folder / "groundtruth.txt");
    const Intrinsics intrinsics = findIntrinsics(folder, capture.remarks);

    const bool isDefault = !std::filesystem::exists(folder / "intrinsics.txt");
    std::size_t taken = 0;
    cv::Size size;
    for (const StampedFile& colour : colours) {
        const StampedFile* depth = findNearest(depths, colour.time);
        const std::optional<Pose> pose = poseAt(poses, colour.time);
        if (!depth || !pose) continue;
        PhotoSource photo;
        photo.colourPath = folder / colour.path;
        photo.depthPath = folder / depth->path;
        photo.name = photo.colourPath.stem().string();
        if (size.empty()) size = sizeOf(photo.colourPath);
        if (isDefault && !size.empty() && size != cv::Size(640, 480))
            throw Failure("has no intrinsics.txt, and what is usual is of pictures of 640x480, not " +
                              std::to_string(size.width) + "x" + std::to_string(size.height),
                          folder, "write intrinsics.txt: fx fy cx cy [k1 k2 p1 p2 k3]");
        if (size.empty() || std::max(size.width, size.height) > kMaxPictureSide)
            throw Failure("first picture cannot be read", photo.colourPath, "check the paths in rgb.txt");
        // The benchmark counts the centre of the first pixel at 0, we at 1/2.
        photo.camera = {size.width,    size.height,         intrinsics.fx,
                        intrinsics.fy, intrinsics.cx + 0.5, intrinsics.cy + 0.5};
        if (!isUsable(photo.camera))
            throw Failure("has a focal length that is not positive", folder / "intrinsics.txt", "write: fx fy cx cy");
        photo.distortion = intrinsics.distortion;
        photo.worldFromCamera = *pose;
        photo.depthUnitMetres = kDepthUnit;
        capture.photos.push_back(std::move(photo));
        ++taken;
    }
    if (taken == 0)
        throw Failure("no picture has both depth and a pose within 20 ms", folder,
                      "check the time stamps of the three lists");
    if (taken < colours.size())
        capture.remarks.push_back(folder.string() + ": " + std::to_string(colours.size() - taken) + " of " +
                                  std::to_string(colours.size()) +
                                  " pictures have no depth or pose within 20 ms and were left out.");
}

} // namespace scene
