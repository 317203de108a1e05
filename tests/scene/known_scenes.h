#pragma once
// Small scenes of known truth, cheap enough to be lit in every test, and the views and flat images that tests ask for.

#include "scene/depth_image.h"
#include "scene/image_store.h"
#include "scene/synthetic.h"

#include <functional>
#include <vector>

#include <glm/vec3.hpp>

namespace scene {

/// A room of 6 x 5 x 3 m that holds a block of 0.6 x 0.5 x 2 m and a sphere; lit once for each process.
const SyntheticScene& bareRoom();

/// 160 x 120 with 63 degrees across.
Camera smallCamera();

/// A camera at a place that looks at another, x level.
View viewFrom(const glm::dvec3& eyeInWorld, const glm::dvec3& atInWorld, const Camera& camera = smallCamera());

/// Views of the bare room, round its middle, that look across it; neighbours overlap.
std::vector<View> viewsOfBareRoom(int count, const Camera& camera = smallCamera());

/// What those views see, named "0", "1", ...
std::vector<DepthImage> imagesOfBareRoom(int count, const Camera& camera = smallCamera());

/// An image whose samples are all there, with disparity(x, y) at the sample's centre and one colour.
DepthImage imageOf(const Camera& camera, const Pose& worldFromCamera,
                   const std::function<double(double x, double y)>& disparity, Rgb8 colour = {200, 100, 50});

/// The disparity of the plane normal . p = offset, in the camera's coordinates, seen at (x, y).
double planeDisparity(const Camera& camera, const glm::dvec3& normalInCamera, double offset, double x, double y);

/// The point of the world that a sample stands for.
glm::dvec3 pointInWorld(const DepthImage& image, double x, double y, double disparity);

} // namespace scene
