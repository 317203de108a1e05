#include "scene/synthetic_light.h"

#include "scene/synthetic_random.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <span>
#include <tbb/parallel_for.h>

namespace scene {

namespace {

constexpr int kLampRays = 16, kMaxNodesAlongEdge = 200;
constexpr int kRaysOfPass[] = {16, 60}; ///< one gathering for each reflection; the last is what is seen
constexpr double kLift = 1e-3;          ///< metres a ray starts above its surface
constexpr double kInset = 1e-2; ///< metres a light node keeps from the edge of its patch: it must not look behind walls

/// A place that light is gathered for.
struct LightNode {
    glm::dvec3 position, normal;
    bool twoSided = false;
    bool isUnseen = false; ///< outside of its outline, or lying on the ground: takes its neighbours' light
    int column = 0, row = 0;
};

/// The nodes of one surface, as they follow each other in its light map.
struct LightSheet {
    int columns = 1, rows = 1;
    std::size_t first = 0;
    std::vector<glm::dvec3>* target = nullptr;
};

bool isWithin(const Patch& patch, const glm::dvec2& p) {
    for (std::size_t i = 0; i < patch.outline.size(); ++i) {
        const glm::dvec2 a = patch.outline[i], b = patch.outline[(i + 1) % patch.outline.size()];
        if ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x) < 0) return false;
    }
    return std::none_of(patch.holes.begin(), patch.holes.end(), [&](const Rectangle& hole) {
        return p.x > hole.low.x && p.x < hole.high.x && p.y > hole.low.y && p.y < hole.high.y;
    });
}

int nodesAlong(double metres, double spacing) {
    if (metres < spacing) return 1;
    return std::min(static_cast<int>(std::ceil(metres / spacing)) + 1, kMaxNodesAlongEdge);
}

/// What a material reflects from afar. Lamps reflect nothing: their light is counted as a lamp's.
glm::dvec3 meanOf(const Material& material) {
    if (material.emission != glm::dvec3(0)) return glm::dvec3(0);
    glm::dvec3 sum(0);
    constexpr int kPlaces = 48;
    for (std::uint64_t i = 0; i < kPlaces; ++i)
        sum += reflectanceAt(material, {unitOf(mixBits(i, 1)), unitOf(mixBits(i, 2)), 0.0});
    return sum / static_cast<double>(kPlaces);
}

/// Bilinear; zero where nothing was lit yet.
glm::dvec3 lightFrom(const LightMap& map, const glm::dvec2& place) {
    if (map.nodes.empty()) return glm::dvec3(0);
    const double x = std::clamp(place.x, 0.0, 1.0) * (map.columns - 1),
                 y = std::clamp(place.y, 0.0, 1.0) * (map.rows - 1);
    const int i = std::min(static_cast<int>(x), std::max(map.columns - 2, 0));
    const int j = std::min(static_cast<int>(y), std::max(map.rows - 2, 0));
    const int right = std::min(i + 1, map.columns - 1), below = std::min(j + 1, map.rows - 1);
    const auto node = [&](int column, int row) {
        return map.nodes[static_cast<std::size_t>(row * map.columns + column)];
    };
    return glm::mix(glm::mix(node(i, j), node(right, j), x - i), glm::mix(node(i, below), node(right, below), x - i),
                    y - j);
}

/// What the model's light maps have of a point.
glm::dvec3 mappedLight(const SyntheticModel& model, const RayHit& hit, const SurfacePoint& point) {
    if (hit.kind == SurfaceKind::patch) return lightFrom(model.patches[hit.index].light, point.lightPlace);
    if (hit.kind == SurfaceKind::round) return lightFrom(model.rounds[hit.index].light, point.lightPlace);
    const std::vector<glm::dvec3>& light = model.mesh.light;
    if (light.empty()) return glm::dvec3(0);
    const auto [i, j, k] = model.mesh.triangles[hit.index];
    const double wb = point.lightPlace.x, wc = point.lightPlace.y;
    return light[i] * (1.0 - wb - wc) + light[j] * wb + light[k] * wc;
}

/// Light that falls on a point: what is in its light map, and the sun.
glm::dvec3 lightOn(const SyntheticModel& model, const SyntheticTracer& tracer, const RayHit& hit,
                   const SurfacePoint& point) {
    const glm::dvec3 mapped = mappedLight(model, hit, point);
    const glm::dvec3 sun = model.sky.towardsSun;
    double facing = glm::dot(point.shadingNormal, sun), side = 1.0;
    bool isLit = facing > 0 && glm::dot(point.normal, sun) > 0;
    if (point.twoSided) {
        side = facing < 0 ? -1.0 : 1.0;
        facing = 0.2 + 0.6 * std::abs(facing); // a leaf scatters what falls on either side through itself
        isLit = true;
    }
    if (!isLit || model.sky.sun == glm::dvec3(0)) return mapped;
    if (tracer.isBlocked(point.position + point.normal * (side * kLift), sun, 1e6)) return mapped;
    return mapped + model.sky.sun * facing;
}

