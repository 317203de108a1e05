// Where reference positions stand, what is then unknown, and how what is drawn compares with ray-traced truth:
// positions that were searched for by sight and by the article's genetic search, against uniform grids, spread ones,
// and random ones. JSON and pictures.
//
//   revisit_position_study OUT SCENE.obj...

#include "tests/bench/position_pictures.h"

#include "scene/capture/depth_view.h"
#include "scene/capture/spread_positions.h"
#include "scene/errors.h"
#include "scene/import/polygons.h"
#include "scene/plan/position_search.h"
#include "scene/plan/sight_search.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <random>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace {

using nlohmann::json;

constexpr int kSmallFace = 48, kTestPlaces = 200, kSeeds = 5;
constexpr std::array kCounts{4, 8, 16, 32};
constexpr int kMostGenetic = 16; ///< it takes too long for more

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

/// The corners of the grid's cell about a place: the nearest position in each quarter. All stand at eye height, so that
/// the article's cuboids of 8 corners are rectangles of 4; at the rim there are fewer.
std::vector<std::uint32_t> gridCornersAt(const std::vector<glm::dvec3>& grid, const glm::dvec3& place) {
    std::vector<std::uint32_t> corners;
    for (const auto& [x, z] : {std::pair(-1, -1), std::pair(-1, 1), std::pair(1, -1), std::pair(1, 1)}) {
        std::optional<std::uint32_t> nearest;
        for (std::uint32_t i = 0; i < grid.size(); ++i) {
            const glm::dvec3 way = grid[i] - place;
            if (way.x * x < 0 || way.z * z < 0) continue;
            if (!nearest || glm::length(way) < glm::length(grid[*nearest] - place)) nearest = i;
        }
        if (nearest && std::find(corners.begin(), corners.end(), *nearest) == corners.end())
            corners.push_back(*nearest);
    }
    return corners;
}

/// Everything that is asked of positions, by their number.
class Study {
  public:
    explicit Study(const std::filesystem::path& file)
        : polygons_(scene::readPolygons(file)), tracer_(polygons_), places_(scene::standingPlaces(tracer_)),
          tests_(testPlaces(tracer_, places_)), pictures_(tracer_, tests_) {
        result_ = {{"scene", file.stem().string()}, {"places", places_.size()}, {"test_places", tests_.size()}};
        std::printf("%s: %zu places\n", file.c_str(), places_.size());
    }

    json run() {
        for (const int count : kCounts) {
            bySight(count);
            tell("grid", gridOf(places_, static_cast<std::size_t>(count)));
            byGridCells(gridOf(places_, static_cast<std::size_t>(count)));
            tell("spread", scene::spreadPositions(tracer_, count));
            for (unsigned seed = 1; seed <= kSeeds; ++seed) {
                std::vector<glm::dvec3> positions = places_;
                std::shuffle(positions.begin(), positions.end(), std::mt19937(seed));
                positions.resize(static_cast<std::size_t>(count));
                tell("random", positions);
            }
        }
        step("remembering", scene::CellSearch::remembering, kCounts.back());
        step("genetic", scene::CellSearch::genetic, kMostGenetic);
        return result_;
    }

  private:
    void tell(const char* name, const std::vector<glm::dvec3>& positions, const json& effort = json::object()) {
        const PictureQuality quality = pictures_.qualityOf(positions);
        json figures{{"positions", positions.size()},
                     {"unknown_share", scene::unknownShareOf(positions, tests_, capture_)},
                     {"psnr_seen_db", quality.psnrSeen},
                     {"psnr_all_db", quality.psnrAll},
                     {"hole_share", quality.holeShare}};
        figures.update(effort);
        add(name, figures);
    }

    void bySight(int count) {
        scene::SightSearchOptions options;
        options.count = count;
        const auto start = std::chrono::steady_clock::now();
        const scene::SightSearchResult found = scene::searchBySight(places_, scene::sightLinesOf(tracer_), options);
        const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
        tell("by_sight", found.positions,
             {{"trials", found.trials}, {"rays", found.rays}, {"seconds", passed.count()}, {"looks", 0}});
    }

    /// The grid as the article compares with it, which draws what stands at the corners of its own cells.
    void byGridCells(const std::vector<glm::dvec3>& grid) {
        scene::UnknownSpace space;
        std::vector<const std::vector<CapturedFace>*> cubes;
        for (const glm::dvec3& position : grid) {
            space.add(capture_(position));
            cubes.push_back(&pictures_.cubeAt(position));
        }
        double unknown = 0;
        for (const glm::dvec3& test : tests_)
            unknown += space.countAt(test, gridCornersAt(grid, test)).unknownShare();
        const PictureQuality quality = pictures_.qualityBy([&](const scene::View& view) {
            std::vector<scene::TileBlock> blocks;
            for (const std::uint32_t corner : gridCornersAt(grid, view.worldFromEye.translation))
                addBlocks(*cubes[corner], blocks);
            return blocks;
        });
        add("grid_cells", {{"positions", grid.size()},
                           {"unknown_share", unknown / static_cast<double>(tests_.size())},
                           {"psnr_seen_db", quality.psnrSeen},
                           {"psnr_all_db", quality.psnrAll},
                           {"hole_share", quality.holeShare}});
    }

