// align: where the photographs of a capture stood, found by what they have in common.

#include "app/build_stages.h"
#include "app/progress.h"

#include "scene/align/joint_images.h"
#include "scene/camera_json.h"
#include "scene/image_store.h"
#include "scene/import/photo.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>

#include <glm/geometric.hpp>

namespace app {

namespace {

using nlohmann::json;

/// Changed whenever what the stage finds changes, so that results of older versions are not taken for new ones.
constexpr int kAdjustVersion = 5;
constexpr int kPixelsAcross = 400;  ///< of a sketch, about: finer ones hold poses no better
constexpr int kFewestAcross = 100;  ///< coarser ones hold them worse than they are given
constexpr float kLeastShare = 0.1f; ///< of an image, that a partner must see of it

std::size_t bytesOfSketches(const scene::Capture& capture, int shrink) {
    std::size_t bytes = 0;
    for (const scene::PhotoSource& photo : capture.photos)
        bytes += scene::bytesOfSketch(photo.camera, shrink);
    return bytes;
}

int pixelsAcross(const scene::Capture& capture) {
    int across = 0;
    for (const scene::PhotoSource& photo : capture.photos)
        across = std::max({across, photo.camera.width, photo.camera.height});
    return across;
}

/// How much smaller sketches are than photographs.
struct Shrink {
    int wished = 1; ///< finer ones hold poses no better
    int factor = 1; ///< so that all fit into memory
};

/// Nothing if none fit.
std::optional<Shrink> shrinkFor(const scene::Capture& capture, std::size_t bytes) {
    const int across = pixelsAcross(capture);
    Shrink shrink;
    shrink.wished = std::max(1, static_cast<int>(std::lround(static_cast<double>(across) / kPixelsAcross)));
    shrink.factor = shrink.wished;
    while (bytesOfSketches(capture, shrink.factor) > bytes && across / (shrink.factor + 1) >= kFewestAcross)
        ++shrink.factor;
    if (bytesOfSketches(capture, shrink.factor) > bytes) return std::nullopt;
    return shrink;
}

std::string keyOfAdjustment(const scene::Capture& capture, const std::vector<std::size_t>& heldOut, int shrink,
                            const scene::JointImagesOptions& o) {
    json photos = json::array();
    for (const scene::PhotoSource& photo : capture.photos)
        photos.push_back(describeSource(photo));
    return keyOf({kAdjustVersion, photos, heldOut, shrink, kLeastShare, o.maxPartners, o.samplesPerPair,
                  o.leastAgreeing, o.passes, o.damping, o.mostMoved, o.mostAgainst, o.leastPixels,
                  o.comparison.sameSurface, o.comparison.pixelError});
}

const char* nameOf(scene::ImagePlace place) {
    switch (place) {
    case scene::ImagePlace::adjusted:
        return "adjusted";
    case scene::ImagePlace::strayed:
        return "strayed";
    case scene::ImagePlace::loose:
        return "loose";
    case scene::ImagePlace::given:
        break;
    }
    return "given";
}

json describe(const scene::Apartness& apart) {
    return {{"range_share", apart.range},
            {"light_log", apart.grey},
            {"against_share", apart.against},
            {"samples", apart.agreeing}};
}

json describe(const scene::Capture& capture, const scene::JointImages& found) {
    json images = json::array();
    double mostMetres = 0, mostRadians = 0, sumMetres = 0, sumRadians = 0;
    int adjusted = 0;
    for (std::size_t i = 0; i < capture.photos.size(); ++i) {
        const scene::Pose &given = capture.photos[i].worldFromCamera, &pose = found.worldFromCameras[i];
        images.push_back({{"name", capture.photos[i].name}, {"place", nameOf(found.places[i])}});
        if (found.places[i] != scene::ImagePlace::adjusted) continue;
        const double metres = glm::length(pose.translation - given.translation);
        const double radians = std::acos(std::clamp(scene::cosineBetween(given.rotation, pose.rotation), -1.0, 1.0));
        images.back()["world_from_camera"] = scene::rowMajor(pose);
        images.back()["moved_m"] = metres;
        images.back()["turned_deg"] = radians * kDegrees;
        mostMetres = std::max(mostMetres, metres), mostRadians = std::max(mostRadians, radians);
        sumMetres += metres, sumRadians += radians;
        ++adjusted;
    }
    const double per = 1.0 / std::max(adjusted, 1);
    return {{"images", images},
            {"adjusted", adjusted},
            {"before", describe(found.before)},
            {"after", describe(found.after)},
            {"moved_pixels", found.movedPixels},
            {"worse", found.isWorse},
            {"mean_m", sumMetres * per},
            {"most_m", mostMetres},
            {"mean_deg", sumRadians * per * kDegrees},
            {"most_deg", mostRadians * kDegrees}};
}

scene::JointImages adjust(const scene::Capture& capture, const std::vector<std::size_t>& heldOut, int shrink,
                          const scene::JointImagesOptions& options, std::uint64_t memoryBytes) {
    const std::size_t count = capture.photos.size();
    std::vector<scene::ImageSketch> sketches(count);
    std::vector<scene::ImageOutline> outlines(count);
    {
        Progress reading("sketches", count);
        scene::visitEach(count, photosTogether(capture.photos, memoryBytes), [&](std::size_t i) {
            sketches[i] = scene::sketchOf(scene::readPhoto(capture.photos[i]), shrink);
            outlines[i] = outlineOf(sketches[i].depth);
            reading.advance();
        });
    }
    std::vector<std::uint8_t> isFollower(count, 0);
    for (const std::size_t i : heldOut)
        isFollower[i] = 1;
    Progress laying("poses", sketches.front().greys.size() * static_cast<std::size_t>(options.passes));
    return layImagesOnEachOther(sketches, shrink, findPartners(outlines, kLeastShare), isFollower, options,
                                [&] { laying.advance(); });
}

} // namespace

json adjustPoses(scene::Capture& capture, const std::vector<std::size_t>& heldOut, const BuildOptions& options,
                 StageStore& store) {
    if (!options.movesPhotographs() || capture.photos.size() < 2) return nullptr;
    if (!capture.scans.empty()) {
        tell(capture, "Photographs stand where they are said to stand: beside scans they are not laid on each other.");
        return nullptr;
    }
    const std::optional<Shrink> shrink = shrinkFor(capture, options.memoryBytes / 2);
    if (!shrink) {
        tell(capture, "Photographs stand where they are said to stand: " + std::to_string(capture.photos.size()) +
                          " are too many to be laid on each other within --memory; give more.");
        return nullptr;
    }
    if (shrink->factor > shrink->wished)
        tell(capture, "Photographs are laid on each other by pictures " +
                          std::to_string(pixelsAcross(capture) / shrink->factor) + " pixels across instead of " +
                          std::to_string(pixelsAcross(capture) / shrink->wished) +
                          ", which are all that --memory holds: poses may be less exact than with more.");
    const scene::JointImagesOptions o;
    const std::string key = keyOfAdjustment(capture, heldOut, shrink->factor, o);
    const std::filesystem::path folder = store.find("poses", key, [&](const std::filesystem::path& part) {
        writeWhole(part / "poses.json",
                   describe(capture, adjust(capture, heldOut, shrink->factor, o, options.memoryBytes)).dump());
    });
    const json report = readJson(folder / "poses.json");
    for (std::size_t i = 0; i < capture.photos.size(); ++i) {
        const json& image = report.at("images").at(i);
        if (image.at("place") == "strayed")
            tell(capture, "Photograph '" + capture.photos[i].name +
                              "' stands where it was said to stand: the others do not say where it belongs.");
        if (image.at("place") == "loose")
            tell(capture, "Photograph '" + capture.photos[i].name +
                              "' stands where it was said to stand: what it has in common with others does not say "
                              "where exactly.");
        if (image.at("place") == "adjusted")
            capture.photos[i].worldFromCamera = poseOf(image.at("world_from_camera"), folder / "poses.json");
    }
    return report;
}

} // namespace app
