// Suns and points.
#include "pvol/render/lights.h"

#include <algorithm>
#include <cmath>
#include <numbers>

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

LightSample PointSource::arriving_at(Vec3d place) const {
  const Vec3d way = position - place;
  const double distance = length(way);
  const Rgb irradiance(Vec3d(intensity) / (distance * distance));
  // At the light, or nearer than sqrt(I / 3e38), a float does not hold what arrives.
  if (!(distance > 0) || !is_finite(irradiance)) return {Vec3f(0, 0, 1), Rgb(0.0f)};
  return {Vec3f(way / distance), irradiance, 0, distance};
}

Rgb PointSource::irradiance_on(const Box& box) const {
  const Vec3d way = position - box.centre(), rim = box.extent() * 0.5;
  return Rgb(Vec3d(intensity) / std::max(dot(way, way), dot(rim, rim)));
}

namespace {

/// One for each kind of light.
LightSource make_ready(const Sun& sun) { return SunLight(sun); }
LightSource make_ready(const PointLight& light) {
  return PointSource{light.position, light.intensity};
}

}  // namespace

std::vector<LightSource> make_light_sources(std::span<const Light> lights) {
  std::vector<LightSource> sources;
  for (const Light& light : lights) {
    sources.push_back(std::visit([](const auto& l) { return make_ready(l); }, light));
  }
  return sources;
}

}  // namespace pvol