class Lighting {
  public:
    Lighting(SyntheticModel& model, const SyntheticTracer& tracer) : model_(model), tracer_(tracer) {
        for (const Material& material : model.materials)
            meanReflectance_.push_back(meanOf(material));
        for (const AreaLight& lamp : model.lamps)
            hasOpenings_ = hasOpenings_ || lamp.isOpening;
        for (Patch& patch : model.patches)
            addPatch(patch);
        for (Round& round : model.rounds)
            addRound(round);
        Mesh& mesh = model.mesh;
        for (std::size_t i = 0; i < mesh.positions.size(); ++i)
            nodes_.push_back({mesh.positions[i], mesh.normals[i], false, false, static_cast<int>(i), 0});
        mesh.light.resize(mesh.positions.size());
        meshFirst_ = nodes_.size() - mesh.positions.size();
    }

    void run() {
        std::vector<glm::dvec3> lamps(nodes_.size(), glm::dvec3(0)), indirect(lamps);
        std::vector<std::uint8_t> isBuried(nodes_.size());
        tbb::parallel_for(std::size_t{0}, nodes_.size(), [&](std::size_t i) {
            if (!nodes_[i].isUnseen) lamps[i] = fromLamps(i);
        });
        deliver(lamps, indirect, isBuried);
        for (const int rays : kRaysOfPass) {
            tbb::parallel_for(std::size_t{0}, nodes_.size(), [&](std::size_t i) {
                if (!nodes_[i].isUnseen && isBuried[i] == 0) indirect[i] = gathered(i, rays, isBuried[i]);
            });
            deliver(lamps, indirect, isBuried);
        }
    }

  private:
    void addPatch(Patch& patch) {
        const glm::dvec2 size = patch.extent.high - patch.extent.low;
        LightMap& map = patch.light;
        const double spacing = patch.lightSpacing > 0 ? patch.lightSpacing : model_.lightSpacing;
        map.columns = nodesAlong(size.x, spacing);
        map.rows = nodesAlong(size.y, spacing);
        map.nodes.assign(static_cast<std::size_t>(map.columns * map.rows), glm::dvec3(0));
        sheets_.push_back({map.columns, map.rows, nodes_.size(), &map.nodes});
        const glm::dvec2 inset = glm::min(glm::dvec2(kInset), size / 4.0);
        const auto along = [](int index, int count) {
            return count == 1 ? 0.5 : static_cast<double>(index) / (count - 1);
        };
        for (int row = 0; row < map.rows; ++row)
            for (int column = 0; column < map.columns; ++column) {
                const glm::dvec2 part(along(column, map.columns), along(row, map.rows));
                const glm::dvec2 p =
                    glm::clamp(patch.extent.low + part * size, patch.extent.low + inset, patch.extent.high - inset);
                const glm::dvec3 position = patch.origin + patch.u * p.x + patch.v * p.y;
                const bool isUnderneath = patch.normal.z < -0.99 && position.z < kLift;
                const bool isUnseen = isUnderneath || (map.columns * map.rows > 1 && !isWithin(patch, p));
                nodes_.push_back({position, patch.normal, patch.twoSided, isUnseen, column, row});
            }
    }

    void addRound(Round& round) {
        LightMap& map = round.light;
        const double girth = kTwoPi * round.radius;
        map.columns = std::clamp(nodesAlong(girth, model_.lightSpacing), 5, 24);
        map.rows = round.kind == RoundKind::tube ? std::max(nodesAlong(round.length, model_.lightSpacing), 2)
                                                 : std::clamp(nodesAlong(girth / 2, model_.lightSpacing), 4, 16);
        map.nodes.assign(static_cast<std::size_t>(map.columns * map.rows), glm::dvec3(0));
        sheets_.push_back({map.columns, map.rows, nodes_.size(), &map.nodes});
        const double inset = round.kind == RoundKind::tube ? std::min(kInset / round.length, 0.25) : 0.0;
        for (int row = 0; row < map.rows; ++row)
            for (int column = 0; column < map.columns; ++column) {
                const double t = static_cast<double>(row) / (map.rows - 1);
                const RoundPlace place =
                    placeOn(round, static_cast<double>(column) / (map.columns - 1), std::clamp(t, inset, 1.0 - inset));
                nodes_.push_back({place.position, place.normal, false, false, column, row});
            }
    }

