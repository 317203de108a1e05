// Where reference positions stand, and what is then unknown: positions that were searched for, by climbing and by the
// article's genetic search, against uniform grids, spread ones, and random ones. Curves as JSON and as a picture.
//
//   revisit_position_study OUT SCENE.obj...

#include "scene/capture/depth_view.h"
#include "scene/capture/spread_positions.h"
#include "scene/errors.h"
#include "scene/plan/position_search.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <random>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace {

using nlohmann::json;

constexpr int kSmallFace = 48, kTestPlaces = 200, kMost = 32, kSeeds = 5;
constexpr std::array kCounts{8, 16, 32};

/// Fixed by the seed, between the places of the search's grid and not on them.
std::vector<glm::dvec3> testPlaces(const scene::PolygonTracer& tracer, const std::vector<glm::dvec3>& places) {
    std::mt19937 generator(2001);
    std::uniform_int_distribution<std::size_t> any(0, places.size() - 1);
    std::normal_distribution<double> aside(0, 0.2);
    std::vector<glm::dvec3> tests;
    while (tests.size() < kTestPlaces) {
        const glm::dvec3& from = places[any(generator)];
        const glm::dvec3 way(aside(generator), 0.3 * aside(generator), aside(generator));
        if (!tracer.isBlocked(from, way, 1.5)) tests.push_back(from + way);
    }
    return tests;
}

/// Of the grids whose width and depth are whole numbers of squares, the one that has the wanted number of places, or
/// the next that has more, of which the last are left out: a gift to the grid.
std::vector<glm::dvec3> gridOf(const std::vector<glm::dvec3>& places, std::size_t count) {
    glm::dvec3 low = places[0], high = places[0];
    for (const glm::dvec3& p : places)
        low = glm::min(low, p), high = glm::max(high, p);
    for (double step = std::max(high.x - low.x, high.z - low.z);; step *= 0.97) {
        std::vector<glm::dvec3> grid;
        for (double x = low.x + step / 2; x < high.x; x += step)
            for (double z = low.z + step / 2; z < high.z; z += step) {
                const auto nearest = std::min_element(places.begin(), places.end(), [&](const auto& a, const auto& b) {
                    return std::hypot(a.x - x, a.z - z) < std::hypot(b.x - x, b.z - z);
                });
                if (std::hypot(nearest->x - x, nearest->z - z) < step / 4 &&
                    std::find(grid.begin(), grid.end(), *nearest) == grid.end())
                    grid.push_back(*nearest);
            }
        if (grid.size() < count) continue;
        grid.resize(count);
        return grid;
    }
}

json study(const std::filesystem::path& file) {
    const scene::PolygonScene polygons = scene::readPolygons(file);
    const scene::PolygonTracer tracer(polygons);
    const std::vector<glm::dvec3> places = scene::standingPlaces(tracer), tests = testPlaces(tracer, places);
    const scene::CaptureSmall capture = [&](const glm::dvec3& position) {
        return scene::traceDepthCube(tracer, position, kSmallFace);
    };
    std::printf("%s: %zu places\n", file.c_str(), places.size());
    json result{{"scene", file.stem().string()}, {"places", places.size()}, {"test_places", tests.size()}};

    for (const auto& [name, kind] :
         {std::pair("climbing", scene::CellSearch::climbing), std::pair("remembering", scene::CellSearch::remembering),
          std::pair("genetic", scene::CellSearch::genetic)}) {
        scene::PositionSearchOptions options;
        options.count = kMost;
        options.search = kind;
        const auto start = std::chrono::steady_clock::now();
        json curve = json::array(), looks = json::array();
        for (const auto& step : scene::searchPositions(places, tests, capture, options)) {
            curve.push_back(step.unknownShare);
            looks.push_back(step.evaluations);
        }
        const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
        result[name] = {{"unknown_share", curve}, {"looks", looks}, {"seconds", passed.count()}};
        std::printf("%s: %s, %.0f s\n", name, curve.dump().c_str(), passed.count());
    }
    for (const int count : kCounts) {
        const auto n = static_cast<std::size_t>(count);
        const auto tell = [&](const char* name, const std::vector<glm::dvec3>& positions) {
            const double share = scene::unknownShareOf(positions, tests, capture);
            result[name][std::to_string(count)].push_back(share);
            std::printf("%s %d: %.5f\n", name, count, share);
        };
        tell("grid", gridOf(places, n));
        tell("spread", scene::spreadPositions(tracer, count));
        for (unsigned seed = 1; seed <= kSeeds; ++seed) {
            std::vector<glm::dvec3> positions = places;
            std::shuffle(positions.begin(), positions.end(), std::mt19937(seed));
            positions.resize(n);
            tell("random", positions);
        }
    }
    return result;
}

