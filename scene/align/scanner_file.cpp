#include "scene/align/scanner_file.h"

#include "scene/errors.h"
#include "scene/json_file.h"

#include <cmath>
#include <numbers>

namespace scene {

namespace {

using nlohmann::json;

constexpr double kDegrees = 180 / std::numbers::pi;

ScannerConstants<double> constantsIn(const json& root, const char* name, const std::filesystem::path& path) {
    const char* const remedy = "make it anew with: revisit calibrate scanner";
    if (!root.is_object() || !root.contains(name) || !root[name].is_object())
        throw Failure(std::string("has no \"") + name + "\" constants", path, remedy);
    const auto number = [&](const char* key, double least, double most) {
        const json value = root[name].value(key, json());
        if (!value.is_number() || !(value.get<double>() >= least && value.get<double>() <= most))
            throw Failure(std::string("has no \"") + key + "\" that a scanner could have", path, remedy);
        return value.get<double>();
    };
    ScannerConstants<double> constants;
    constants.panStepsPerHalfTurn = number("pan_steps_per_half_turn", 100, 1e8);
    constants.mirrorRadians = number("mirror_deg", 30, 60) / kDegrees;
    constants.horizonPosition = number("horizon_position", -kEncoderPositions, kEncoderPositions);
    constants.mirrorMetres = number("mirror_m", -10, 10);
    return constants;
}

} // namespace

json describeConstants(const ScannerConstants<double>& c) {
    return {{"pan_steps_per_half_turn", c.panStepsPerHalfTurn},
            {"mirror_deg", c.mirrorRadians * kDegrees},
            {"horizon_position", c.horizonPosition},
            {"mirror_m", c.mirrorMetres}};
}

ScannerReading readScannerFile(const std::filesystem::path& path) {
    const json root = readJsonFile(path);
    return {constantsIn(root, "believed", path), constantsIn(root, "constants", path)};
}

} // namespace scene