    /// Hands the light to the maps, with light for buried and outside nodes taken from their neighbours.
    void deliver(const std::vector<glm::dvec3>& lamps, const std::vector<glm::dvec3>& indirect,
                 const std::vector<std::uint8_t>& isBuried) {
        tbb::parallel_for(std::size_t{0}, sheets_.size(), [&](std::size_t s) {
            const LightSheet& sheet = sheets_[s];
            const std::size_t count = sheet.target->size();
            std::vector<std::uint8_t> isKnown(count);
            for (std::size_t i = 0; i < count; ++i)
                isKnown[i] = !nodes_[sheet.first + i].isUnseen && isBuried[sheet.first + i] == 0;
            const auto filled = [&](const std::vector<glm::dvec3>& light, int smoothings) {
                const auto first = light.begin() + static_cast<std::ptrdiff_t>(sheet.first);
                std::vector<glm::dvec3> values(first, first + static_cast<std::ptrdiff_t>(count));
                std::vector<std::uint8_t> known = isKnown;
                while (spread(sheet, values, known)) {
                }
                for (int i = 0; i < smoothings; ++i)
                    smooth(sheet, values);
                return values;
            };
            *sheet.target = filled(lamps, 1);
            const std::vector<glm::dvec3> rest = filled(indirect, 3);
            for (std::size_t i = 0; i < count; ++i)
                (*sheet.target)[i] += rest[i];
        });
        std::vector<glm::dvec3>& mesh = model_.mesh.light;
        for (std::size_t i = 0; i < mesh.size(); ++i)
            mesh[i] = lamps[meshFirst_ + i] + indirect[meshFirst_ + i];
    }

    /// One step outwards from the known nodes; false when nothing is left to do.
    static bool spread(const LightSheet& sheet, std::vector<glm::dvec3>& values, std::vector<std::uint8_t>& isKnown) {
        const std::vector<std::uint8_t> before = isKnown;
        bool hasSpread = false;
        for (int row = 0; row < sheet.rows; ++row)
            for (int column = 0; column < sheet.columns; ++column) {
                const std::size_t here = static_cast<std::size_t>(row * sheet.columns + column);
                if (before[here]) continue;
                glm::dvec3 sum(0);
                int found = 0;
                for (int y = std::max(row - 1, 0); y <= std::min(row + 1, sheet.rows - 1); ++y)
                    for (int x = std::max(column - 1, 0); x <= std::min(column + 1, sheet.columns - 1); ++x) {
                        const std::size_t there = static_cast<std::size_t>(y * sheet.columns + x);
                        if (before[there]) sum += values[there], ++found;
                    }
                if (found == 0) continue;
                values[here] = sum / static_cast<double>(found);
                isKnown[here] = 1;
                hasSpread = true;
            }
        return hasSpread;
    }

    /// Takes the grain of the gathering out: 1 2 1 along rows, then along columns.
    static void smooth(const LightSheet& sheet, std::vector<glm::dvec3>& values) {
        for (const bool alongRows : {true, false}) {
            const std::vector<glm::dvec3> before = values;
            const int step = alongRows ? 1 : sheet.columns, count = alongRows ? sheet.columns : sheet.rows;
            for (int i = 0; i < sheet.columns * sheet.rows; ++i) {
                const int at = alongRows ? i % sheet.columns : i / sheet.columns;
                const glm::dvec3 left = before[static_cast<std::size_t>(at > 0 ? i - step : i)];
                const glm::dvec3 right = before[static_cast<std::size_t>(at < count - 1 ? i + step : i)];
                values[static_cast<std::size_t>(i)] = (left + right) / 4.0 + before[static_cast<std::size_t>(i)] / 2.0;
            }
        }
    }

    glm::dvec3 fromLamps(std::size_t index) const {
        const LightNode& node = nodes_[index];
        glm::dvec3 sum(0);
        for (std::size_t lampIndex = 0; lampIndex < model_.lamps.size(); ++lampIndex) {
            const AreaLight& lamp = model_.lamps[lampIndex];
            const glm::dvec3 area = glm::cross(lamp.edgeU, lamp.edgeV);
            for (int ray = 0; ray < kLampRays; ++ray) {
                const std::uint64_t bits = mixBits(index * 16 + lampIndex, static_cast<std::uint64_t>(ray));
                const glm::dvec3 onLamp = lamp.corner + lamp.edgeU * ((ray % 4 + unitOf(bits)) / 4.0) +
                                          lamp.edgeV * ((ray / 4 + unitOf(mixBits(bits))) / 4.0);
                const glm::dvec3 way = onLamp - node.position;
                const double length2 = glm::dot(way, way);
                double facing = glm::dot(way, node.normal);
                if (node.twoSided) facing = std::abs(facing) / 2;
                const double shining = -glm::dot(way, area);
                if (facing <= 0 || shining <= 0) continue;
                const glm::dvec3 start = node.position + node.normal * kLift;
                if (tracer_.isBlocked(start, onLamp - start, lamp.isOpening ? 1e6 : 0.998)) continue;
                const glm::dvec3 radiance = lamp.isOpening ? skyRadiance(model_.sky, way) : lamp.radiance;
                sum += radiance * (facing * shining / (length2 * length2 * kTwoPi / 2 * kLampRays));
            }
        }
        return sum;
    }

