#pragma once
// Light on polygons that looks the same from everywhere, so that images from several places agree: a sun with sharp
// shadows, a sky, what surfaces in the sun throw back once, and a fill that corners and folds get less of.
//
// The sun is asked for at every point. The rest is smooth and costs many rays, so it is found at nodes on the
// triangles, when one is first looked at, and interpolated: a node is a function of the scene alone, whoever asks and
// in whatever order. Kajiya, "The rendering equation", 1986, to the first bounce; Zhukov et al., "An ambient light
// illumination model", 1998, for the fill.
//
//        *-------*-------*        nodes of a triangle, no farther apart than spacingMetres; those on its edges are
//         \     / \     /         drawn in a little, since an edge may lie in a corner, where half of the rays would
//          \   /   \   /          start inside of the wall
//           \ /     \ /
//            *-------*

#include "scene/capture/texture_pyramid.h"
#include "scene/capture/tracer.h"

#include <atomic>
#include <memory>
#include <vector>

namespace scene {

/// Nodes do not stand closer than this share of a scene's diagonal: files in centimetres would have millions.
inline constexpr double kLeastSpacing = 0.004;

/// Linear light: a surface shows its colour times what it gets. World +Y is up.
struct CaptureLight {
    glm::dvec3 towardsSun{-0.66, 0.72, -0.22};                 ///< need not be a unit vector
    glm::vec3 sun{2.6f, 2.4f, 2.1f};                           ///< on a surface that faces it; 0: none
    glm::vec3 zenith{0.75f, 1.0f, 1.45f};                      ///< colour of the sky overhead
    glm::vec3 horizon{1.25f, 1.3f, 1.35f};                     ///< and at the horizon
    glm::vec3 ground{0.35f, 0.33f, 0.3f};                      ///< what is seen below the horizon where nothing stands
    glm::vec3 fill{0.55f, 0.54f, 0.52f};                       ///< stands for all further bounces
    double sunStrength = 1, skyStrength = 1, fillStrength = 1; ///< times the colours above
    double fillReachMetres = 0.8; ///< a surface this near takes half of the fill away; 0: the fill is even
    int rays = 128;               ///< from each node
    double spacingMetres = 0.25;  ///< between nodes; in large scenes kLeastSpacing of their diagonal
    float white = 3.5f;           ///< what is this bright is shown as white; brightness is bent on the way there
};

/// Where a surface is looked at.
struct PolygonPoint {
    glm::dvec3 position{0.0};
    glm::dvec3 flatNormal{0.0}, normal{0.0}; ///< unit, of the triangle and as the file bends it; towards the viewer
    glm::dvec3 weights{0.0};                 ///< of the triangle's corners
};

/// Lent the tracer. May be used from any number of threads. Takes some 100 bytes for each side of a triangle that was
/// looked at, more for large ones.
class SurfaceLight {
  public:
    SurfaceLight(const PolygonTracer& tracer, const CaptureLight& light);
    ~SurfaceLight();
    SurfaceLight(const SurfaceLight&) = delete;
    SurfaceLight& operator=(const SurfaceLight&) = delete;

    const CaptureLight& options() const { return light_; }
    PolygonPoint pointAt(const glm::dvec3& origin, const glm::dvec3& direction, const PolygonHit& hit) const;

    /// All light that a hit gets.
    glm::vec3 at(const PolygonHit& hit, const PolygonPoint& point) const;

    /// The surface's own colour, linear.
    glm::vec3 colourAt(const PolygonHit& hit, const PolygonPoint& point, const TextureFootprint& footprint) const;
    glm::vec2 texturePlaceAt(const PolygonHit& hit, const glm::dvec3& weights) const;

    /// Linear; direction need not be a unit vector.
    glm::vec3 skyTowards(const glm::dvec3& direction) const;

    /// Brightness bent so that `white` is 1 (Reinhard et al., "Photographic tone reproduction for digital images",
    /// 2002, eq. 4); linear still, so that means may be taken.
    glm::vec3 exposed(const glm::vec3& linear) const;

    /// Rays that were cast so far, for reports alone: how many nodes two threads find at once is chance.
    std::int64_t raysCast() const { return raysCast_.load(std::memory_order_relaxed); }

  private:
    struct Gathered {
        glm::vec3 light{0.0f};
        float trust = 0; ///< small where the node is buried in a solid that stands against its triangle
    };
    struct Node {
        std::atomic<std::uint8_t> state{0};
        Gathered gathered;
    };
    struct Nodes {
        explicit Nodes(int steps);
        int steps; ///< along each edge
        std::vector<Node> nodes;
    };
    Nodes& nodesOf(const PolygonHit& hit, const TriangleInWorld& triangle) const;
    Gathered gatheredAt(const PolygonHit& hit, const TriangleInWorld& triangle, Nodes& nodes, int i, int j) const;
    Gathered gatheredAround(const PolygonHit& hit, const TriangleInWorld& triangle, Nodes& nodes, int i, int j) const;
    Gathered gather(const PolygonPoint& point) const;
    glm::vec3 sunAt(const PolygonPoint& point) const;
    glm::dvec3 bentNormal(const PolygonHit& hit, const glm::dvec3& weights, const glm::dvec3& flatNormal) const;
    glm::vec3 meanColourOf(const PolygonHit& hit, const glm::dvec3& weights) const;

    const PolygonTracer& tracer_;
    CaptureLight light_;
    std::vector<std::unique_ptr<TexturePyramid>> textures_;
    std::vector<glm::dvec3> hemisphere_; ///< about +Z, dense as the cosine
    std::vector<std::size_t> firstTriangle_;
    mutable std::vector<std::atomic<Nodes*>>
        nodes_; ///< own; for each triangle its front and back, null until looked at
    mutable std::atomic<std::int64_t> raysCast_{0};
};

} // namespace scene
