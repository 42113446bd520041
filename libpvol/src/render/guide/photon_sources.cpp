#include "render/guide/photon_sources.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pvol/math/parallel.h"
#include "pvol/volume/facts.h"
#include "render/guide/mixture.h"
#include "render/path/gather_light.h"
#include "render/path/lambert.h"

namespace pvol::detail {
namespace {

constexpr float kPi = float(std::numbers::pi);

[[nodiscard]] Vec3f uniform_direction(Rng& rng) {
  const auto [u, v] = rng.uniform2();
  return turn(Vec3f(0, 0, 1), 2 * u, v);
}

/// Uniform over a cap; in double: from afar it is narrower than the spacing of float directions.
[[nodiscard]] Vec3d direction_in(const Cap& cap, Rng& rng) {
  const auto [u, turns] = rng.uniform2();
  const double c = cap.one_minus_cos * double(u), sine = std::sqrt(c * (2 - c)),
               azimuth = 2 * double(kPi) * double(turns);
  Vec3d s, t;
  orthonormal_basis(cap.axis, s, t);
  return cap.axis * (1 - c) + s * (sine * std::cos(azimuth)) + t * (sine * std::sin(azimuth));
}

// A kind of light is known here by three questions: about the power that it sends to the target, a
// photon of it, in units of power, and the way to it.

double power_of(const SunLight& sun, const Target& target) {
  return double(luminance(sun.irradiance)) * target.shadow(sun.direction);
}

Photon emit(const SunLight& sun, const Target& target, double unit, Rng& rng) {
  const Vec3f d = -sun.sample([] {}, rng).direction;
  return {target.ray(d, rng), sun.irradiance * float(target.shadow(d) / unit)};
}

Vec3d way_to(const SunLight& sun, Vec3d) { return Vec3d(sun.direction); }

double power_of(const PointSource& light, const Target& target) {
  return double(luminance(light.intensity)) * target.seen_from(light.position).solid_angle();
}

Photon emit(const PointSource& light, const Target& target, double unit, Rng& rng) {
  const Cap cap = target.seen_from(light.position);
  return {{light.position, direction_in(cap, rng)},
          light.intensity * float(cap.solid_angle() / unit)};
}

Vec3d way_to(const PointSource& light, Vec3d place) { return light.position - place; }

// Of others what their middle sends: a guide needs no more.

double power_of(const BallSource& light, const Target& target) {
  return power_of(light.centre(), target);
}

Photon emit(const BallSource& light, const Target& target, double unit, Rng& rng) {
  return emit(light.centre(), target, unit, rng);
}

Vec3d way_to(const BallSource& light, Vec3d place) { return way_to(light.centre(), place); }

double power_of(const SpotSource& light, const Target& target) {
  return power_of(light.point(), target);
}

Photon emit(const SpotSource& light, const Target& target, double unit, Rng& rng) {
  Photon photon = emit(light.point(), target, unit, rng);
  photon.power *= float(light.share(photon.ray.d));
  return photon;
}

Vec3d way_to(const SpotSource& light, Vec3d place) { return way_to(light.point(), place); }

double power_of(const AreaSource& light, const Target& target) {
  return power_of(light.centre(), target);
}

Photon emit(const AreaSource& light, const Target& target, double unit, Rng& rng) {
  Photon photon = emit(light.centre(), target, unit, rng);
  photon.power *= float(std::max(0.0, dot(photon.ray.d, light.normal())));
  return photon;
}

Vec3d way_to(const AreaSource& light, Vec3d place) { return way_to(light.centre(), place); }

/// What photons are to hit: the box of the one volume, or that of the world around all.
Target make_target(const PathSetup& s) {
  if (s.is_one_still()) {
    const VolumeSetup& v = s.volumes.front();
    return {v.volume.density.octree.support(), v.cells_to_world};
  }
  Box box;
  for (const VolumeSetup& v : s.volumes) {
    for (std::size_t place = 0; place < count_places(v.volume); ++place) {
      box = join(box, world_box(v.volume.density, v.volume, place));
    }
  }
  return {box, Affine{}};
}

/// What media emit at collisions, on average over all of it.
Rgb mean_emitted(const PathSetup& s, const CoarseCells& cells) {
  Rgb sum(0.0f);
  for (const Share& of : mixture(s, cells)) {
    const Rgb e = of.component->emitted;
    sum += Rgb(std::abs(e.x), std::abs(e.y), std::abs(e.z)) * of.share;
  }
  return sum;
}

}  // namespace

PhotonSources::PhotonSources(const PathSetup& setup, const CoarseCells& cells)
    : s_(setup), cells_(cells), target_(make_target(setup)), emitted_(mean_emitted(setup, cells)) {
  for (const LightSource& source : s_.light.sources) {
    add(std::visit([&](const auto& light) { return power_of(light, target_); }, source));
  }
  add_around();
  add(component_power());
  if (has_fires()) add_fires();
}

bool PhotonSources::has_fires() const {
  return s_.emission && s_.emission->lit && s_.emission->lights.power() > 0;
}

LightAxes PhotonSources::axes() const {
  const auto is_sun = [](const LightSource& l) { return std::holds_alternative<SunLight>(l); };
  const bool is_one = std::ranges::all_of(s_.light.sources, is_sun) && !has_fires();
  LightAxes all{PagedVector<Vec3f>(is_one ? 1 : cells_.count())};
  if (is_one) {
    all.by_row[0] = axis_in(1);
  } else {
    parallel_for(1, cells_.count(), [&](std::size_t row) { all.by_row[row] = axis_in(row); });
    all.by_row[0] = all.by_row[1];
  }
  return all;
}

Vec3f PhotonSources::axis_in(std::size_t row) const {
  const Box box = cells_.world_cube(row);
  double strongest = sky_irradiance_;
  Vec3d way(bright_sky_);
  const auto propose = [&](const auto& light) {
    const double irradiance = double(luminance(light.irradiance_on(box)));
    const Vec3d towards = way_to(light, box.centre());
    if (irradiance > strongest && length(towards) > 0) strongest = irradiance, way = towards;
  };
  for (const LightSource& source : s_.light.sources) std::visit(propose, source);
  if (has_fires()) {
    const EmissionLights& fires = s_.emission->lights;
    propose(PointSource{fires.centre(), Rgb(float(fires.power()))});
  }
  return Vec3f(normalize(way));
}

Photon PhotonSources::sample(Rng& rng) const {
  const double u = double(rng.uniform()) * power();
  std::size_t i = 0;
  while (i + 1 < up_to_.size() && u >= up_to_[i]) ++i;
  const double own = up_to_[i] - (i > 0 ? up_to_[i - 1] : 0);
  Photon p = i < s_.light.sources.size()        ? from_light(s_.light.sources[i], rng)
             : i == s_.light.sources.size()     ? from_around(rng)
             : i == s_.light.sources.size() + 1 ? from_media(rng)
                                                : from_fires(rng);
  p.power *= float(power() / own);
  p.source = i;
  return p;
}

/// The sky by its own sampling and uniformly, half and half. A surface on the way to the target
/// hides it, and brings what it scatters instead: where it is at the files' time.
PhotonSources::FromAround PhotonSources::sample_around(Rng& rng) const {
  LightSample l;
  const bool own = s_.light.sky.sampled() && rng.uniform() < 0.5f;
  l.direction = own ? s_.light.sky.sample(rng).direction : uniform_direction(rng);
  constexpr float kUniform = 1 / (4 * kPi);
  l.pdf = s_.light.sky.sampled() ? 0.5f * (kUniform + s_.light.sky.pdf(l.direction)) : kUniform;
  const Ray ray = target_.ray(-l.direction, rng);
  l.radiance = s_.light.sky.radiance(l.direction);
  if (s_.surfaces) {
    const SurfaceHit hit =
        s_.surfaces->scattered->first_hit({ray.o, Vec3d(l.direction)}, kEndless, 0);
    if (hit.material != nullptr) l.radiance = seen_on(hit, rng);
  }
  const Rgb more = l.radiance - s_.constant;
  l.radiance = Rgb(std::abs(more.x), std::abs(more.y), std::abs(more.z));
  return {l, ray};
}

/// About what a surface scatters: light of the lights as if no volume were in the way, and of the
/// sky from one direction.
Rgb PhotonSources::seen_on(const SurfaceHit& surface, Rng& rng) const {
  const Lambert lobe{Vec3f(surface.normal)};
  const Vec3f up = sample_phase(lobe, {}, rng);
  const bool open = !s_.surfaces->shadow->block({surface.place, Vec3d(up)}, kEndless, 0);
  Rgb sum = open ? s_.light.sky.radiance(up) : Rgb(0.0f);
  LightCut cut;
  ask_each(s_.light, {surface.place, surface.normal}, false, cut, rng, [&](std::size_t i, float factor) {
    const LightSample l = sample_light(s_.light.sources[i], surface.place, rng);
    const float cosine = std::max(0.0f, dot(lobe.normal, l.direction));
    if (!(cosine > 0)) return;
    if (s_.surfaces->shadow->block({surface.place, Vec3d(l.direction)}, l.distance, 0)) return;
    sum += l.radiance * (cosine * factor / kPi / (l.pdf > 0 ? l.pdf : 1));
  });
  return surface.material->albedo * sum;
}

void PhotonSources::add_around() {
  constexpr int kSamples = 4096;
  constexpr std::uint64_t kKey = 0x736b79;
  double power = 0;
  Vec3d mean, net;
  for (int i = 0; i < kSamples; ++i) {
    Rng rng(kKey, 0, std::uint64_t(i));
    const LightSample l = sample_around(rng).sky;
    const double radiance = double(luminance(l.radiance)), weight = 1 / (double(l.pdf) * kSamples);
    power += radiance * weight * target_.shadow(l.direction);
    net += Vec3d(l.direction) * (radiance * weight);
    mean += Vec3d(l.direction) * (radiance * radiance * weight);  // squared: where it is brightest
  }
  add(power);
  if (length(mean) > 0) {
    bright_sky_ = Vec3f(normalize(mean));
    sky_irradiance_ = length(net);
  }
}

double PhotonSources::component_power() {
  double sum = 0;
  for (const double m : cells_.mass) mass_up_to_.push_back(sum += m);
  return 4 * double(kPi) * sum * double(luminance(emitted_));
}

Photon PhotonSources::from_light(const LightSource& source, Rng& rng) const {
  Photon p =
      std::visit([&](const auto& light) { return emit(light, target_, power(), rng); }, source);
  const bool from_afar = std::holds_alternative<SunLight>(source) && s_.surfaces;
  if (from_afar && s_.surfaces->shadow->block({p.ray.o, -p.ray.d}, kEndless, 0))
    p.power = Rgb(0.0f);
  return p;
}

Photon PhotonSources::from_around(Rng& rng) const {
  const auto [l, ray] = sample_around(rng);
  return {ray, l.radiance * float(target_.shadow(l.direction) / (double(l.pdf) * power()))};
}

Photon PhotonSources::from_media(Rng& rng) const {
  const double u = to_uniform_double(rng.block().lo) * mass_up_to_.back();
  const auto above = std::upper_bound(mass_up_to_.begin(), mass_up_to_.end() - 1, u);
  const auto row = std::uint32_t(above - mass_up_to_.begin());
  const Vec3d at = cells_.point(row, rng);
  return {{at, Vec3d(uniform_direction(rng))},
          emitted_ * float(4 * double(kPi) * mass_up_to_.back() / power())};
}

void PhotonSources::add_fires() {
  const EmissionLights& fires = s_.emission->lights;
  add(fires.power() * target_.seen_from(fires.centre()).solid_angle());
}

/// From where fires shine, as their trees have it, towards the target; without colour.
Photon PhotonSources::from_fires(Rng& rng) const {
  const Vec3d at = s_.emission->lights.sample(rng);
  const Cap cap = target_.seen_from(at);
  const Vec3d d = direction_in(cap, rng);
  const double power = s_.emission->lights.power() * cap.solid_angle();
  return {{at, d}, Rgb(float(power / this->power()))};
}

}  // namespace pvol::detail
