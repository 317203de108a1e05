#include "app/positions.h"

#include "scene/errors.h"
#include "scene/json_file.h"

#include <charconv>
#include <cmath>

#include <CLI/Error.hpp>
#include <glm/geometric.hpp>

namespace app {

namespace {

using nlohmann::json;

constexpr int kMostPositions = 100'000;
constexpr double kFarthest = 1e9; ///< metres from the origin: no scene is there

const char* const kFormRemedy = "write {\"positions\": [[x, y, z], ...]} in the coordinates of the polygons";

} // namespace

PositionsWish parsePositions(const std::string& text) {
    if (text == "auto") return {kMostSearched, {}, true};
    double number = 0;
    const char* const end = text.data() + text.size();
    const auto [last, error] = std::from_chars(text.data(), end, number);
    if (error == std::errc::invalid_argument || last != end) return {0, text};
    if (!(number >= 1 && number <= kMostPositions) || number != std::floor(number))
        throw CLI::ValidationError("--positions " + text,
                                   "is no count from 1 to " + std::to_string(kMostPositions) + "; write e.g. 8");
    return {static_cast<int>(number), {}};
}

glm::dvec3 parseDirection(const std::vector<double>& numbers) {
    const glm::dvec3 direction(numbers.at(0), numbers.at(1), numbers.at(2));
    const double length = glm::length(direction);
    if (!(length > 0) || !std::isfinite(length))
        throw CLI::ValidationError("--towards-sun", "is no direction; write e.g. 0.3 0.9 0.3");
    return direction / length;
}

void checkPositionsWish(const PositionsWish& wish, const scene::Capture& capture) {
    const bool isGiven = wish.count > 0 || !wish.file.empty();
    if (!capture.polygons.empty() && !isGiven)
        throw scene::Failure("polygons are captured from reference positions, and none are given",
                             capture.polygons.front(), "add e.g. --positions 8, or --positions FILE");
    if (capture.polygons.empty() && isGiven)
        throw scene::Failure("is for polygons; this capture has positions of its own", std::string("--positions"),
                             "leave it out");
}

std::vector<glm::dvec3> readPositionsFile(const std::filesystem::path& path) {
    const json root = scene::readJsonFile(path);
    if (!root.is_object() || !root.contains("positions") || !root["positions"].is_array() || root["positions"].empty())
        throw scene::Failure("holds no list of positions", path, kFormRemedy);
    if (root["positions"].size() > static_cast<std::size_t>(kMostPositions))
        throw scene::Failure("holds more than " + std::to_string(kMostPositions) + " positions", path, "remove some");
    std::vector<glm::dvec3> positions;
    for (const json& p : root["positions"]) {
        const std::string where = path.string() + ", position " + std::to_string(positions.size());
        if (!p.is_array() || p.size() != 3 || !p[0].is_number() || !p[1].is_number() || !p[2].is_number())
            throw scene::Failure("is not three numbers", where, kFormRemedy);
        positions.emplace_back(p[0].get<double>(), p[1].get<double>(), p[2].get<double>());
        if (!(glm::length(positions.back()) <= kFarthest))
            throw scene::Failure("is farther away than any scene", where, "correct it");
    }
    return positions;
}

} // namespace app
