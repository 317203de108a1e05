// make_sample: writes a sample RGB-D capture of a synthetic scene, in the form that nerfstudio reads and
// writes, and a walk through it; or sample laser scans (app/sample_scans.h).
//
//   OUT/transforms.json   intrinsics, and for each frame its files and camera-to-world matrix with the camera
//   axes of
//                         OpenGL (x right, y up, z backwards); world: metres, +Z up
//   OUT/images/*.png|jpg  colour
//   OUT/depth/*.png       16 bit depth along z in steps of the depth unit; 0: no surface, or too far to be
//   written OUT/walk.json         a path file of space "world": head poses whose axes are x right, y up, z
//   backwards

#include "app/real_range.h"
#include "app/sample_scans.h"

#include "scene/errors.h"
#include "scene/synthetic.h"
#include "scene/synthetic_random.h"

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

namespace app {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct SampleOptions {
    fs::path out;
    std::string sceneName = "room";
    int images = 60;
    std::string size = "640x480";
    int samplesPerPixel = 4;
    double noiseMillimetres = 0;
    double depthUnitMetres = 0.001;
    std::uint32_t seed = 1;
    std::string format = "png";
    int walkPoses = 90;
    double walkSeconds = 20;
};

/// WIDTHxHEIGHT with the field of view of a hand-held depth camera across; false if it is not written like
/// that.
bool cameraOf(const std::string& size, scene::Camera& camera) {
    int width = 0, height = 0, used = 0;
    if (std::sscanf(size.c_str(), "%dx%d%n", &width, &height, &used) != 2 ||
        static_cast<std::size_t>(used) != size.size())
        return false;
    if (width < 1 || height < 1 || width > 16384 || height > 16384) return false;
    const scene::Camera usual = scene::captureCamera();
    const double focal = usual.fx * width / usual.width;
    camera = {width, height, focal, focal, width / 2.0, height / 2.0};
    return true;
}

/// The same pose for axes x right, y up, z backwards.
scene::Pose withUprightAxes(const scene::Pose& worldFromCamera) {
    scene::Pose pose = worldFromCamera;
    pose.rotation[1] = -pose.rotation[1];
    pose.rotation[2] = -pose.rotation[2];
    return pose;
}

void writePicture(const fs::path& path, const cv::Mat& picture) {
    bool isWritten = false;
    try {
        isWritten = cv::imwrite(path.string(), picture);
    } catch (const cv::Exception&) {
        isWritten = false;
    }
    if (!isWritten)
        throw scene::Failure("cannot write the picture", path, "check that the folder is writable and not full");
}

void writeJson(const fs::path& path, const Json& json) {
    std::ofstream file(path);
    file << json.dump(1) << '\n';
    file.close();
    if (!file) throw scene::Failure("cannot write the file", path, "check that the folder is writable and not full");
}

cv::Mat colourOf(const scene::DepthImage& image) {
    cv::Mat picture(image.camera.height, image.camera.width, CV_8UC3);
    for (int y = 0; y < image.camera.height; ++y)
        for (int x = 0; x < image.camera.width; ++x) {
            const scene::Rgb8 c = image.colour(x, y);
            picture.at<cv::Vec3b>(y, x) = cv::Vec3b(c.b, c.g, c.r);
        }
    return picture;
}

cv::Mat depthOf(const scene::DepthImage& image, const SampleOptions& options, int index) {
    cv::Mat picture(image.camera.height, image.camera.width, CV_16UC1, cv::Scalar(0));
    scene::SeededSequence noise(scene::mixBits(options.seed, static_cast<std::uint64_t>(index) + 1));
    for (int y = 0; y < image.camera.height; ++y)
        for (int x = 0; x < image.camera.width; ++x) {
            if (!scene::isSurface(image.flags(x, y))) continue;
            double depth = 1.0 / static_cast<double>(image.disparity(x, y));
            if (options.noiseMillimetres > 0) depth += options.noiseMillimetres * 0.001 * noise.normal();
            const double steps = std::round(depth / options.depthUnitMetres);
            if (steps >= 1.0 && steps <= 65535.0) picture.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(steps);
        }
    return picture;
}

Json frameOf(const scene::DepthImage& image, const std::string& colourPath, const std::string& depthPath) {
    const scene::Pose worldFromCamera = withUprightAxes(image.worldFromCamera);
    const glm::dmat4 matrix = scene::toMatrix(worldFromCamera);
    Json rows = Json::array();
    for (int row = 0; row < 4; ++row)
        rows.push_back({matrix[0][row], matrix[1][row], matrix[2][row], matrix[3][row]});
    return {{"file_path", colourPath}, {"depth_file_path", depthPath}, {"transform_matrix", rows}};
}

void writeCapture(const scene::SyntheticScene& synthetic, const scene::Camera& camera, const SampleOptions& options) {
    Json transforms{{"camera_model", "OPENCV"},
                    {"w", camera.width},
                    {"h", camera.height},
                    {"fl_x", camera.fx},
                    {"fl_y", camera.fy},
                    {"cx", camera.cx},
                    {"cy", camera.cy},
                    {"k1", 0},
                    {"k2", 0},
                    {"p1", 0},
                    {"p2", 0},
                    {"depth_unit_scale_factor", options.depthUnitMetres},
                    {"frames", Json::array()}};
    const std::vector<scene::View> views = scene::captureViews(synthetic, options.images, camera);
    for (int i = 0; i < options.images; ++i) {
        const scene::DepthImage image =
            scene::renderTruth(synthetic, views[static_cast<std::size_t>(i)], options.samplesPerPixel);
        std::array<char, 32> name{};
        std::snprintf(name.data(), name.size(), "%05d", i);
        const std::string colourPath = "images/" + std::string(name.data()) + "." + options.format;
        const std::string depthPath = "depth/" + std::string(name.data()) + ".png";
        writePicture(options.out / colourPath, colourOf(image));
        writePicture(options.out / depthPath, depthOf(image, options, i));
        transforms["frames"].push_back(frameOf(image, colourPath, depthPath));
    }
    writeJson(options.out / "transforms.json", transforms);
}

/// writtenFromTrue: the scene in the world of what was written.
void writeWalk(const scene::SyntheticScene& synthetic, const SampleOptions& options,
               const scene::Pose& writtenFromTrue = {}) {
    Json poses = Json::array();
    const std::vector<scene::View> views = scene::walkPath(synthetic, options.walkPoses);
    for (std::size_t i = 0; i < views.size(); ++i) {
        const scene::Pose worldFromHead = withUprightAxes(writtenFromTrue * views[i].worldFromEye);
        const glm::dvec3 p = worldFromHead.translation;
        const glm::dvec4 q = scene::quaternionOf(worldFromHead);
        poses.push_back({{"t", options.walkSeconds * static_cast<double>(i) / static_cast<double>(views.size())},
                         {"position", {p.x, p.y, p.z}},
                         {"orientation", {q.x, q.y, q.z, q.w}}});
    }
    writeJson(options.out / "walk.json", {{"space", "world"}, {"poses", poses}});
}

void makeFolder(const fs::path& path) {
    std::error_code error;
    fs::create_directories(path, error);
    if (error)
        throw scene::Failure("cannot make the folder (" + error.message() + ")", path,
                             "choose a place that is writable");
}

/// "DEG,M"; false if it is not written like that.
bool parsePoseError(const std::string& text, SampleScansOptions& scans) {
    int used = 0;
    return std::sscanf(text.c_str(), "%lf,%lf%n", &scans.poseErrorDegrees, &scans.poseErrorMetres, &used) == 2 &&
           static_cast<std::size_t>(used) == text.size() && scans.poseErrorDegrees >= 0 &&
           scans.poseErrorDegrees <= 180 && scans.poseErrorMetres >= 0 && scans.poseErrorMetres <= 1e6;
}

/// "WIDTHxHEIGHT"; false if it is not written like that.
bool parsePhotographSize(const std::string& text, SampleScansOptions& scans) {
    scene::Camera camera;
    if (!cameraOf(text, camera)) return false;
    scans.photographWidth = camera.width, scans.photographHeight = camera.height;
    return true;
}

void addPhotographs(CLI::App& cli, SampleScansOptions& scans, const std::string& group) {
    cli.add_option("--photographs", scans.photographs,
                   "of each scan, by a camera in the scanner's place, around the horizon; and camera.json")
        ->check(CLI::Range(0, 1000))
        ->capture_default_str()
        ->group(group);
    cli.add_option("--photograph-rings", scans.photographRings, "so many in each: also above the horizon, and below")
        ->check(CLI::Range(1, 3))
        ->capture_default_str()
        ->group(group);
    cli.add_option_function<std::string>(
           "--photograph-size",
           [&scans](const std::string& text) {
               if (!parsePhotographSize(text, scans))
                   throw CLI::ValidationError("--photograph-size", "not WIDTHxHEIGHT: " + text);
           },
           "in pixels, 65 degrees across")
        ->type_name("WxH")
        ->default_str("960x720")
        ->group(group);
    cli.add_option("--photograph-error", scans.photographErrorDegrees,
                   "degrees by which their poses are written wrong, each about an axis of its own")
        ->check(realRange(0.0, 180.0))
        ->capture_default_str()
        ->group(group);
    cli.add_option("--exposure-drift", scans.exposureStops,
                   "stops by which their exposures drift to either side; white balance drifts along")
        ->check(realRange(0.0, 8.0))
        ->capture_default_str()
        ->group(group);
}

void addScanner(CLI::App& cli, bool& isScanner, SampleScansOptions& scans) {
    const std::string group = "Laser scans";
    CLI::Option* const scanner = cli.add_flag("--scanner", isScanner,
                                              "laser scans by a simulated scanner instead of images: scans.e57, "
                                              "truth.json")
                                     ->group(group);
    cli.add_option("--polygons", scans.polygons, "scan this polygon scene, in soft light")
        ->check(CLI::ExistingFile)
        ->group(group);
    cli.add_option("--scans", scans.scans, "how many")->check(CLI::Range(1, 1000))->capture_default_str()->group(group);
    cli.add_option("--density", scans.samplesPerDegree,
                   "samples a degree, both ways; the paper's scanner took 20 to 25")
        ->check(realRange(0.5, 50.0))
        ->capture_default_str()
        ->group(group);
    cli.add_option_function<double>(
           "--range-noise-mm", [&scans](double millimetres) { scans.noiseMetres = millimetres / 1000; },
           "standard deviation of range at 3 m from a half bright surface, in millimetres")
        ->check(realRange(0.0, 1000.0))
        ->default_str("5")
        ->group(group);
    cli.add_option("--farthest", scans.farthestMetres, "metres beyond which nothing comes back")
        ->check(realRange(0.5, 1000.0))
        ->capture_default_str()
        ->group(group);
    cli.add_flag("--both-faces", scans.areBothFaces,
                 "the pan unit goes all round, so that each half of the mirror's turn sees everything: what "
                 "'revisit calibrate scanner' needs")
        ->group(group);
    cli.add_flag("--wrong-constants", scans.hasWrongConstants,
                 "records of a scanner with 14,039 pan steps and a mirror of 44.8 degrees, read as if it had 14,000 "
                 "and 45")
        ->group(group);
    cli.add_flag("--poses-unknown", scans.arePosesUnknown, "every scan is written as if it stood at the origin")
        ->group(group);
    cli.add_option_function<std::string>(
           "--pose-error",
           [&scans](const std::string& text) {
               if (!parsePoseError(text, scans))
                   throw CLI::ValidationError("--pose-error", "not DEGREES,METRES: " + text);
           },
           "poses are written wrong by this much, each in a direction of its own")
        ->type_name("DEG,M")
        ->group(group);
    cli.add_flag_callback(
           "--no-colour", [&scans] { scans.withColour = false; }, "intensity alone")
        ->group(group);
    cli.add_option("--scan-format", scans.format, "e57 or ptx")
        ->check(CLI::IsMember({"e57", "ptx"}))
        ->capture_default_str()
        ->group(group);
    addPhotographs(cli, scans, group);
    for (CLI::Option* const option : cli.get_options())
        if (option->get_group() == group && option != scanner) option->needs(scanner);
}

void makeScans(const SampleOptions& options, const SampleScansOptions& scans) {
    makeFolder(options.out);
    const scene::Pose writtenFromTrue = makeSampleScans(options.out, options.sceneName, options.seed, scans);
    if (scans.polygons.empty())
        writeWalk(*scene::makeSyntheticScene(options.sceneName, options.seed), options, writtenFromTrue);
}

void makeSample(const SampleOptions& options, const scene::Camera& camera) {
    for (const char* folder : {"images", "depth"})
        makeFolder(options.out / folder);
    const auto synthetic = scene::makeSyntheticScene(options.sceneName, options.seed);
    writeCapture(*synthetic, camera, options);
    writeWalk(*synthetic, options);
    std::cout << options.images << " images of the " << options.sceneName << " and a walk of " << options.walkPoses
              << " poses in " << options.out.string() << '\n';
}

} // namespace

} // namespace app

