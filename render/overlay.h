#pragma once
// What is drawn over the scene: lines and labels that stand in the world, and a rim of darkness. Tested against the
// picture's depth, so that surfaces hide them; they change colours alone, since they were not measured: depth and class
// stay those of what is behind them.

#include "scene/image.h"

#include <string>
#include <vector>

#include <glm/vec3.hpp>

namespace render {

/// A straight line between two points of the world, of one width on the screen, with round ends.
struct Segment {
    glm::dvec3 a{0}, b{0}; ///< metres, world
    scene::Rgb8 colour;
    float widthPixels = 2;
    float opacity = 1;    ///< 0 to 1
    float whenHidden = 0; ///< the share of it that shows through surfaces before it
};

/// One line of text that faces the eye and stands centred above a point of the world, at that point's depth. ASCII;
/// anything else is shown as '?'.
struct Label {
    glm::dvec3 at{0}; ///< metres, world
    std::string text;
    scene::Rgb8 colour;
    float heightRadians = 0.015f; ///< of a capital letter, as the eye sees it
    float heightPixels = 0;       ///< if positive, instead
    float whenHidden = 0.4f;      ///< as Segment's
};

/// What crosses on the screen is shown nearest on top; at one depth, in the order of the list, labels last.
struct Overlay {
    std::vector<Segment> segments;
    std::vector<Label> labels;
    /// 0 to 1: how far the darkness has come in from the rim. Narrows the view in motion, which keeps some people from
    /// feeling sick.
    float vignette = 0;

    bool empty() const { return segments.empty() && labels.empty() && !(vignette > 0); }
};

} // namespace render
