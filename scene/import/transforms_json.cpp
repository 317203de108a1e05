#include "scene/import/transforms_json.h"

#include "scene/errors.h"
#include "scene/import/camera_file.h"
#include "scene/picture_codec.h"

#include <cmath>
#include <fstream>
#include <optional>

#include <nlohmann/json.hpp>

namespace scene {

namespace {

using nlohmann::json;

constexpr std::uintmax_t kMaxManifestBytes = std::uintmax_t{1} << 30;
constexpr double kRotationTolerance = 1e-3; ///< manifests round their matrices

json parseManifest(const std::filesystem::path& manifest) {
    std::error_code error;
    const std::uintmax_t bytes = std::filesystem::file_size(manifest, error);
    if (error)
        throw Failure("cannot be read (" + error.message() + ")", manifest, "name the transforms.json of a capture");
    if (bytes > kMaxManifestBytes)
        throw Failure("manifest is larger than 1 GiB", manifest, "name the transforms.json of a capture");
    std::ifstream file(manifest);
    if (!file) throw Failure("cannot be opened", manifest, "check that it is readable");
    try {
        return json::parse(file);
    } catch (const json::parse_error& e) {
        throw Failure("is not valid JSON", atByte(manifest, e.byte), "repair it there, or export the capture again");
    } catch (const json::exception&) {
        throw Failure("holds a number that is too large", manifest, "repair it, or export the capture again");
    }
}

/// Not so where that cannot be told: what comes of it says so when it is read.
bool isMissing(const std::filesystem::path& picture) {
    std::error_code ignored;
    return std::filesystem::status(picture, ignored).type() == std::filesystem::file_type::not_found;
}

/// Why a frame cannot be used though nothing is wrong with it: the words of a sentence about it, and what is said if
/// no frame can.
struct Lack {
    std::string words;
    Failure failure;
};

class FrameReader {
  public:
    FrameReader(const std::filesystem::path& manifest, const json& root, const json& frame, std::size_t index)
        : manifest_(manifest), root_(root), frame_(frame),
          where_(manifest.string() + ", frame " + std::to_string(index)) {}

    /// Of its two pictures.
    std::optional<Lack> findLack() const {
        const std::filesystem::path colour = pathOf("file_path");
        const auto depth = frame_.find("depth_file_path");
        if (depth == frame_.end() || depth->is_null()) return Lack{"has no depth_file_path", hasNo("depth_file_path")};
        for (const std::filesystem::path& picture : {colour, pathOf("depth_file_path")})
            if (isMissing(picture))
                return Lack{"names '" + picture.string() + "', which is not there",
                            Failure("no such picture", picture, "check the path in the capture's list of frames")};
        return std::nullopt;
    }

    PhotoSource read() const {
        PhotoSource photo;
        photo.colourPath = pathOf("file_path");
        photo.depthPath = pathOf("depth_file_path");
        photo.name = photo.colourPath.stem().string();
        photo.camera = camera();
        photo.distortion = distortion();
        // What such a lens folds out in the corners no picture shows. Signs that are wrong fold nearly all of it.
        const double corner =
            std::hypot(0.5 * photo.camera.width / photo.camera.fx, 0.5 * photo.camera.height / photo.camera.fy);
        if (oneToOneWithin(photo.camera, photo.distortion) < 0.6 * corner)
            throw Failure("has a lens that folds the picture over itself", where_, "check the signs of k1, k2 and k3");
        photo.worldFromCamera = pose();
        photo.depthUnitMetres = findNumber("depth_unit_scale_factor");
        if (const auto unit = photo.depthUnitMetres; unit && (!(*unit > 0) || !std::isfinite(*unit)))
            throw Failure("depth_unit_scale_factor is not a positive number", where_,
                          "give metres per depth step, e.g. 0.001");
        return photo;
    }

  private:
    Failure hasNo(const char* pictureKey) const {
        return {std::string("has no ") + pictureKey, where_,
                "Revisit needs colour and depth for each frame: export the capture with depth"};
    }

    std::filesystem::path pathOf(const char* key) const {
        const auto found = frame_.find(key);
        if (found == frame_.end() || !found->is_string()) throw hasNo(key);
        if (found->get_ref<const std::string&>().empty())
            throw Failure(std::string(key) + " is empty", where_,
                          "name the picture's file, from the manifest's folder");
        const std::filesystem::path path(found->get<std::string>());
        return path.is_absolute() ? path : manifest_.parent_path() / path;
    }

    /// Of the frame, else of the whole manifest, else nothing.
    const json* find(const char* key) const {
        for (const json* from : {&frame_, &root_}) {
            const auto found = from->find(key);
            if (found != from->end() && !found->is_null()) return &*found;
        }
        return nullptr;
    }

    Failure isNot(const char* kind, const char* key, const json& value) const {
        return {std::string(key) + " is not " + kind + " but " + value.dump().substr(0, 40), where_, "correct it"};
    }

    std::optional<double> findNumber(const char* key) const {
        const json* const found = find(key);
        if (!found) return std::nullopt;
        if (!found->is_number()) throw isNot("a number", key, *found);
        return found->get<double>();
    }

    double need(const char* key) const {
        const auto value = findNumber(key);
        if (!value) throw Failure(std::string("has no ") + key, where_, "add the camera's intrinsics");
        return *value;
    }

