#include "app/selection.h"

#include "scene/import/scan_photos.h"

#include <algorithm>
#include <array>
#include <map>

#include <glm/geometric.hpp>

namespace app {

namespace {

constexpr double kSecondsAhead = 1;
constexpr int kStepsAhead = 4;              ///< on the way there, at which is asked what is drawn
constexpr double kFastestMetresASecond = 5; ///< who moves faster was put somewhere else

/// How many images each position has.
std::vector<std::size_t> countsOf(const ReferencePositions& reference) {
    std::vector<std::size_t> counts(reference.places.size(), 0);
    for (const std::uint32_t position : reference.positionOf)
        ++counts[position];
    return counts;
}

} // namespace

ReferencePositions referencePositionsOf(std::span<const scene::SceneImage> images) {
    ReferencePositions exactly;
    std::map<std::array<double, 3>, std::uint32_t> known;
    for (const scene::SceneImage& image : images) {
        const glm::dvec3& place = image.worldFromCamera.translation;
        const auto [found, isNew] = known.try_emplace({place.x, place.y, place.z}, exactly.places.size());
        if (isNew) exactly.places.push_back(place);
        exactly.positionOf.push_back(found->second);
    }
    const std::vector<std::size_t> counts = countsOf(exactly);
    std::vector<std::size_t> lookAllRound, joins(counts.size());
    for (std::size_t i = 0; i < counts.size(); ++i)
        if (counts[i] >= kImagesPerPosition) lookAllRound.push_back(i);
    for (std::size_t i = 0; i < joins.size(); ++i) {
        joins[i] = i;
        if (counts[i] >= kImagesPerPosition) continue;
        double nearest = scene::kBesideMetres;
        for (const std::size_t k : lookAllRound)
            if (const double metres = glm::distance(exactly.places[i], exactly.places[k]); metres <= nearest)
                joins[i] = k, nearest = metres;
    }
    ReferencePositions reference;
    std::vector<std::uint32_t> place(joins.size());
    for (std::size_t i = 0; i < joins.size(); ++i)
        if (joins[i] == i) {
            place[i] = static_cast<std::uint32_t>(reference.places.size());
            reference.places.push_back(exactly.places[i]);
        }
    for (const std::uint32_t position : exactly.positionOf)
        reference.positionOf.push_back(place[joins[position]]);
    return reference;
}

Selection::Selection(const scene::Scene& scene) {
    if (!scene.hasWholeImages) return;
    reference_ = referencePositionsOf(scene.images);
    const std::vector<std::size_t> counts = countsOf(reference_);
    if (counts.empty() || *std::min_element(counts.begin(), counts.end()) < kImagesPerPosition) return;
    cells_ = scene::WalkCells(reference_.places);
}

void Selection::raiseTo(const glm::dvec3& place, std::uint32_t& cell, std::vector<float>& shares) {
    cells_.sharesAt(place, cell, found_);
    for (const scene::PositionShare& found : found_)
        shares[found.position] = std::max(shares[found.position], found.share);
}

glm::dvec3 Selection::aheadOf(const glm::dvec3& head, std::optional<double> seconds) {
    const glm::dvec3 moved = head - lastHead_;
    const double passed = seconds && lastSeconds_ ? *seconds - *lastSeconds_ : 0;
    lastHead_ = head, lastSeconds_ = seconds;
    if (!(passed > 0) || glm::length(moved) > kFastestMetresASecond * passed) return glm::dvec3(0);
    return kSecondsAhead / passed * moved;
}

render::ImageShares Selection::choose(std::span<const scene::View> eyes, const render::Quality& quality,
                                      std::optional<double> seconds) {
    ofPositions_.clear();
    if (!hasCells() || !quality.walksByCells) return {};
    // Of the head and not of each eye: both see the same images.
    glm::dvec3 head(0);
    for (const scene::View& eye : eyes)
        head += eye.worldFromEye.translation / static_cast<double>(eyes.size());
    const auto toImages = [&](std::vector<float>& shares) {
        shares.resize(reference_.positionOf.size());
        for (std::size_t i = 0; i < shares.size(); ++i)
            shares[i] = ofPositions_[reference_.positionOf[i]];
    };
    ofPositions_.assign(reference_.places.size(), 0.0f);
    raiseTo(head, cell_, ofPositions_);
    toImages(now_);
    const glm::dvec3 ahead = aheadOf(head, seconds);
    const std::vector<float> drawn = ofPositions_;
    cellAhead_ = cell_;
    for (int i = 1; i <= kStepsAhead; ++i)
        raiseTo(head + static_cast<double>(i) / kStepsAhead * ahead, cellAhead_, ofPositions_);
    toImages(soon_);
    ofPositions_ = drawn;
    return {now_, soon_};
}

} // namespace app
