#include "app/model_aim.h"

#include <glm/geometric.hpp>

namespace app {

std::optional<scene::Pick> ModelAim::meet(const scene::Ray& ray) const {
    const glm::dvec3 direction = glm::normalize(ray.direction);
    const std::optional<scene::PolygonHit> hit = tracer_.cast(ray.originInWorld, direction);
    if (!hit) return std::nullopt;
    scene::Pick pick;
    pick.position = ray.originInWorld + hit->t * direction;
    pick.distanceMetres = hit->t;
    pick.isSeen = false;
    const glm::dvec3 across = tracer_.triangleOf(*hit).across;
    if (glm::length(across) > 0) pick.normal = glm::normalize(hit->isBack ? -across : across);
    return pick;
}

std::optional<scene::Pick> nearer(const std::optional<scene::Pick>& ofScene,
                                  const std::optional<scene::Pick>& ofModel) {
    if (!ofScene || !ofModel) return ofScene ? ofScene : ofModel;
    return ofModel->distanceMetres < ofScene->distanceMetres ? ofModel : ofScene;
}

} // namespace app
