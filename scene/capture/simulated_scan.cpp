#include "scene/capture/simulated_scan.h"

#include "scene/srgb.h"
#include "scene/synthetic_light.h"
#include "scene/synthetic_model.h"
#include "scene/synthetic_random.h"
#include "scene/synthetic_tracer.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr double kNadirTurn = -0.25; ///< a scan begins with the mirror looking down, in turns from the horizon
constexpr double kReferenceIntensity = 0.5 / (kReferenceMetres * kReferenceMetres);
constexpr double kNearestMetres = 0.1; ///< what is nearer to the mirror is not told from its own reflections

double luminanceOf(const glm::dvec3& linear) {
    return std::clamp(glm::dot(linear, glm::dvec3(0.2126, 0.7152, 0.0722)), 0.0, 1.0);
}

/// The mirror and pan unit at a time; neither is a whole number.
struct Attitude {
    double encoder = 0, pan = 0;
};

class Instrument {
  public:
    Instrument(const ScannedWorld& world, const Pose& worldFromScanner, const ScannerOptions& options)
        : world_(world), worldFromScanner_(worldFromScanner), options_(options) {
        // Even over the beam and its sweep.
        for (int i = 0; i < options.apertureRays; ++i) {
            const double radius = std::sqrt(static_cast<double>(i) / options.apertureRays),
                         turn = 2.399963229728653 * i;
            const double swept = 0.5 + i * 0.6180339887498949;
            aperture_.push_back({radius * std::cos(turn), radius * std::sin(turn), swept - std::floor(swept) - 0.5});
        }
        // Few rays must not lean to one side: every range would belong to a place beside the one recorded.
        glm::dvec3 mean(0);
        for (const glm::dvec3& place : aperture_)
            mean += place / static_cast<double>(options.apertureRays);
        for (glm::dvec3& place : aperture_)
            place -= mean;
    }

    RawSample take(std::size_t index) const {
        const double seconds = (static_cast<double>(index) + 0.5) / options_.samplesPerSecond;
        const Attitude at = attitudeAt(seconds);
        RawSample sample;
        const double position = at.encoder - std::floor(at.encoder / kEncoderPositions) * kEncoderPositions;
        sample.encoder = static_cast<std::uint16_t>(std::min(std::floor(position), kEncoderPositions - 1.0));
        sample.panStep = static_cast<std::int32_t>(std::floor(at.pan));
        const glm::dvec3 middle = directionOf(at);
        if (std::asin(std::clamp(middle.z, -1.0, 1.0)) < options_.lowestRadians) return sample;

        double sum = 0, weighted = 0;
        for (const glm::dvec3& place : aperture_) {
            const auto echo = echoThrough(seconds + place.z / options_.samplesPerSecond, place);
            if (!echo) continue;
            const double range = std::max(echo->rangeMetres, kNearestMetres);
            const double returned = echo->reflectance * std::clamp(echo->cosine, 0.0, 1.0) / (range * range);
            sum += returned;
            weighted += returned * echo->rangeMetres;
        }
        const double intensity = sum / options_.apertureRays;
        SeededSequence chance(mixBits(options_.seed, index));
        const double threshold = options_.leastIntensity * std::exp(0.3 * chance.normal());
        if (!(intensity > threshold)) return sample;
        const double deviation =
            options_.noiseMetres * std::clamp(std::sqrt(kReferenceIntensity / intensity), kLeastNoise, kMostNoise);
        const double range = weighted / sum + deviation * chance.normal();
        if (range < kNearestMetres) return sample;
        sample.rangeMetres = static_cast<float>(range + options_.constants.mirrorMetres);
        sample.intensity = static_cast<float>(std::min(intensity, 1.0));
        if (world_.colour)
            sample.colour = world_.colour(worldFromScanner_.translation, worldFromScanner_.rotation * middle);
        return sample;
    }

  private:
    Attitude attitudeAt(double seconds) const {
        const double turns = kNadirTurn + seconds * options_.mirrorTurnsPerSecond;
        return {options_.constants.horizonPosition + turns * kEncoderPositions, seconds * options_.panStepsPerSecond};
    }

    glm::dvec3 directionOf(const Attitude& at) const {
        const auto d = beamDirection(options_.constants, at.encoder, at.pan);
        return {d[0], d[1], d[2]};
    }

    /// place: where in the beam, in radii.
    std::optional<Echo> echoThrough(double seconds, const glm::dvec3& place) const {
        const glm::dvec3 axis = directionOf(attitudeAt(seconds));
        const glm::dvec3 any = std::abs(axis.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
        const glm::dvec3 right = glm::normalize(glm::cross(axis, any)), up = glm::cross(right, axis);
        const glm::dvec3 ray = glm::normalize(axis + options_.beamRadians * (place.x * right + place.y * up));
        auto echo = world_.echo(worldFromScanner_.translation, worldFromScanner_.rotation * ray);
        if (echo && echo->rangeMetres > options_.farthestMetres) echo.reset();
        return echo;
    }

    const ScannedWorld& world_;
    const Pose& worldFromScanner_;
    const ScannerOptions& options_;
    std::vector<glm::dvec3> aperture_; ///< across the beam, in radii, and along its sweep, in [-1/2, 1/2)
};

/// Which half turn of the mirror a record belongs to: 0 before the scanner (upwards), 1 behind it (downwards).
int halfOf(std::uint16_t encoder, const ScannerConstants<double>& believed) {
    const double turns = (encoder + 0.5 - believed.horizonPosition) / kEncoderPositions - kNadirTurn;
    return turns - std::floor(turns) < 0.5 ? 0 : 1;
}

} // namespace