    Camera camera() const {
        Camera camera;
        const double width = need("w"), height = need("h");
        if (!(width >= 1 && width <= kMaxPictureSide && height >= 1 && height <= kMaxPictureSide))
            throw Failure("picture size w x h is not between 1 and 65536", where_, "correct w and h");
        camera.width = static_cast<int>(width), camera.height = static_cast<int>(height);
        if (const auto fx = findNumber("fl_x")) {
            camera.fx = *fx;
        } else {
            const auto angle = findNumber("camera_angle_x");
            if (!angle) throw Failure("has neither fl_x nor camera_angle_x", where_, "add the camera's intrinsics");
            camera.fx = width / 2 / std::tan(*angle / 2);
        }
        camera.fy = findNumber("fl_y").value_or(camera.fx);
        camera.cx = findNumber("cx").value_or(width / 2);
        camera.cy = findNumber("cy").value_or(height / 2);
        if (!isUsable(camera))
            throw Failure("camera intrinsics are not usable numbers", where_, "correct fl_x, fl_y, cx, cy");
        return camera;
    }

    Failure isNotSupported(const std::string& model) const {
        return {"camera model " + model + " is not supported", where_, "undistort the pictures to a pinhole first"};
    }

    Distortion distortion() const {
        std::string model = "OPENCV";
        if (const json* const named = find("camera_model")) {
            if (!named->is_string()) throw isNot("a name", "camera_model", *named);
            model = named->get<std::string>();
        }
        const bool isRadial = model == "SIMPLE_RADIAL" || model == "RADIAL";
        if (model != "OPENCV" && model != "PINHOLE" && model != "SIMPLE_PINHOLE" && !isRadial)
            throw isNotSupported(model);
        if (const json* const fisheye = find("is_fisheye")) {
            if (!fisheye->is_boolean()) throw isNot("true or false", "is_fisheye", *fisheye);
            if (fisheye->get<bool>()) throw isNotSupported(model + " of a fisheye");
        }
        const auto number = [&](const char* key) { return findNumber(key).value_or(0.0); };
        for (const char* const key : {"k4", "k5", "k6"})
            if (number(key) != 0) throw isNotSupported(model + " with " + key);
        for (const char* const key : {"p1", "p2", "k3"})
            if (isRadial && number(key) != 0) throw isNotSupported(model + " with " + key);
        return {number("k1"), number("k2"), number("p1"), number("p2"), number("k3")};
    }

    Pose pose() const {
        const auto found = frame_.find("transform_matrix");
        glm::dmat4 worldFromGlCamera(0.0);
        bool isMatrix = found != frame_.end() && found->is_array() && found->size() == 4;
        for (int row = 0; isMatrix && row < 4; ++row) {
            const json& values = (*found)[static_cast<std::size_t>(row)];
            isMatrix = values.is_array() && values.size() == 4;
            for (int column = 0; isMatrix && column < 4; ++column) {
                const json& value = values[static_cast<std::size_t>(column)];
                isMatrix = value.is_number();
                if (isMatrix) worldFromGlCamera[column][row] = value.get<double>();
            }
        }
        Pose worldFromCamera;
        if (!isMatrix || !poseFromMatrix(worldFromGlCamera, kRotationTolerance, worldFromCamera))
            throw Failure("transform_matrix is not a rigid 4x4 pose", where_,
                          "give a finite rotation and translation without scale, or leave the frame out");
        // OpenGL axes (y up, z back) -> ours (y down, z forward).
        worldFromCamera.rotation[1] = -worldFromCamera.rotation[1];
        worldFromCamera.rotation[2] = -worldFromCamera.rotation[2];
        return worldFromCamera;
    }

    const std::filesystem::path& manifest_;
    const json& root_;
    const json& frame_;
    std::string where_;
};

} // namespace

void listTransformsJson(const std::filesystem::path& manifest, Capture& capture) {
    const json root = parseManifest(manifest);
    const auto frames = root.is_object() ? root.find("frames") : root.end();
    if (!root.is_object() || frames == root.end() || !frames->is_array() || frames->empty())
        throw Failure("lists no frames", manifest, "name the transforms.json of a capture with at least one frame");
    std::optional<Lack> first;
    std::size_t firstIndex = 0, leftOut = 0;
    try {
        for (std::size_t i = 0; i < frames->size(); ++i) {
            if (!(*frames)[i].is_object())
                throw Failure("is not an object", manifest.string() + ", frame " + std::to_string(i),
                              "repair the manifest");
            const FrameReader frame(manifest, root, (*frames)[i], i);
            if (std::optional<Lack> lack = frame.findLack()) {
                if (leftOut++ == 0) first = std::move(lack), firstIndex = i;
                continue;
            }
            capture.photos.push_back(frame.read());
        }
    } catch (const json::exception& e) {
        throw Failure(std::string("has a value of the wrong kind (") + e.what() + ")", manifest, "repair the manifest");
    }
    if (!first) return;
    if (leftOut == frames->size()) throw first->failure;
    capture.remarks.push_back(manifest.string() + ": " + std::to_string(leftOut) + " of " +
                              std::to_string(frames->size()) +
                              " frames lack their picture or its depth and were left out; the first, frame " +
                              std::to_string(firstIndex) + ", " + first->words + ".");
}

} // namespace scene
