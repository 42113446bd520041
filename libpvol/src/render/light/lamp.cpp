#include "render/light/lamp.h"

namespace pvol::detail {
namespace {

struct AsPoint {
  Lamp operator()(const SunLight&) const { return {}; }
  Lamp operator()(const PointSource& l) const {
    return {l.position, double(luminance(l.intensity))};
  }
  Lamp operator()(const BallSource& l) const { return (*this)(l.centre()); }
  Lamp operator()(const SpotSource& l) const { return (*this)(l.point()); }
  Lamp operator()(const AreaSource& l) const { return (*this)(l.centre()); }
};

}  // namespace

Lamp lamp_of(const LightSource& light) { return std::visit(AsPoint{}, light); }

bool camera_meets(const Light& light) {
  const auto* const point = std::get_if<PointLight>(&light);
  const auto* const area = std::get_if<AreaLight>(&light);
  return (point && point->radius > 0 && point->visible_camera) || (area && area->visible_camera);
}

}  // namespace pvol::detail