/// Unknown share over the number of positions, both by logarithm.
cv::Mat3b draw(const json& result) {
    constexpr int kWidth = 900, kHeight = 600, kRim = 70;
    cv::Mat3b picture(kHeight, kWidth, cv::Vec3b(255, 255, 255));
    constexpr double kLeast = 1e-4;
    const auto at = [&](double count, double share) {
        const double x = std::log2(count) / 5, y = std::log10(std::max(share, kLeast)) / std::log10(kLeast);
        return cv::Point(kRim + static_cast<int>(x * (kWidth - 2 * kRim)),
                         kRim + static_cast<int>(y * (kHeight - 2 * kRim)));
    };
    const cv::Scalar grey(200, 200, 200), black(0, 0, 0);
    const auto write = [&](const std::string& text, cv::Point where, const cv::Scalar& colour) {
        cv::putText(picture, text, where, cv::FONT_HERSHEY_SIMPLEX, 0.45, colour, 1, cv::LINE_AA);
    };
    for (const int count : {1, 2, 4, 8, 16, 32}) {
        cv::line(picture, at(count, 1), at(count, kLeast), grey);
        write(std::to_string(count), at(count, kLeast) + cv::Point(-5, 20), black);
    }
    for (const double share : {1.0, 0.1, 0.01, 0.001, 1e-4}) {
        cv::line(picture, at(1, share), at(32, share), grey);
        write(json(100 * share).dump() + " %", at(1, share) + cv::Point(-65, 5), black);
    }
    write(result["scene"].get<std::string>() + ": unknown share over the number of positions", {kRim, 30}, black);
    int row = 0;
    const auto label = [&](const std::string& name, const cv::Scalar& colour) {
        write(name, {kWidth - 200, kRim + 20 + 20 * row++}, colour);
    };
    for (const auto& [name, colour] :
         {std::pair("climbing", cv::Scalar(40, 160, 220)), std::pair("remembering", cv::Scalar(40, 40, 200)),
          std::pair("genetic", cv::Scalar(200, 80, 40))}) {
        const json& curve = result[name]["unknown_share"];
        for (std::size_t i = 1; i < curve.size(); ++i)
            cv::line(picture, at(static_cast<double>(i), curve[i - 1]), at(static_cast<double>(i + 1), curve[i]),
                     colour, 2, cv::LINE_AA);
        label(name, colour);
    }
    for (const auto& [name, colour] :
         {std::pair("grid", cv::Scalar(0, 130, 0)), std::pair("spread", cv::Scalar(150, 0, 150)),
          std::pair("random", cv::Scalar(120, 120, 120))}) {
        for (const auto& [count, shares] : result[name].items())
            for (const double share : shares)
                cv::circle(picture, at(std::stod(count), share), 5, colour, 2, cv::LINE_AA);
        label(name, colour);
    }
    return picture;
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 3) {
        std::fprintf(stderr, "usage: revisit_position_study OUT SCENE.obj...\n");
        return 2;
    }
    try {
        const std::filesystem::path out = argv[1];
        std::filesystem::create_directories(out);
        for (int i = 2; i < argc; ++i) {
            const json result = study(argv[i]);
            const std::string name = result["scene"];
            std::ofstream(out / (name + ".json")) << result.dump(1) << "\n";
            cv::imwrite((out / (name + ".png")).string(), draw(result));
        }
    } catch (const scene::Failure& failure) {
        std::fprintf(stderr, "revisit_position_study: %s\n", failure.what());
        return 1;
    }
}
