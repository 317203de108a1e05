#include "scene/import/camera_file.h"

#include "scene/errors.h"
#include "scene/json_file.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

#include <glm/geometric.hpp>

namespace scene {

namespace {

using nlohmann::json;

constexpr double kMostPixels = 1 << 20;

double numberAt(const json& file, const char* key, const std::filesystem::path& path, bool isNeeded) {
    const auto found = file.find(key);
    if (found == file.end() && !isNeeded) return 0;
    if (found == file.end() || !found->is_number() || !std::isfinite(found->get<double>()))
        throw Failure(std::string("is no camera: \"") + key + "\" is " +
                          (found == file.end() ? "missing" : "no finite number"),
                      path, "write width, height, fx, fy, cx and cy in pixels, and the lens's k1, k2, p1, p2, k3");
    return found->get<double>();
}

int sizeOf(const json& file, const char* key, const std::filesystem::path& path) {
    const double size = numberAt(file, key, path, true);
    if (!(size >= 1 && size <= kMostPixels) || size != std::floor(size))
        throw Failure(std::string("is no camera: \"") + key + "\" is no number of pixels", path,
                      "write the size of its pictures");
    return static_cast<int>(size);
}

/// How much the lens stretches the picture there, as an area; not positive where it folds over.
double stretchAt(const Distortion& lens, const glm::dvec2& ideal) {
    constexpr double kStep = 1e-5;
    const glm::dvec2 x = distorted(lens, ideal + glm::dvec2(kStep, 0)) - distorted(lens, ideal - glm::dvec2(kStep, 0));
    const glm::dvec2 y = distorted(lens, ideal + glm::dvec2(0, kStep)) - distorted(lens, ideal - glm::dvec2(0, kStep));
    return (x.x * y.y - x.y * y.x) / (4 * kStep * kStep);
}

} // namespace

CameraFile readCameraFile(const std::filesystem::path& path) {
    const json file = readJsonFile(path);
    if (!file.is_object()) throw Failure("is no camera", path, "write an object with width, height, fx, fy, cx and cy");
    const auto need = [&](const char* key) { return numberAt(file, key, path, true); };
    const auto find = [&](const char* key) { return numberAt(file, key, path, false); };
    CameraFile result;
    result.camera = {
        sizeOf(file, "width", path), sizeOf(file, "height", path), need("fx"), need("fy"), need("cx"), need("cy")};
    result.distortion = {find("k1"), find("k2"), find("p1"), find("p2"), find("k3")};
    if (!isUsable(result.camera)) throw Failure("is no camera: a focal length is not positive", path, "correct it");
    if (std::isfinite(oneToOneWithin(result.camera, result.distortion)))
        throw Failure("has a lens that folds the picture over itself", path, "check the signs of k1, k2 and k3");
    return result;
}

void writeCameraFile(const std::filesystem::path& path, const CameraFile& camera) {
    const Camera& c = camera.camera;
    const Distortion& d = camera.distortion;
    std::ofstream file(path);
    file << nlohmann::ordered_json{{"width", c.width}, {"height", c.height}, {"fx", c.fx}, {"fy", c.fy},
                                   {"cx", c.cx},       {"cy", c.cy},         {"k1", d.k1}, {"k2", d.k2},
                                   {"p1", d.p1},       {"p2", d.p2},         {"k3", d.k3}}
                .dump(1)
         << '\n';
    file.close();
    if (!file) throw Failure("cannot write the file", path, "check that the folder is writable and not full");
}

glm::dvec2 distorted(const Distortion& lens, const glm::dvec2& ideal) {
    const double x = ideal.x, y = ideal.y, r2 = x * x + y * y;
    const double radial = 1 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3));
    return {x * radial + 2 * lens.p1 * x * y + lens.p2 * (r2 + 2 * x * x),
            y * radial + lens.p1 * (r2 + 2 * y * y) + 2 * lens.p2 * x * y};
}

double oneToOneWithin(const Camera& camera, const Distortion& lens) {
    double within = std::numeric_limits<double>::infinity();
    if (lens == Distortion{}) return within; // however far out its corners are
    constexpr int kSteps = 32;
    for (const double x : {0.0, 1.0 * camera.width})
        for (const double y : {0.0, 1.0 * camera.height})
            for (int i = 0; i <= kSteps; ++i) {
                const glm::dvec2 place = glm::dvec2(rayThrough(camera, x, y)) * (static_cast<double>(i) / kSteps);
                if (stretchAt(lens, place) > 0) continue;
                within = std::min(within, glm::length(place));
                break;
            }
    return within;
}

glm::dvec2 undistorted(const Distortion& lens, const glm::dvec2& seen) {
    constexpr int kMostSteps = 50;
    constexpr double kStep = 1e-6;
    glm::dvec2 ideal = seen;
    for (int i = 0; i < kMostSteps; ++i) {
        const glm::dvec2 off = distorted(lens, ideal) - seen;
        if (glm::dot(off, off) < 1e-28) break;
        const glm::dvec2 dx = (distorted(lens, ideal + glm::dvec2(kStep, 0)) - seen - off) / kStep;
        const glm::dvec2 dy = (distorted(lens, ideal + glm::dvec2(0, kStep)) - seen - off) / kStep;
        const double determinant = dx.x * dy.y - dx.y * dy.x;
        if (!(std::abs(determinant) > 1e-12)) break;
        ideal -= glm::dvec2(off.x * dy.y - off.y * dy.x, dx.x * off.y - dx.y * off.x) / determinant;
    }
    return ideal;
}

} // namespace scene
