#include "app/calibrate.h"

#include "app/build_stages.h"
#include "app/output_file.h"
#include "app/say.h"
#include "app/stage_store.h"

#include "scene/align/scanner_calibration.h"
#include "scene/align/scanner_file.h"
#include "scene/errors.h"
#include "scene/import/importer.h"

#include <algorithm>
#include <cstdio>
#include <numbers>

#include <nlohmann/json.hpp>

namespace app {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Folders stand for the pictures in them, in the order of their names.
std::vector<fs::path> picturesOf(const std::vector<fs::path>& inputs) {
    constexpr const char* kPictures[] = {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".ppm", ".pgm"};
    std::vector<fs::path> pictures;
    for (const fs::path& input : inputs) {
        if (!fs::exists(input))
            throw scene::Failure("is not there", input, "name pictures of the board, or a folder of them");
        if (!fs::is_directory(input)) {
            pictures.push_back(input);
            continue;
        }
        std::vector<fs::path> inside;
        for (const fs::directory_entry& entry : fs::directory_iterator(input)) {
            std::string extension = entry.path().extension().string();
            std::transform(extension.begin(), extension.end(), extension.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
            if (std::find(std::begin(kPictures), std::end(kPictures), extension) != std::end(kPictures))
                inside.push_back(entry.path());
        }
        std::sort(inside.begin(), inside.end());
        pictures.insert(pictures.end(), inside.begin(), inside.end());
    }
    return pictures;
}

Json describe(const scene::BoardPicture& picture) {
    if (!picture.isFound) return {{"file", picture.path.filename().string()}, {"why", picture.why}};
    return {{"file", picture.path.filename().string()},
            {"mean_px", picture.meanPixels},
            {"worst_px", picture.worstPixels},
            {"mean_mm", 1e3 * picture.meanMetres}};
}

/// Where a summary goes: not among JSON that is written to a pipe.
std::FILE* summaryOf(const CalibrateOptions& options) {
    std::error_code ignored;
    return std::filesystem::is_other(options.output, ignored) ? stderr : stdout;
}

} // namespace

void calibrateCamera(const CalibrateOptions& options) {
    checkReplaceableFile(options.output, options.inputs, [](const Json& of) {
        return of.is_object() && of.contains("fx") && of.contains("focal_deviation_px");
    });
    const scene::CameraCalibration found = scene::calibrateCamera(picturesOf(options.inputs), options.board);
    Json pictures = Json::array();
    for (const scene::BoardPicture& picture : found.pictures) {
        pictures.push_back(describe(picture));
        if (!picture.isFound) sayNote(picture.path.string() + " " + picture.why + "; left out");
    }
    const scene::Camera& c = found.camera;
    const scene::Distortion& d = found.distortion;
    writeWhole(options.output, Json{{"width", c.width},
                                    {"height", c.height},
                                    {"fx", c.fx},
                                    {"fy", c.fy},
                                    {"cx", c.cx},
                                    {"cy", c.cy},
                                    {"k1", d.k1},
                                    {"k2", d.k2},
                                    {"p1", d.p1},
                                    {"p2", d.p2},
                                    {"k3", d.k3},
                                    {"focal_deviation_px", found.focalDeviation},
                                    {"centre_deviation_px", found.centreDeviation},
                                    {"rms_px", found.rmsPixels},
                                    {"mean_px", found.meanPixels},
                                    {"worst_px", found.worstPixels},
                                    {"mean_mm", 1e3 * found.meanMetres},
                                    {"worst_mm", 1e3 * found.worstMetres},
                                    {"pictures", pictures}}
                                       .dump(1) +
                                   "\n");
    const auto boards = std::count_if(found.pictures.begin(), found.pictures.end(),
                                      [](const scene::BoardPicture& picture) { return picture.isFound; });
    std::fprintf(summaryOf(options),
                 "focal length %.2f, %.2f px (known to %.2f), centre %.2f, %.2f px, from %td boards in %zu pictures\n"
                 "errors: rms %.3f px, mean %.3f px, worst %.2f px; on the boards mean %.3f mm, worst %.2f mm\n"
                 "written: %s\n",
                 c.fx, c.fy, found.focalDeviation, c.cx, c.cy, boards, found.pictures.size(), found.rmsPixels,
                 found.meanPixels, found.worstPixels, 1e3 * found.meanMetres, 1e3 * found.worstMetres,
                 options.output.string().c_str());
}

void calibrateScanner(const CalibrateOptions& options) {
    checkReplaceableFile(options.output, options.inputs, [](const Json& of) {
        return of.is_object() && of.contains("believed") && of.contains("constants");
    });
    const scene::Capture capture = scene::openCapture(options.inputs);
    if (capture.scans.empty())
        throw scene::Failure("holds no laser scan", options.inputs.front(),
                             "name .e57 or .ptx scans that took all walls with both halves of the mirror's turn");
    const scene::ScannerCalibration found = scene::calibrateScanner(
        capture.scans.size(), [&](std::size_t i) { return readScan(capture.scans[i]); }, options.believed);
    if (!found.why.empty())
        throw scene::Failure(found.why, options.inputs.front(),
                             "let the pan unit go all round, so that each half of the mirror's turn sees everything");
    writeWhole(options.output, Json{{"believed", scene::describeConstants(options.believed)},
                                    {"constants", scene::describeConstants(found.constants)},
                                    {"deviations", scene::describeConstants(found.deviations)},
                                    {"planes", found.planes},
                                    {"samples", found.samples},
                                    {"rms_before_m", found.rmsBeforeMetres},
                                    {"rms_after_m", found.rmsAfterMetres}}
                                       .dump(1) +
                                   "\n");
    const scene::ScannerConstants<double>&c = found.constants, &d = found.deviations;
    std::fprintf(
        summaryOf(options),
        "pan %.2f steps in half a turn (known to %.2f), mirror %.4f deg (%.4f), horizon at %.3f of the encoder "
        "(%.3f), mirror at %.2f mm (%.2f)\n"
        "from %td samples of %d planes: %.2f mm from them instead of %.2f mm\nwritten: %s\n",
        c.panStepsPerHalfTurn, d.panStepsPerHalfTurn, c.mirrorRadians * kDegrees, d.mirrorRadians * kDegrees,
        c.horizonPosition, d.horizonPosition, 1e3 * c.mirrorMetres, 1e3 * d.mirrorMetres,
        static_cast<std::ptrdiff_t>(found.samples), found.planes, 1e3 * found.rmsAfterMetres,
        1e3 * found.rmsBeforeMetres, options.output.string().c_str());
}

} // namespace app
