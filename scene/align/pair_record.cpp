#include "scene/align/pair_record.h"

#include "scene/checksum.h"

#include <cstring>

#include <nlohmann/json.hpp>

namespace scene {

namespace {

using nlohmann::json;

// CBOR, unlike JSON's text, has numbers that are infinite or none.

json describe(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

json describe(const Pose& pose) {
    return {describe(pose.rotation[0]), describe(pose.rotation[1]), describe(pose.rotation[2]),
            describe(pose.translation)};
}

json describe(const PairFit& fit) {
    json matches = json::array();
    for (const PlaneMatch& match : fit.matches)
        matches.push_back({match.a, match.b});
    const PoseEvidence& evidence = fit.evidence;
    return {{"pose", describe(fit.aFromB)},
            {"evidence", {evidence.agreeing, evidence.against, evidence.sharedCells, evidence.rmsMetres}},
            {"matches", matches},
            {"rms", fit.rmsMetres},
            {"deviation", {fit.deviation.metres, fit.deviation.radians, describe(fit.deviation.loosest)}},
            {"held", fit.isHeld}};
}

glm::dvec3 vectorOf(const json& v) {
    return {v.at(0).get<double>(), v.at(1).get<double>(), v.at(2).get<double>()};
}

Pose poseOf(const json& pose) {
    Pose result;
    for (int column = 0; column < 3; ++column)
        result.rotation[column] = vectorOf(pose.at(static_cast<std::size_t>(column)));
    result.translation = vectorOf(pose.at(3));
    return result;
}

PairFit fitOf(const json& fit) {
    PairFit result;
    result.aFromB = poseOf(fit.at("pose"));
    const json &evidence = fit.at("evidence"), &deviation = fit.at("deviation");
    result.evidence = {evidence.at(0), evidence.at(1), evidence.at(2), evidence.at(3)};
    for (const json& match : fit.at("matches"))
        result.matches.push_back({match.at(0), match.at(1)});
    result.rmsMetres = fit.at("rms");
    result.deviation = {deviation.at(0), deviation.at(1), vectorOf(deviation.at(2))};
    result.isHeld = fit.at("held");
    return result;
}

std::uint64_t checksumOf(std::span<const std::byte> bytes) {
    Checksum checksum;
    checksum.add(bytes);
    return checksum.value();
}

} // namespace

std::vector<std::byte> packPair(const PairResult& result) {
    json plausible = json::array();
    for (const Pose& pose : result.plausible)
        plausible.push_back(describe(pose));
    const std::vector<std::uint8_t> content =
        json::to_cbor({{"verdict", static_cast<int>(result.verdict)},
                       {"best", describe(result.best)},
                       {"rival", result.rival ? describe(*result.rival) : json(nullptr)},
                       {"plausible", plausible},
                       {"decided_by_given", result.isDecidedByGivenPose}});
    const auto bytes = std::as_bytes(std::span(content));
    const std::uint64_t checksum = checksumOf(bytes);
    std::vector<std::byte> packed(sizeof checksum + bytes.size());
    std::memcpy(packed.data(), &checksum, sizeof checksum);
    std::memcpy(packed.data() + sizeof checksum, bytes.data(), bytes.size());
    return packed;
}

std::optional<PairResult> unpackPair(std::span<const std::byte> packed) {
    std::uint64_t checksum = 0;
    if (packed.size() <= sizeof checksum) return std::nullopt;
    std::memcpy(&checksum, packed.data(), sizeof checksum);
    const std::span<const std::byte> bytes = packed.subspan(sizeof checksum);
    if (checksumOf(bytes) != checksum) return std::nullopt;
    const auto* first = reinterpret_cast<const std::uint8_t*>(bytes.data());
    const json content = json::from_cbor(first, first + bytes.size(), true, false);
    if (content.is_discarded()) return std::nullopt;
    PairResult result;
    try {
        const int verdict = content.at("verdict");
        if (verdict < 0 || verdict > static_cast<int>(PairVerdict::apart)) return std::nullopt;
        result.verdict = static_cast<PairVerdict>(verdict);
        result.best = fitOf(content.at("best"));
        if (!content.at("rival").is_null()) result.rival = fitOf(content.at("rival"));
        for (const json& pose : content.at("plausible"))
            result.plausible.push_back(poseOf(pose));
        result.isDecidedByGivenPose = content.at("decided_by_given");
    } catch (const json::exception&) { // of some other program
        return std::nullopt;
    }
    return result;
}

} // namespace scene
