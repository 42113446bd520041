// Suns, and lights of all kinds.
#include "pvol/render/lights.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/light/disc_on_plane.h"

namespace pvol {
namespace {

using std::numbers::pi;

/// Radius in radians below which a sun is a point: half the spacing of float directions.
constexpr double kLeastRadius = 0x1p-24;

}  // namespace

SunLight::SunLight(const Sun& sun)
    : direction(Vec3f(normalize(sun.direction))), irradiance(sun.irradiance) {
  const double radius = sun.angle / 2 * pi / 180;
  if (radius < kLeastRadius) return;
  // 1 - cos = 2 sin^2 of the half: exact for the smallest discs. The irradiance of a disc of
  // uniform radiance L on the plane that faces it is L pi sin^2(radius).
  const double half = std::sin(radius / 2), sine = std::sin(radius);
  one_minus_cos_radius = float(2 * half * half);
  disc_pdf = float(1 / (4 * pi * half * half));
  disc_radiance = irradiance * float(1 / (pi * sine * sine));
}

LightSample SunLight::sample_disc(Rng& rng) const {
  const auto [u, azimuth] = rng.uniform2();
  return {turn(direction, one_minus_cos_radius * u, azimuth), disc_radiance, disc_pdf};
}

Rgb SunLight::on_plane(Vec3d /*place*/, Vec3d normal) const {
  const double cosine = std::clamp(dot(Vec3d(direction), normal), -1.0, 1.0);
  if (disc_pdf == 0) return irradiance * float(std::max(0.0, cosine));
  const double radius = 2 * std::asin(std::sqrt(0.5 * double(one_minus_cos_radius)));
  return irradiance * float(detail::disc_on_plane(std::acos(cosine), radius));
}

namespace {

/// One for each kind of light.
LightSource make_ready(const Sun& sun) { return SunLight(sun); }
LightSource make_ready(const PointLight& light) {
  if (light.radius > 0) return BallSource(light);
  return PointSource{light.position, light.intensity};
}
LightSource make_ready(const SpotLight& light) { return SpotSource(light); }
LightSource make_ready(const AreaLight& light) { return AreaSource(light); }

}  // namespace

std::vector<LightSource> make_light_sources(std::span<const Light> lights) {
  std::vector<LightSource> sources;
  for (const Light& light : lights) {
    sources.push_back(std::visit([](const auto& l) { return make_ready(l); }, light));
  }
  return sources;
}

}  // namespace pvol