int main(int argc, char** argv) {
    app::SampleOptions options;
    app::SampleScansOptions scans;
    bool isScanner = false;
    scene::Camera camera;
    CLI::App cli{"Writes a sample RGB-D capture of a synthetic scene whose truth is known: transforms.json, "
                 "images/, depth/ as\n"
                 "nerfstudio has them, and walk.json, a path through the scene.\n\n"
                 "  make_sample samples/room --scene room --images 60\n"
                 "  make_sample samples/corner --scene corner --images 120 --size 1280x960 --noise-mm 4\n"
                 "  make_sample samples/scans --scene room --scanner --poses-unknown"};
    cli.add_option("OUT", options.out, "folder to write; made if it is not there")->required();
    cli.add_option("--scene", options.sceneName,
                   "room: a furnished living room; corner: a street corner where two cars collided; "
                   "corridor: 26 m of repeating doors and pillars")
        ->check(CLI::IsMember({"room", "corner", "corridor"}))
        ->capture_default_str();
    cli.add_option("--images", options.images, "how many")->check(CLI::Range(1, 100000))->capture_default_str();
    cli.add_option("--size", options.size, "of the images in pixels, 63 degrees across")
        ->check([&camera](const std::string& size) {
            return app::cameraOf(size, camera) ? std::string() : "not WIDTHxHEIGHT with each from 1 to 16384: " + size;
        })
        ->type_name("WxH")
        ->capture_default_str();
    cli.add_option("--samples", options.samplesPerPixel, "rays for the colour of a pixel")
        ->check(CLI::Range(1, 256))
        ->capture_default_str();
    cli.add_option("--noise-mm", options.noiseMillimetres, "standard deviation of depth noise in millimetres")
        ->check(app::realRange(0.0, 1000.0))
        ->capture_default_str();
    cli.add_option("--depth-unit", options.depthUnitMetres,
                   "metres in one step of the 16 bit depth; 65535 steps are the farthest")
        ->check(app::realRange(1e-6, 1.0))
        ->capture_default_str();
    cli.add_option("--seed", options.seed, "another seed: other books, leaves, clouds, noise")->capture_default_str();
    cli.add_option("--format", options.format, "of the colour images")
        ->check(CLI::IsMember({"png", "jpg"}))
        ->capture_default_str();
    app::addScanner(cli, isScanner, scans);
    try {
        cli.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        const bool isHelp = error.get_exit_code() == 0;
        cli.exit(error);
        return isHelp ? 0 : 2;
    }
    try {
        app::cameraOf(options.size, camera);
        if (isScanner)
            app::makeScans(options, scans);
        else
            app::makeSample(options, camera);
        return 0;
    } catch (const std::exception& failure) {
        std::fprintf(stderr, "%s\n", scene::onOneLine(failure.what()).c_str());
        return 1;
    }
}
