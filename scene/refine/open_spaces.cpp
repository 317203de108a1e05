#include "scene/refine/open_spaces.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>

namespace scene {

namespace {

constexpr std::size_t kRimsShare = 2; ///< of the store's budget: one part in so many

/// Far apart, and always the same.
std::vector<std::size_t> spreadOrder(std::size_t count) {
    std::vector<std::size_t> order;
    std::size_t stride = 1;
    while (stride * stride < count)
        ++stride;
    for (std::size_t first = 0; first < stride; ++first)
        for (std::size_t i = first; i < count; i += stride)
            order.push_back(i);
    return order;
}

} // namespace

OpenSpaces::OpenSpaces(ImageStore& images, float tolerance, std::span<const double> bodies)
    : images_(images), tolerance_(tolerance) {
    std::vector<Place> places;
    std::map<std::array<double, 3>, std::size_t> placeAt;
    for (std::size_t i = 0; i < images.size(); ++i) {
        const StoredImage& image = images.at(i);
        const glm::dvec3& p = image.worldFromCamera.translation;
        const auto [entry, isNew] = placeAt.try_emplace({p.x, p.y, p.z}, places.size());
        if (isNew) places.push_back({{}, bodies[i]});
        Place& place = places[entry->second];
        place.bodyMetres = std::min(place.bodyMetres, bodies[i]);
        const glm::dmat3& rotation = image.worldFromCamera.rotation;
        auto face = std::ranges::find_if(place.faces, [&](const Face& other) {
            return other.camera == image.camera && other.worldFromFace == rotation;
        });
        if (face == place.faces.end()) face = place.faces.insert(place.faces.end(), {image.camera, rotation, {}});
        face->images.push_back(i);
    }
    for (const std::size_t i : spreadOrder(places.size()))
        places_.push_back(std::move(places[i]));
}

std::size_t OpenSpaces::bytesOfBuffers(std::span<const StoredImage> images) {
    std::size_t most = 0;
    for (const StoredImage& image : images)
        most = std::max(most, OpenSpace::Buffers::bytesOf(image.camera, Rim::marginOf(image.camera)));
    return most;
}

void OpenSpaces::forEach(const Visit& visit) {
    for (const Place& place : places_)
        if (!visitPlace(place, visit)) return;
}

bool OpenSpaces::visitPlace(const Place& place, const Visit& visit) {
    const std::vector<Face>& faces = place.faces;
    for (std::size_t first = 0, end = 0; first < faces.size(); first = end) {
        std::size_t bytes = 0;
        do
            bytes += Rim::bytesOf(faces[end++].camera);
        while (end < faces.size() && bytes + Rim::bytesOf(faces[end].camera) <= images_.budgetBytes() / kRimsShare);
        const std::vector<std::optional<Rim>> rims = rimsOf(place, first, end);
        for (std::size_t f = first; f < end; ++f)
            for (const std::size_t i : faces[f].images) {
                const ImageStore::Lease image = images_.borrow(i);
                const std::optional<Rim>& rim = rims[f - first];
                if (!visit(*image, OpenSpace(*image, rim ? &*rim : nullptr, tolerance_, place.bodyMetres, buffers_)))
                    return false;
            }
    }
    return true;
}

std::vector<std::optional<Rim>> OpenSpaces::rimsOf(const Place& place, std::size_t first, std::size_t end) {
    // By number: where two see the same ray, the one that comes first in the capture says how far it was open.
    std::map<std::size_t, std::vector<std::size_t>> facesShownBy;
    std::vector<std::optional<Rim>> rims(end - first);
    for (std::size_t f = first; f < end; ++f)
        for (const Face& other : place.faces) {
            if (!Rim::mayShow(place.faces[f].camera, place.faces[f].worldFromFace, other.camera, other.worldFromFace))
                continue;
            if (!rims[f - first]) rims[f - first].emplace(place.faces[f].camera, place.faces[f].worldFromFace);
            for (const std::size_t i : other.images)
                facesShownBy[i].push_back(f - first);
        }
    for (const auto& [number, faces] : facesShownBy) {
        const ImageStore::Lease image = images_.borrow(number);
        for (const std::size_t f : faces)
            rims[f]->take(*image);
    }
    return rims;
}

} // namespace scene
