#include "xr/visibility_mask.h"

#include <cmath>

namespace xr {

namespace {

using Polygon = std::vector<glm::dvec2>;

/// What lies where a p + b >= 0 along one axis (Sutherland and Hodgman 1974).
Polygon clip(const Polygon& polygon, int axis, double a, double b) {
    Polygon clipped;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec2 p = polygon[i], q = polygon[(i + 1) % polygon.size()];
        const double atP = a * p[axis] + b, atQ = a * q[axis] + b;
        if (atP >= 0) clipped.push_back(p);
        if ((atP < 0) != (atQ < 0)) clipped.push_back(p + (q - p) * (atP / (atP - atQ)));
    }
    return clipped;
}

double areaOf(const Polygon& polygon) {
    double twice = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec2 p = polygon[i], q = polygon[(i + 1) % polygon.size()];
        twice += p.x * q.y - p.y * q.x;
    }
    return std::abs(twice) / 2;
}

} // namespace

double hiddenShare(const VisibilityMask& mask, const FieldOfView& field) {
    const double left = std::tan(field.left), right = std::tan(field.right);
    const double up = std::tan(field.up), down = std::tan(field.down);
    double hidden = 0;
    for (std::size_t i = 0; i + 2 < mask.indices.size(); i += 3) {
        Polygon polygon;
        for (std::size_t corner = 0; corner < 3; ++corner)
            if (mask.indices[i + corner] < mask.vertices.size())
                polygon.push_back(mask.vertices[mask.indices[i + corner]]);
        polygon = clip(polygon, 0, 1, -left);
        polygon = clip(polygon, 0, -1, right);
        polygon = clip(polygon, 1, 1, -down);
        polygon = clip(polygon, 1, -1, up);
        hidden += areaOf(polygon);
    }
    return hidden / ((right - left) * (up - down));
}

} // namespace xr
