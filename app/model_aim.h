#pragma once
// Where an aim meets polygons that stand in the scene besides (--polygons): nobody scanned them, so nothing is measured
// with them, nor behind them through them.

#include "scene/capture/tracer.h"
#include "scene/pick.h"

#include <optional>

namespace app {

class ModelAim {
  public:
    /// Lent the polygons. Throws scene::Failure as scene::PolygonTracer does.
    explicit ModelAim(const scene::PolygonScene& polygons) : tracer_(polygons) {}

    /// The first surface on the ray, as one that was not seen. Glass is not there.
    std::optional<scene::Pick> meet(const scene::Ray& ray) const;

  private:
    scene::PolygonTracer tracer_;
};

/// Of what an aim meets of the scene and of models, the nearer.
std::optional<scene::Pick> nearer(const std::optional<scene::Pick>& ofScene, const std::optional<scene::Pick>& ofModel);

} // namespace app
