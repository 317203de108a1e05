#include "app/truth.h"

#include "app/stage_store.h"

#include "render/shaders/shared/z_key.h"
#include "scene/depth_tiff.h"
#include "scene/errors.h"
#include "scene/picture_codec.h"
#include "scene/scene_file.h"

#include <opencv2/core.hpp>

#include <array>

namespace app {

namespace {

constexpr std::array kPictureEndings{".png", ".jpg", ".jpeg"};

void requireSize(int width, int height, const scene::Camera& camera, const std::filesystem::path& path) {
    if (width == camera.width && height == camera.height) return;
    throw scene::Failure("has " + std::to_string(width) + "x" + std::to_string(height) + " pixels, but its camera " +
                             std::to_string(camera.width) + "x" + std::to_string(camera.height),
                         path, "give the size of the picture in the cameras file");
}

/// Of the camera's size, which is asked for before memory is taken for it.
cv::Mat pictureFrom(const std::filesystem::path& path, scene::PictureKind kind, const scene::Camera& camera) {
    const std::vector<std::byte> whole = readWhole(path);
    const std::span bytes(reinterpret_cast<const std::uint8_t*>(whole.data()), whole.size());
    if (const auto size = scene::sizeInHeader(bytes)) requireSize(size->width, size->height, camera, path);
    cv::Mat picture = scene::decodePicture(bytes, kind);
    if (picture.empty()) throw scene::Failure("is no picture", path, "give the picture that the camera took");
    requireSize(picture.cols, picture.rows, camera, path);
    return picture;
}

Truth readDepthImage(const std::filesystem::path& path, const scene::Camera& camera) {
    const scene::DepthImage image = scene::readDepthTiff(path);
    requireSize(image.camera.width, image.camera.height, camera, path);
    return truthOf(image);
}

/// stem: the camera's name in its folder.
Truth readPictures(const std::filesystem::path& colourPath, const std::string& stem, const scene::Camera& camera) {
    const std::filesystem::path depthPath = stem + "-depth.tiff", classPath = stem + "-class.png";
    const cv::Mat3b colour = pictureFrom(colourPath, scene::PictureKind::colour, camera);
    Truth truth{{camera.width, camera.height}, {}};
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x)
            truth.colour(x, y) = {colour(y, x)[2], colour(y, x)[1], colour(y, x)[0]};
    if (!std::filesystem::exists(depthPath)) return truth;
    const cv::Mat depth = pictureFrom(depthPath, scene::PictureKind::asStored, camera);
    if (depth.type() != CV_32FC1)
        throw scene::Failure("is not of 32 bit floating point", depthPath, "give depth in metres, or none");
    truth.depthMetres = {camera.width, camera.height};
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
            const float metres = depth.at<float>(y, x);
            truth.depthMetres(x, y) = metres > 0 ? metres : 0;
        }
    if (!std::filesystem::exists(classPath)) return truth;
    const cv::Mat pixelClass = pictureFrom(classPath, scene::PictureKind::asStored, camera);
    if (pixelClass.type() != CV_8UC1)
        throw scene::Failure("is not grey with 8 bit", classPath,
                             "give classes as `render --aux` writes them, or none");
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x)
            if (pixelClass.at<std::uint8_t>(y, x) != render::kClassSeen) truth.depthMetres(x, y) = 0;
    return truth;
}

} // namespace

std::vector<TruthSource> heldOutTruths(const scene::Scene& scene) {
    std::vector<TruthSource> truths;
    for (NamedView& view : heldOutViews(scene)) {
        const std::filesystem::path file = scene.folder / scene::kHeldOutFolder / (view.name + ".tiff");
        if (!std::filesystem::exists(file))
            throw scene::Failure("is missing: the scene was built without it", file,
                                 "build the scene again with this Revisit, or give --cameras FILE");
        const scene::Camera camera = view.camera;
        truths.push_back({std::move(view), [file, camera] { return readDepthImage(file, camera); }});
    }
    if (truths.empty())
        throw scene::Failure("has no held-out photographs to measure by", scene.folder,
                             "build it with --hold-out every:20:10, or give --cameras FILE");
    return truths;
}

std::vector<TruthSource> truthsBeside(const std::filesystem::path& camerasFile) {
    std::vector<TruthSource> truths;
    for (NamedView& view : readCamerasFile(camerasFile)) {
        const std::filesystem::path stem = camerasFile.parent_path() / view.name;
        const auto with = [&](const char* ending) { return std::filesystem::path(stem.string() + ending); };
        const scene::Camera camera = view.camera;
        std::function<Truth()> read;
        if (std::filesystem::exists(with(".tiff"))) {
            read = [file = with(".tiff"), camera] { return readDepthImage(file, camera); };
        } else {
            for (const char* ending : kPictureEndings)
                if (!read && std::filesystem::exists(with(ending)))
                    read = [file = with(ending), stem, camera] { return readPictures(file, stem.string(), camera); };
        }
        if (!read)
            throw scene::Failure("is missing: the camera has no picture beside the cameras file", with(".png"),
                                 "put what it took there: NAME.png, .jpg or .tiff");
        truths.push_back({std::move(view), std::move(read)});
    }
    return truths;
}

} // namespace app
