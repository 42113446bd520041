#include "pvol/render/sky_light.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pvol/render/daylight.h"

namespace pvol {

SkyLight::SkyLight(const Environment& environment) {
  if (const auto* even = std::get_if<ConstantSky>(&environment)) {
    sky_ = *even;
  } else if (const auto* gradient = std::get_if<GradientSky>(&environment)) {
    sky_ = *gradient;
    up_ = Vec3f(normalize(gradient->up));
  } else if (const auto* image = std::get_if<ImageSky>(&environment)) {
    sky_ = std::make_shared<const SkyPicture>(*image, SkyPixels::even);
  } else if (const auto* clear = std::get_if<ClearSky>(&environment)) {
    sky_ = std::make_shared<const SkyPicture>(make_daylight(*clear).picture, SkyPixels::smooth);
  }
}

SkyLight::SkyLight(SkyPicture picture)
    : sky_(std::make_shared<const SkyPicture>(std::move(picture))) {}

Rgb SkyLight::radiance(Vec3f d) const {
  struct Visitor {
    const SkyLight& sky;
    Vec3f d;
    Rgb operator()(const ConstantSky& s) const { return s.radiance; }
    Rgb operator()(const GradientSky& s) const {
      const float height = dot(d, sky.up_);
      const Rgb end = height > 0 ? s.zenith : s.ground;
      return s.horizon + (end - s.horizon) * std::min(std::abs(height), 1.0f);
    }
    Rgb operator()(const Picture& p) const { return p->radiance(d); }
  };
  return std::visit(Visitor{*this, d}, sky_);
}

}  // namespace pvol
