#include "scene/synthetic.h"

#include "scene/srgb.h"
#include "scene/synthetic_light.h"
#include "scene/synthetic_model.h"
#include "scene/synthetic_random.h"
#include "scene/synthetic_tracer.h"

#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <oneapi/tbb/collaborative_call_once.h>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

glm::dvec3 colourAt(const SyntheticScene& scene, const glm::dvec3& origin, const glm::dvec3& direction,
                    const std::optional<RayHit>& hit) {
    const SyntheticModel& model = scene.litModel();
    const glm::dvec3 radiance =
        hit ? radianceOf(model, scene.tracer(), *hit, scene.tracer().surfaceAt(origin, direction, *hit))
            : skyRadiance(model.sky, direction);
    return exposed(radiance, model.exposure);
}

/// Where the rays of a pixel pierce it: 1 its centre, else a low-discrepancy pattern that is the same in
/// every pixel.
std::vector<glm::dvec2> samplePlaces(int samplesPerPixel) {
    if (samplesPerPixel == 1) return {{0.5, 0.5}};
    std::vector<glm::dvec2> places;
    for (int i = 0; i < samplesPerPixel; ++i) {
        const double x = (i + 0.5) / samplesPerPixel, y = 0.5 + (i + 0.25) * 0.6180339887498949;
        places.emplace_back(x, y - std::floor(y));
    }
    return places;
}

} // namespace

// Lighting is parallel and may be asked for by parallel loops: who waits for it helps.
struct SyntheticScene::LitOnce {
    tbb::collaborative_once_flag flag;
};

SyntheticScene::SyntheticScene(SyntheticModel model)
    : model_(std::make_unique<SyntheticModel>(std::move(model))), tracer_(std::make_unique<SyntheticTracer>(*model_)),
      litOnce_(std::make_unique<LitOnce>()) {}

SyntheticScene::~SyntheticScene() = default;
SyntheticScene::SyntheticScene(SyntheticScene&&) noexcept = default;
SyntheticScene& SyntheticScene::operator=(SyntheticScene&&) noexcept = default;

const SyntheticModel& SyntheticScene::litModel() const {
    tbb::collaborative_call_once(litOnce_->flag, [&] { lightModel(*model_, *tracer_); });
    return *model_;
}

std::optional<SyntheticScene> makeSyntheticScene(const std::string& name, std::uint32_t seed) {
    if (name == "room") return makeRoom(seed);
    if (name == "corner") return makeStreetCorner(seed);
    if (name == "corridor") return makeCorridor(seed);
    return std::nullopt;
}

std::optional<Hit> castRay(const SyntheticScene& scene, const glm::dvec3& originInWorld, const glm::dvec3& direction) {
    const auto hit = scene.tracer().cast(originInWorld, direction);
    if (!hit) return std::nullopt;
    const SurfacePoint point = scene.tracer().surfaceAt(originInWorld, direction, *hit);
    Hit result;
    result.position = point.position;
    result.normal = glm::dot(point.normal, direction) > 0 ? -point.normal : point.normal;
    result.distanceMetres = hit->t * glm::length(direction);
    return result;
}

Rgb8 colourAlong(const SyntheticScene& scene, const glm::dvec3& originInWorld, const glm::dvec3& direction) {
    return encoded(colourAt(scene, originInWorld, direction, scene.tracer().cast(originInWorld, direction)));
}

DepthImage renderTruth(const SyntheticScene& scene, const View& view, int samplesPerPixel) {
    assert(isUsable(view.camera) && samplesPerPixel >= 1);
    const Camera& camera = view.camera;
    DepthImage image;
    image.name = scene.model().name;
    image.camera = camera;
    image.worldFromCamera = view.worldFromEye;
    image.colour = Image<Rgb8>(camera.width, camera.height);
    image.disparity = Image<float>(camera.width, camera.height, 0.0f);
    image.flags = Image<std::uint8_t>(camera.width, camera.height, std::uint8_t{0});

    const glm::dvec3 eye = view.worldFromEye.translation;
    const std::vector<glm::dvec2> places = samplePlaces(samplesPerPixel);
    tbb::parallel_for(0, camera.height, [&](int y) {
        for (int x = 0; x < camera.width; ++x) {
            // The ray reaches depth 1 after one length: t is depth along z.
            const glm::dvec3 centre = view.worldFromEye.rotation * rayThrough(camera, x + 0.5, y + 0.5);
            const auto hit = scene.tracer().cast(eye, centre);
            if (hit)
                image.disparity(x, y) = static_cast<float>(1.0 / hit->t);
            else
                image.flags(x, y) = kNoSurface;
            glm::dvec3 sum(0);
            if (samplesPerPixel == 1)
                sum = colourAt(scene, eye, centre, hit);
            else
                for (const glm::dvec2& place : places) {
                    const glm::dvec3 ray = view.worldFromEye.rotation * rayThrough(camera, x + place.x, y + place.y);
                    sum += colourAt(scene, eye, ray, scene.tracer().cast(eye, ray));
                }
            image.colour(x, y) = encoded(sum / static_cast<double>(samplesPerPixel));
        }
    });
    return image;
}

Scan simulateScan(const SyntheticScene& scene, const Pose& worldFromScanner, int columns, int rows,
                  const ScanOptions& options) {
    assert(columns > 0 && rows > 0 && options.topRadians > options.bottomRadians);
    Image<glm::vec3> points(columns, rows);
    Image<Rgb8> colours(columns, rows, Rgb8{128, 128, 128});
    Image<std::uint8_t> isHit(columns, rows, std::uint8_t{0});
    tbb::parallel_for(0, rows, [&](int row) {
        const double elevation = options.topRadians - (row + 0.5) * (options.topRadians - options.bottomRadians) / rows;
        for (int column = 0; column < columns; ++column) {
            const double azimuth = -(column + 0.5) * kTwoPi / columns;
            const glm::dvec3 ray(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                                 std::sin(elevation));
            const glm::dvec3 origin = worldFromScanner.translation, direction = worldFromScanner.rotation * ray;
            const auto hit = scene.tracer().cast(origin, direction);
            if (!hit) continue;
            double range = hit->t;
            if (options.rangeNoiseMetres > 0) {
                SeededSequence noise(mixBits(options.noiseSeed, static_cast<std::uint64_t>(row) << 32 |
                                                                    static_cast<std::uint64_t>(column)));
                range += options.rangeNoiseMetres * noise.normal();
            }
            if (range <= 0) continue;
            points(column, row) = glm::vec3(ray * range);
            if (options.withColour) colours(column, row) = encoded(colourAt(scene, origin, direction, hit));
            isHit(column, row) = 1;
        }
    });

    Scan scan;
    scan.name = scene.model().name;
    scan.worldFromScanner = worldFromScanner;
    scan.rows = rows, scan.columns = columns;
    scan.hasColour = options.withColour;
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            if (!isHit(column, row)) continue;
            scan.pointsInScanner.push_back(points(column, row));
            scan.colours.push_back(colours(column, row));
            scan.row.push_back(row);
            scan.column.push_back(column);
        }
    return scan;
}

} // namespace scene
