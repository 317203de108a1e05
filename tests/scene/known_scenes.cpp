#include "tests/scene/known_scenes.h"

#include "scene/synthetic_model.h"

#include <cmath>

#include <glm/geometric.hpp>

#include <tbb/global_control.h>

namespace scene {

namespace {

SyntheticModel bareRoomModel() {
    SyntheticModel model;
    model.name = "bare room";
    model.lightSpacing = 2.5;
    model.exposure = 1.5;
    const int wall =
        addMaterial(model, {Pattern::mottled, glm::dvec3(0.8, 0.7, 0.6), glm::dvec3(0.2, 0.3, 0.4), 0.7, 3});
    const int block =
        addMaterial(model, {Pattern::mottled, glm::dvec3(0.7, 0.3, 0.2), glm::dvec3(0.3, 0.2, 0.1), 0.3, 4});
    const glm::dvec3 x(6, 0, 0), y(0, 5, 0), z(0, 0, 3);
    addRectangle(model, {0, 0, 0}, x, y, wall);
    addRectangle(model, {0, 0, 3}, y, x, wall);
    addRectangle(model, {0, 0, 0}, y, z, wall);
    addRectangle(model, {6, 0, 0}, z, y, wall);
    addRectangle(model, {0, 0, 0}, z, x, wall);
    addRectangle(model, {0, 5, 0}, x, z, wall);
    addBox(model, Pose{}, {2.5, 2.2, 0}, {3.1, 2.7, 2}, block);
    addSphere(model, {4.4, 3.2, 1.2}, 0.4, block);
    model.lamps.push_back({{2, 1, 2.95}, {0, 3, 0}, {2, 0, 0}, glm::dvec3(3.0)});
    return model;
}

} // namespace

const SyntheticScene& bareRoom() {
    // On one thread: Embree's own use of oneTBB is compiled without the thread sanitizer, which then sees races in it.
    static const SyntheticScene room = [] {
        const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
        return SyntheticScene(bareRoomModel());
    }();
    return room;
}

Camera smallCamera() {
    return {160, 120, 130.5, 130.5, 80, 60};
}

View viewFrom(const glm::dvec3& eyeInWorld, const glm::dvec3& atInWorld, const Camera& camera) {
    const glm::dvec3 forward = glm::normalize(atInWorld - eyeInWorld);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 0, 1)));
    return {camera, {glm::dmat3(right, glm::cross(forward, right), forward), eyeInWorld}};
}

std::vector<View> viewsOfBareRoom(int count, const Camera& camera) {
    std::vector<View> views;
    for (int i = 0; i < count; ++i) {
        const double angle = 6.283185307179586 * i / count;
        const glm::dvec3 eye(3 + 2.2 * std::cos(angle), 2.5 + 1.9 * std::sin(angle), 1.5 + 0.3 * std::sin(3 * angle));
        views.push_back(viewFrom(eye, {3 - std::cos(angle), 2.5 - std::sin(angle), 1.2}, camera));
    }
    return views;
}

std::vector<DepthImage> imagesOfBareRoom(int count, const Camera& camera) {
    std::vector<DepthImage> images;
    for (const View& view : viewsOfBareRoom(count, camera)) {
        images.push_back(renderTruth(bareRoom(), view));
        images.back().name = std::to_string(images.size() - 1);
    }
    return images;
}

DepthImage imageOf(const Camera& camera, const Pose& worldFromCamera,
                   const std::function<double(double x, double y)>& disparity, Rgb8 colour) {
    DepthImage image{"flat",
                     camera,
                     worldFromCamera,
                     Image<Rgb8>(camera.width, camera.height, colour),
                     Image<float>(camera.width, camera.height),
                     Image<std::uint8_t>(camera.width, camera.height, 0)};
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x)
            image.disparity(x, y) = static_cast<float>(disparity(x + 0.5, y + 0.5));
    return image;
}

double planeDisparity(const Camera& camera, const glm::dvec3& normalInCamera, double offset, double x, double y) {
    return glm::dot(normalInCamera, rayThrough(camera, x, y)) / offset;
}

glm::dvec3 pointInWorld(const DepthImage& image, double x, double y, double disparity) {
    return image.worldFromCamera * (rayThrough(image.camera, x, y) / disparity);
}

} // namespace scene
