#include "pvol/render/sky_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "pvol/render/daylight.h"

namespace pvol {

SkyLight::SkyLight(const Environment& environment, ColorSpace space) {
  if (const auto* even = std::get_if<ConstantSky>(&environment)) {
    sky_ = *even;
  } else if (const auto* gradient = std::get_if<GradientSky>(&environment)) {
    sky_ = *gradient;
    up_ = Vec3f(normalize(gradient->up));
  } else if (const auto* image = std::get_if<ImageSky>(&environment)) {
    sky_ = std::make_shared<const SkyPicture>(*image, SkyPixels::even);
  } else if (const auto* clear = std::get_if<ClearSky>(&environment)) {
    sky_ =
        std::make_shared<const SkyPicture>(make_daylight(*clear, space).picture, SkyPixels::smooth);
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

/// How many a sky is divided into.
SkyLight::Patches SkyLight::patches() const {
  constexpr int kAcross = 512, kDown = 256;
  if (picture() == nullptr) return {kAcross, kDown};
  const auto multiple = [](int pixels, int least) { return pixels * ((least - 1) / pixels + 1); };
  return {multiple(picture()->width(), kAcross), multiple(picture()->height(), kDown)};
}

/// Of a place in a picture, over its size; of other skies in a picture that stands upright.
Vec3f SkyLight::direction_at(double across, double down) const {
  if (picture() != nullptr) return picture()->direction_at(across, down);
  const double azimuth = 2 * std::numbers::pi * across, theta = std::numbers::pi * down;
  const double sine = std::sin(theta);
  return Vec3f(Vec3d(sine * std::cos(azimuth), std::cos(theta), sine * std::sin(azimuth)));
}

/// Of all azimuths between two heights of a picture.
double SkyLight::solid_angle(double top, double bottom) {
  using std::numbers::pi;
  return 2 * pi * (std::cos(pi * top) - std::cos(pi * bottom));
}

}  // namespace pvol
