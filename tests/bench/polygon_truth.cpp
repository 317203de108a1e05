// The truth that a scene built of polygons is measured against: pictures ray-traced at places where one can stand, as
// `revisit measure --cameras` takes them.
//
//   revisit_polygon_truth OUT SCENE.obj COUNT

#include "scene/camera_json.h"
#include "scene/capture/polygon_view.h"
#include "scene/capture/spread_positions.h"
#include "scene/errors.h"
#include "scene/import/polygons.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

namespace {

using nlohmann::json;

/// Level but for a little, at a place between those of a search's grid.
scene::View viewAt(const scene::PolygonTracer& tracer, const std::vector<glm::dvec3>& places, std::mt19937& generator) {
    std::uniform_int_distribution<std::size_t> any(0, places.size() - 1);
    std::normal_distribution<double> aside(0, 0.2);
    std::uniform_real_distribution<double> turn(0, 6.283185307179586), tilt(-0.3, 0.3);
    for (;;) {
        const glm::dvec3& from = places[any(generator)];
        const glm::dvec3 way(aside(generator), 0.3 * aside(generator), aside(generator));
        const double yaw = turn(generator), pitch = tilt(generator);
        if (tracer.isBlocked(from, way, 1.5)) continue;
        const glm::dvec3 ahead(std::cos(pitch) * std::sin(yaw), std::sin(pitch), -std::cos(pitch) * std::cos(yaw));
        const glm::dvec3 right = glm::normalize(glm::cross(ahead, glm::dvec3(0, 1, 0)));
        return {{320, 240, 160, 160, 160, 120}, {glm::dmat3(right, glm::cross(ahead, right), ahead), from + way}};
    }
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 4 || std::atoi(argv[3]) < 1) {
        std::fprintf(stderr, "usage: revisit_polygon_truth OUT SCENE.obj COUNT\n");
        return 2;
    }
    try {
        const std::filesystem::path out = argv[1];
        std::filesystem::create_directories(out);
        const scene::PolygonScene polygons = scene::readPolygons(argv[2]);
        const scene::PolygonTracer tracer(polygons);
        const std::vector<glm::dvec3> places = scene::standingPlaces(tracer);
        const scene::SurfaceLight light(tracer, {});
        std::mt19937 generator(2001);
        json cameras = json::array();
        for (int i = 0; i < std::atoi(argv[3]); ++i) {
            const scene::View view = viewAt(tracer, places, generator);
            const scene::Camera& c = view.camera;
            const scene::DepthImage truth = scene::renderPolygons(tracer, light, view);
            cv::Mat3b colour(c.height, c.width);
            cv::Mat1f depth(c.height, c.width, 0.0f);
            for (int y = 0; y < c.height; ++y)
                for (int x = 0; x < c.width; ++x) {
                    const scene::Rgb8 p = truth.colour(x, y);
                    colour(y, x) = {p.b, p.g, p.r};
                    if (scene::isSurface(truth.flags(x, y))) depth(y, x) = 1 / truth.disparity(x, y);
                }
            char name[32];
            std::snprintf(name, sizeof name, "t%04d", i);
            cv::imwrite((out / (std::string(name) + ".png")).string(), colour);
            cv::imwrite((out / (std::string(name) + "-depth.tiff")).string(), depth);
            cameras.push_back(scene::describeCamera(name, view.camera, view.worldFromEye));
        }
        std::ofstream(out / "cameras.json") << json{{"cameras", cameras}}.dump(1) << "\n";
    } catch (const scene::Failure& failure) {
        std::fprintf(stderr, "revisit_polygon_truth: %s\n", failure.what());
        return 1;
    }
}