    glm::dvec3 gathered(std::size_t index, int rays, std::uint8_t& isBuried) const {
        const LightNode& node = nodes_[index];
        const glm::dvec3 across = std::abs(node.normal.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
        const glm::dvec3 side = glm::normalize(glm::cross(across, node.normal)), up = glm::cross(node.normal, side);
        // Neighbours turn their rays differently but evenly, so that smoothing makes one dense bundle of
        // them.
        const double turns = node.column * 0.7548776662 + node.row * 0.5698402910,
                     lifts = node.column * 0.5698402910 + node.row * 0.3247179572 * 2.0;
        const double turn = turns - std::floor(turns), lift = lifts - std::floor(lifts);
        glm::dvec3 sum(0);
        int backs = 0;
        for (int ray = 0; ray < rays; ++ray) {
            // Cosine-weighted: a spiral with as much of the disc between any two turns.
            const double radius2 = (ray + lift) / rays, angle = kTwoPi * (turn + ray * 0.6180339887498949);
            const double radius = std::sqrt(radius2), sign = node.twoSided && (ray & 1) ? -1.0 : 1.0;
            const glm::dvec3 direction = side * (radius * std::cos(angle)) + up * (radius * std::sin(angle)) +
                                         node.normal * (sign * std::sqrt(1.0 - radius2));
            const glm::dvec3 start = node.position + node.normal * (sign * kLift);
            const auto hit = tracer_.cast(start, direction);
            if (!hit) {
                if (!hasOpenings_) sum += skyRadiance(model_.sky, direction);
                continue;
            }
            const SurfacePoint point = tracer_.surfaceAt(start, direction, *hit);
            if (!point.twoSided && glm::dot(point.normal, direction) > 0) {
                ++backs; // inside of something solid: no light
                continue;
            }
            sum += meanReflectance_[static_cast<std::size_t>(point.material)] * lightOn(model_, tracer_, *hit, point);
        }
        isBuried = backs > rays / 4;
        return sum / static_cast<double>(rays);
    }

    SyntheticModel& model_;
    const SyntheticTracer& tracer_;
    bool hasOpenings_ = false; ///< all light of the sky comes through them
    std::vector<glm::dvec3> meanReflectance_;
    std::vector<LightNode> nodes_;
    std::vector<LightSheet> sheets_;
    std::size_t meshFirst_ = 0;
};

} // namespace

void lightModel(SyntheticModel& model, const SyntheticTracer& tracer) {
    Lighting(model, tracer).run();
}

glm::dvec3 radianceOf(const SyntheticModel& model, const SyntheticTracer& tracer, const RayHit& hit,
                      const SurfacePoint& point) {
    const Material& material = model.materials[static_cast<std::size_t>(point.material)];
    return lightOn(model, tracer, hit, point) * reflectanceAt(material, point.texturePlace) + material.emission;
}

glm::dvec3 skyRadiance(const Sky& sky, const glm::dvec3& direction) {
    const glm::dvec3 d = glm::normalize(direction);
    const double up = std::max(d.z, 0.0);
    glm::dvec3 colour = glm::mix(sky.horizon, sky.zenith, std::pow(up, 0.45));
    colour += sky.horizon * (0.5 * std::pow(std::max(glm::dot(d, sky.towardsSun), 0.0), 24.0));
    if (sky.clouds > 0 && up > 0.02) {
        // Clouds lie on a flat ceiling: they crowd towards the horizon.
        const glm::dvec3 ceiling(d.x / (up + 0.12) * 1.1, d.y / (up + 0.12) * 1.1, 0.5);
        const double cover = layeredNoise(ceiling, 5, sky.seed);
        const double cloud = softStep(0.75 - 0.4 * sky.clouds, 0.13, cover) * softStep(0.08, 0.06, up);
        colour = glm::mix(colour, glm::dvec3(1.05, 1.05, 1.08) * (0.75 + 0.5 * cover), 0.85 * cloud);
    }
    return colour;
}

glm::dvec3 exposed(const glm::dvec3& radiance, double exposure) {
    return 1.0 - glm::exp(radiance * -exposure);
}

} // namespace scene