    void add(const char* name, const json& figures) {
        std::printf("%s %s\n", name, figures.dump().c_str());
        std::fflush(stdout);
        result_[name].push_back(figures);
    }

    void step(const char* name, scene::CellSearch kind, int count) {
        scene::PositionSearchOptions options;
        options.count = count;
        options.search = kind;
        const auto start = std::chrono::steady_clock::now();
        std::vector<glm::dvec3> positions;
        std::int64_t looks = 0;
        std::vector<std::pair<std::vector<glm::dvec3>, json>> stages;
        scene::searchPositions(places_, {}, capture_, options, [&](const scene::PositionSearchStep& made) {
            positions.push_back(made.position);
            looks += made.evaluations;
            const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
            if (std::find(kCounts.begin(), kCounts.end(), std::ssize(positions)) != kCounts.end())
                stages.emplace_back(positions, json{{"looks", looks}, {"seconds", passed.count()}});
        });
        for (const auto& [chosen, effort] : stages)
            tell(name, chosen, effort);
    }

    scene::PolygonScene polygons_;
    scene::PolygonTracer tracer_;
    std::vector<glm::dvec3> places_, tests_;
    PositionPictures pictures_;
    scene::CaptureSmall capture_ = [this](const glm::dvec3& position) {
        return scene::traceDepthCube(tracer_, position, kSmallFace);
    };
    json result_;
};

/// One figure over the number of positions, which goes by its logarithm; so does the figure if `byLogarithm` says so.
struct Axis {
    const char *figure, *title;
    double low, high;
    bool isLogarithmic;
};

cv::Mat3b draw(const json& result, const Axis& axis) {
    constexpr int kWidth = 800, kHeight = 560, kRim = 70;
    cv::Mat3b picture(kHeight, kWidth, cv::Vec3b(255, 255, 255));
    const auto scaled = [&](double value) { return axis.isLogarithmic ? std::log10(value) : value; };
    const auto at = [&](double count, double value) {
        const double x = std::log2(count / kCounts.front()) / std::log2(kCounts.back() / kCounts.front());
        const double y = (scaled(std::clamp(value, axis.low, axis.high)) - scaled(axis.high)) /
                         (scaled(axis.low) - scaled(axis.high));
        return cv::Point(kRim + static_cast<int>(x * (kWidth - 3 * kRim)),
                         kRim + static_cast<int>(y * (kHeight - 2 * kRim)));
    };
    const cv::Scalar grey(200, 200, 200), black(0, 0, 0);
    const auto write = [&](const std::string& text, cv::Point where, const cv::Scalar& colour) {
        cv::putText(picture, text, where, cv::FONT_HERSHEY_SIMPLEX, 0.45, colour, 1, cv::LINE_AA);
    };
    for (const int count : kCounts) {
        cv::line(picture, at(count, axis.high), at(count, axis.low), grey);
        write(std::to_string(count), at(count, axis.low) + cv::Point(-5, 20), black);
    }
    for (int i = 0; i <= 4; ++i) {
        const double value = axis.isLogarithmic ? axis.low * std::pow(axis.high / axis.low, i / 4.0)
                                                : axis.low + (axis.high - axis.low) * i / 4;
        cv::line(picture, at(kCounts.front(), value), at(kCounts.back(), value), grey);
        char text[32];
        std::snprintf(text, sizeof text, axis.isLogarithmic ? "%.2g" : "%.1f", value);
        write(text, at(kCounts.front(), value) + cv::Point(-50, 5), black);
    }
    write(result["scene"].get<std::string>() + ": " + axis.title + " over the number of positions", {kRim, 30}, black);
    int row = 0;
    for (const auto& [name, colour] :
         {std::pair("by_sight", cv::Scalar(40, 40, 200)), std::pair("remembering", cv::Scalar(40, 160, 220)),
          std::pair("genetic", cv::Scalar(200, 80, 40)), std::pair("spread", cv::Scalar(150, 0, 150)),
          std::pair("grid", cv::Scalar(0, 130, 0)), std::pair("grid_cells", cv::Scalar(120, 180, 0)),
          std::pair("random", cv::Scalar(120, 120, 120))}) {
        const bool isScattered = std::string(name) == "random";
        std::optional<cv::Point> before;
        for (const json& point : result[name]) {
            const cv::Point here = at(point["positions"], point[axis.figure]);
            cv::circle(picture, here, 4, colour, 2, cv::LINE_AA);
            if (before && !isScattered) cv::line(picture, *before, here, colour, 2, cv::LINE_AA);
            before = here;
        }
        write(name, {kWidth - 130, kRim + 20 + 20 * row++}, colour);
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
            const json result = Study(argv[i]).run();
            const std::string name = result["scene"];
            std::ofstream(out / (name + ".json")) << result.dump(1) << "\n";
            cv::Mat3b both;
            cv::hconcat(draw(result, {"unknown_share", "unknown share", 1e-3, 1, true}),
                        draw(result, {"psnr_all_db", "PSNR, dB", 15, 35, false}), both);
            cv::imwrite((out / (name + ".png")).string(), both);
        }
    } catch (const scene::Failure& failure) {
        std::fprintf(stderr, "revisit_position_study: %s\n", failure.what());
        return 1;
    }
}
