#include "render/light/lamp.h"

#include <algorithm>

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

Lamps::Lamps(std::span<const LightSource> lights) {
  for (const LightSource& light : lights) all.push_back(lamp_of(light));
  if (std::ranges::none_of(all, [](const Lamp& l) { return l.power > 0; })) return;
  const double most = std::ranges::max(all, {}, &Lamp::power).power;
  for (const Lamp& l : all) {
    x.push_back(l.position.x), y.push_back(l.position.y), z.push_back(l.position.z);
    // A lamp, however faint, is drawn at times.
    power.push_back(l.power > 0 ? std::max(float(l.power / most), 1e-20f) : 0);
  }
}

bool camera_meets(const Light& light) {
  const auto* const point = std::get_if<PointLight>(&light);
  const auto* const area = std::get_if<AreaLight>(&light);
  return (point && point->radius > 0 && point->visible_camera) || (area && area->visible_camera);
}

}  // namespace pvol::detail