ScannedWorld worldOf(const SyntheticScene& scene, bool withColour) {
    ScannedWorld world;
    world.echo = [&scene](const glm::dvec3& origin, const glm::dvec3& direction) -> std::optional<Echo> {
        const auto hit = scene.tracer().cast(origin, direction);
        if (!hit) return std::nullopt;
        const SurfacePoint point = scene.tracer().surfaceAt(origin, direction, *hit);
        const Material& material = scene.model().materials[static_cast<std::size_t>(point.material)];
        return Echo{hit->t, std::abs(glm::dot(point.normal, direction)),
                    luminanceOf(reflectanceAt(material, point.texturePlace))};
    };
    if (withColour)
        world.colour = [&scene](const glm::dvec3& origin, const glm::dvec3& direction) {
            return colourAlong(scene, origin, direction);
        };
    return world;
}

ScannedWorld worldOf(const PolygonTracer& tracer, const SurfaceLight& light, bool withColour) {
    ScannedWorld world;
    world.echo = [&](const glm::dvec3& origin, const glm::dvec3& direction) -> std::optional<Echo> {
        const auto hit = tracer.cast(origin, direction);
        if (!hit) return std::nullopt;
        const PolygonPoint point = light.pointAt(origin, direction, *hit);
        return Echo{hit->t, std::abs(glm::dot(point.flatNormal, direction)),
                    luminanceOf(glm::dvec3(light.colourAt(*hit, point, {})))};
    };
    if (withColour)
        world.colour = [&](const glm::dvec3& origin, const glm::dvec3& direction) {
            const auto hit = tracer.cast(origin, direction);
            if (!hit) return encoded(light.exposed(light.skyTowards(direction)));
            const PolygonPoint point = light.pointAt(origin, direction, *hit);
            return encoded(light.exposed(light.colourAt(*hit, point, {}) * light.at(*hit, point)));
        };
    return world;
}

void setDensity(ScannerOptions& options, double samplesPerDegree) {
    assert(samplesPerDegree > 0);
    // A little beside whole numbers, so that the pattern drifts from turn to turn as it does in the instrument.
    const double samplesPerTurn = 360 * samplesPerDegree + 0.31830988618;
    options.mirrorTurnsPerSecond = options.samplesPerSecond / samplesPerTurn;
    options.panStepsPerSecond =
        options.mirrorTurnsPerSecond / samplesPerDegree * options.constants.panStepsPerHalfTurn / 180;
}

RawScan simulateRawScan(const ScannedWorld& world, const Pose& worldFromScanner, const ScannerOptions& options) {
    assert(world.echo && options.apertureRays >= 1 && options.samplesPerSecond > 0 && options.panStepsPerSecond > 0);
    const double steps = options.panDegrees / 180 * options.constants.panStepsPerHalfTurn;
    const auto count = static_cast<std::size_t>(steps / options.panStepsPerSecond * options.samplesPerSecond);
    const Instrument instrument(world, worldFromScanner, options);
    RawScan raw;
    raw.hasColour = static_cast<bool>(world.colour);
    raw.samples.resize(count);
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) { raw.samples[i] = instrument.take(i); });
    return raw;
}

ScanWithIntensity readRawScan(const RawScan& raw, const ScannerConstants<double>& believed) {
    struct HalfTurn {
        std::size_t first = 0, end = 0;
        int half = 0;
    };
    std::vector<HalfTurn> halves;
    int fronts = 0;
    std::size_t longest = 0;
    for (std::size_t i = 0; i < raw.samples.size(); ++i) {
        const int half = halfOf(raw.samples[i].encoder, believed);
        if (halves.empty() || halves.back().half != half) {
            halves.push_back({i, i, half});
            fronts += half == 0;
        }
        halves.back().end = i + 1;
        longest = std::max(longest, halves.back().end - halves.back().first);
    }

    ScanWithIntensity result;
    Scan& scan = result.scan;
    scan.hasColour = raw.hasColour;
    scan.rows = static_cast<int>(longest);
    int front = -1, back = -1;
    for (const HalfTurn& turn : halves) {
        const int column = turn.half == 0 ? ++front : fronts + ++back;
        scan.columns = std::max(scan.columns, column + 1);
        for (std::size_t i = turn.first; i < turn.end; ++i) {
            const RawSample& sample = raw.samples[i];
            if (!(sample.rangeMetres > 0)) continue;
            const auto p =
                scannedPoint<double>(believed, sample.encoder + 0.5, sample.panStep + 0.5, sample.rangeMetres);
            scan.pointsInScanner.emplace_back(glm::dvec3(p[0], p[1], p[2]));
            const auto grey = static_cast<std::uint8_t>(std::lround(255 * std::clamp(sample.intensity, 0.0f, 1.0f)));
            scan.colours.push_back(raw.hasColour ? sample.colour : Rgb8{grey, grey, grey});
            result.intensities.push_back(sample.intensity);
            scan.row.push_back(static_cast<std::int32_t>(turn.half == 0 ? turn.end - 1 - i : i - turn.first));
            scan.column.push_back(column);
        }
    }
    return result;
}

} // namespace scene
