#include "render/guide/photon_sources.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pvol::detail {
namespace {

constexpr float kPi = float(std::numbers::pi);

[[nodiscard]] Vec3f uniform_direction(Rng& rng) {
  const auto [u, v] = rng.uniform2();
  return turn(Vec3f(0, 0, 1), 2 * u, v);
}

/// What a light sends to the target: about its power, and the direction that it lies in.
struct Beam {
  double power = 0;
  Vec3f axis;            ///< unit, towards the light
  bool has_axis = true;  ///< false: it comes from more than half of all directions
};

// A kind of light is known here by two questions: its beam, and a photon of it, in units of power.

Beam beam(const SunLight& sun, const Target& target) {
  return {double(luminance(sun.irradiance)) * target.shadow(sun.direction), sun.direction};
}

Photon emit(const SunLight& sun, const Target& target, double unit, Rng& rng) {
  const Vec3f d = -sun.sample([] {}, rng).direction;
  return {target.ray(d, rng), sun.irradiance * float(target.shadow(d) / unit)};
}

Beam beam(const PointSource& light, const Target& target) {
  const Cap cap = target.seen_from(light.position);
  return {double(luminance(light.intensity)) * cap.solid_angle(), Vec3f(-cap.axis),
          cap.one_minus_cos < 1};
}

Photon emit(const PointSource& light, const Target& target, double unit, Rng& rng) {
  const Cap cap = target.seen_from(light.position);
  const auto [u, turns] = rng.uniform2();
  // In double: from afar the cap is narrower than the spacing of float directions.
  const double c = cap.one_minus_cos * double(u), sine = std::sqrt(c * (2 - c)),
               azimuth = 2 * double(kPi) * double(turns);
  Vec3d s, t;
  orthonormal_basis(cap.axis, s, t);
  const Vec3d d =
      cap.axis * (1 - c) + s * (sine * std::cos(azimuth)) + t * (sine * std::sin(azimuth));
  return {{light.position, d}, light.intensity * float(cap.solid_angle() / unit)};
}

}  // namespace

PhotonSources::PhotonSources(const PathSetup& setup, const CoarseCells& cells)
    : s_(setup), cells_(cells), target_(setup.volumes.front().volume) {
  double strongest = 0;
  for (const LightSource& source : s_.lights) {
    const Beam b = std::visit([&](const auto& light) { return beam(light, target_); }, source);
    add(b.power);
    if (b.has_axis) propose_axis(b.power, b.axis, strongest);
  }
  add_sky(strongest);
  add(matter_power());
}

Photon PhotonSources::sample(Rng& rng) const {
  const double u = double(rng.uniform()) * power();
  std::size_t i = 0;
  while (i + 1 < up_to_.size() && u >= up_to_[i]) ++i;
  const double own = up_to_[i] - (i > 0 ? up_to_[i - 1] : 0);
  Photon p = i < s_.lights.size()    ? from_light(s_.lights[i], rng)
             : i == s_.lights.size() ? from_sky(rng)
                                     : from_matter(rng);
  p.power *= float(power() / own);
  p.source = i;
  return p;
}

/// The sky by its own sampling and uniformly, half and half.
LightSample PhotonSources::sample_sky(Rng& rng) const {
  LightSample l;
  const bool own = s_.sky.sampled() && rng.uniform() < 0.5f;
  l.direction = own ? s_.sky.sample(rng).direction : uniform_direction(rng);
  constexpr float kUniform = 1 / (4 * kPi);
  l.pdf = s_.sky.sampled() ? 0.5f * (kUniform + s_.sky.pdf(l.direction)) : kUniform;
  const Rgb more = s_.sky.radiance(l.direction) - s_.constant;
  l.radiance = Rgb(std::abs(more.x), std::abs(more.y), std::abs(more.z));
  return l;
}

void PhotonSources::add_sky(double& strongest) {
  constexpr int kSamples = 4096;
  constexpr std::uint64_t kKey = 0x736b79;
  double power = 0;
  Vec3d mean;
  for (int i = 0; i < kSamples; ++i) {
    Rng rng(kKey, 0, std::uint64_t(i));
    const LightSample l = sample_sky(rng);
    const double radiance = double(luminance(l.radiance)), weight = 1 / (double(l.pdf) * kSamples);
    power += radiance * weight * target_.shadow(l.direction);
    mean += Vec3d(l.direction) * (radiance * radiance * weight);  // squared: where it is brightest
  }
  add(power);
  if (length(mean) > 0) propose_axis(power, Vec3f(normalize(mean)), strongest);
}

Rgb PhotonSources::emitted() const {
  Rgb sum(0.0f);
  float before = 0;
  for (const Matter& m : s_.volumes.front().matter) {
    const Rgb e = m.emitted;
    sum += Rgb(std::abs(e.x), std::abs(e.y), std::abs(e.z)) * (m.share_up_to - before);
    before = m.share_up_to;
  }
  return sum;
}

double PhotonSources::matter_power() {
  double sum = 0;
  for (const double m : cells_.mass) mass_up_to_.push_back(sum += m);
  return 4 * double(kPi) * sum * double(luminance(emitted()));
}

Photon PhotonSources::from_light(const LightSource& source, Rng& rng) const {
  return std::visit([&](const auto& light) { return emit(light, target_, power(), rng); }, source);
}

Photon PhotonSources::from_sky(Rng& rng) const {
  const LightSample l = sample_sky(rng);
  const Vec3f d = -l.direction;
  return {target_.ray(d, rng), l.radiance * float(target_.shadow(d) / (double(l.pdf) * power()))};
}

Photon PhotonSources::from_matter(Rng& rng) const {
  const double u = to_uniform_double(rng.block().lo) * mass_up_to_.back();
  const auto above = std::upper_bound(mass_up_to_.begin(), mass_up_to_.end() - 1, u);
  const auto row = std::uint32_t(above - mass_up_to_.begin());
  const Vec3d at = target_.point(cells_, row, rng);
  return {{at, Vec3d(uniform_direction(rng))},
          emitted() * float(4 * double(kPi) * mass_up_to_.back() / power())};
}

}  // namespace pvol::detail
