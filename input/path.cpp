#include "input/path.h"

#include "scene/errors.h"
#include "scene/json_file.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

namespace input {

namespace {

using nlohmann::json;
using Quaternion = glm::dquat;

scene::Pose readHead(const json& from, const std::string& where) {
    try {
        const auto p = from.at("position").get<std::vector<double>>();
        const auto q = from.at("orientation").get<std::vector<double>>();
        bool finite = p.size() == 3 && q.size() == 4;
        for (const double v : p)
            finite = finite && std::isfinite(v);
        double length = 0;
        for (const double v : q)
            length += v * v;
        if (!finite || !(length > 1e-12) || !std::isfinite(length))
            throw scene::Failure("is not a pose", where,
                                 "give a position [x, y, z] and a quaternion [x, y, z, w] that is not zero");
        return scene::poseFromQuaternion({p[0], p[1], p[2]}, q[0], q[1], q[2], q[3]);
    } catch (const json::exception& e) {
        throw scene::Failure(std::string("lacks something or has it wrong (") + e.what() + ")", where,
                             "a pose has t, position and orientation");
    }
}

double readSeconds(const json& from, const std::string& where) {
    if (!from.is_number())
        throw scene::Failure("has a t that is no number", where, "give t in seconds, or leave it out");
    return from.get<double>();
}

Rig readRig(const json& from, const std::string& where) {
    try {
        const auto p = from.at("position").get<std::vector<double>>();
        Rig rig;
        rig.yaw = from.at("yaw").get<double>();
        rig.scale = from.at("scale").get<double>();
        if (p.size() != 3 || !std::isfinite(p[0] + p[1] + p[2] + rig.yaw + rig.scale) || !(rig.scale > 0))
            throw scene::Failure("has a rig that stands nowhere", where, "leave rig out, or give what was recorded");
        rig.origin = {p[0], p[1], p[2]};
        return rig;
    } catch (const json::exception& e) {
        throw scene::Failure(std::string("has a rig that lacks something (") + e.what() + ")", where,
                             "a rig has position, yaw and scale; it may be left out");
    }
}

Quaternion quaternionOf(const glm::dvec4& q) {
    return {q.w, q.x, q.y, q.z};
}

/// The rotation vector, radians, of a unit quaternion; the shorter way round.
glm::dvec3 logarithm(Quaternion q) {
    if (q.w < 0) q = -q;
    const glm::dvec3 v{q.x, q.y, q.z};
    const double s = glm::length(v);
    // Near nought the angle over its sine is 2 up to rounding.
    return s < 1e-9 ? 2.0 * v : v * (2 * std::atan2(s, q.w) / s);
}

Quaternion exponential(const glm::dvec3& v) {
    const double angle = glm::length(v);
    if (angle < 1e-9) return glm::normalize(Quaternion(1, v.x / 2, v.y / 2, v.z / 2));
    const glm::dvec3 axis = v * (std::sin(angle / 2) / angle);
    return {std::cos(angle / 2), axis.x, axis.y, axis.z};
}

/// The slope at a knot between two pieces: of one sign with both, and nought if they disagree. Fritsch and Butland
/// 1984.
glm::dvec3 slopeBetween(const glm::dvec3& before, double hBefore, const glm::dvec3& after, double hAfter) {
    glm::dvec3 slope(0);
    const double w1 = 2 * hAfter + hBefore, w2 = hAfter + 2 * hBefore;
    for (int i = 0; i < 3; ++i)
        if (before[i] * after[i] > 0) slope[i] = (w1 + w2) / (w1 / before[i] + w2 / after[i]);
    return slope;
}

} // namespace

RecordedPath readPath(const std::filesystem::path& file) {
    const json root = scene::readJsonFile(file);
    if (!root.is_object() || !root.contains("poses") || !root["poses"].is_array() || root["poses"].empty())
        throw scene::Failure("lists no poses", file, "write {\"space\": \"walk\", \"poses\": [...]}");
    const std::string space =
        root.contains("space") && root["space"].is_string() ? root["space"].get<std::string>() : "";
    if (space != "walk" && space != "world")
        throw scene::Failure("does not say its space", file, "write \"space\": \"walk\" or \"world\"");
    RecordedPath path;
    path.space = space == "walk" ? PathSpace::walk : PathSpace::world;
    for (std::size_t i = 0; i < root["poses"].size(); ++i) {
        const json& pose = root["poses"][i];
        const std::string where = file.string() + ", pose " + std::to_string(i);
        PathKey key;
        key.spaceFromHead = readHead(pose, where);
        if (pose.contains("t")) key.seconds = readSeconds(pose["t"], where);
        if (pose.contains("rig")) key.rig = readRig(pose["rig"], where);
        if (!path.keys.empty() && key.seconds < path.keys.back().seconds)
            throw scene::Failure("is earlier than the pose before it", where, "give t in seconds, in ascending order");
        path.keys.push_back(key);
    }
    return path;
}

std::string textOf(const RecordedPath& path) {
    json poses = json::array();
    for (const PathKey& key : path.keys) {
        const glm::dvec3& p = key.spaceFromHead.translation;
        const glm::dvec4 q = scene::quaternionOf(key.spaceFromHead);
        json pose{{"t", key.seconds}, {"position", {p.x, p.y, p.z}}, {"orientation", {q.x, q.y, q.z, q.w}}};
        if (key.rig) {
            const glm::dvec3& o = key.rig->origin;
            pose["rig"] = {{"position", {o.x, o.y, o.z}}, {"yaw", key.rig->yaw}, {"scale", key.rig->scale}};
        }
        poses.push_back(std::move(pose));
    }
    return json{{"space", path.space == PathSpace::walk ? "walk" : "world"}, {"poses", poses}}.dump(1) + "\n";
}

SmoothPath::SmoothPath(const std::vector<PathKey>& keys) {
    assert(!keys.empty());
    for (const PathKey& key : keys) {
        Knot knot;
        knot.seconds = key.seconds;
        knot.pose = key.spaceFromHead;
        knot.quaternion = scene::quaternionOf(key.spaceFromHead);
        knots_.push_back(knot);
    }
    // Mean velocities of the pieces; both ends of a piece see its mean turning alike, since it turns about one axis.
    struct Piece {
        double h = 0;
        glm::dvec3 velocity{0}, turning{0};
    };
    std::vector<Piece> pieces;
    for (std::size_t i = 0; i + 1 < knots_.size(); ++i) {
        const Knot &a = knots_[i], &b = knots_[i + 1];
        Piece piece;
        piece.h = b.seconds - a.seconds;
        if (piece.h > 0) {
            piece.velocity = (b.pose.translation - a.pose.translation) / piece.h;
            piece.turning =
                logarithm(glm::conjugate(quaternionOf(a.quaternion)) * quaternionOf(b.quaternion)) / piece.h;
        }
        pieces.push_back(piece);
    }
    for (std::size_t i = 0; i < knots_.size(); ++i) {
        Knot& knot = knots_[i];
        const Piece* const before = i > 0 && pieces[i - 1].h > 0 ? &pieces[i - 1] : nullptr;
        const Piece* const after = i < pieces.size() && pieces[i].h > 0 ? &pieces[i] : nullptr;
        if (before != nullptr) knot.velocityTo = before->velocity, knot.turningTo = before->turning;
        if (after != nullptr) knot.velocity = after->velocity, knot.turning = after->turning;
        if (before == nullptr || after == nullptr) continue;
        knot.velocity = knot.velocityTo = slopeBetween(before->velocity, before->h, after->velocity, after->h);
        knot.turning = knot.turningTo = slopeBetween(before->turning, before->h, after->turning, after->h);
    }
}

std::optional<scene::Pose> SmoothPath::operator()(double seconds) const {
    // Times that were counted in frames may pass the last key by a rounding.
    if (seconds > knots_.back().seconds + 1e-9) return std::nullopt;
    const auto next = std::upper_bound(knots_.begin(), knots_.end(), seconds,
                                       [](double t, const Knot& knot) { return t < knot.seconds; });
    if (next == knots_.begin()) return knots_.front().pose;
    const Knot& a = *std::prev(next);
    if (next == knots_.end() || a.seconds == seconds) return a.pose;
    const Knot& b = *next;
    const double h = b.seconds - a.seconds, t = (seconds - a.seconds) / h, s = 1 - t;

    const glm::dvec3 place = (1 + 2 * t) * s * s * a.pose.translation + t * t * (3 - 2 * t) * b.pose.translation +
                             h * (t * s * s * a.velocity - t * t * s * b.velocityTo);
    const glm::dvec3 first = a.turning * (h / 3), last = b.turningTo * (h / 3);
    const glm::dvec3 middle = logarithm(exponential(-first) * glm::conjugate(quaternionOf(a.quaternion)) *
                                        quaternionOf(b.quaternion) * exponential(-last));
    const Quaternion q = quaternionOf(a.quaternion) * exponential(first * (1 - s * s * s)) *
                         exponential(middle * (t * t * (3 - 2 * t))) * exponential(last * (t * t * t));
    return scene::poseFromQuaternion(place, q.x, q.y, q.z, q.w);
}

} // namespace input
