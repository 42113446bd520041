#include "render/light/sky/scattered_light.h"

#include <cmath>
#include <cstdlib>
#include <span>

#include "pvol/math/parallel.h"
#include "render/light/sky/angles.h"

namespace pvol::detail {
namespace {

/// Angles of the sun in degrees around that of the place, closer where it is near the horizon:
/// light of a layer reaches no farther.
constexpr auto kLowSuns =
    std::to_array<double>({-16, -10, -6.5, -4, -2.5, -1.4, -0.6, 0, 0.6, 1.4, 2.5, 4, 6.5, 10, 16});
constexpr auto kHighSuns = std::to_array<double>({-14, -7, -2.5, 0, 2.5, 7, 14});
constexpr double kHigh = 70 * kPi / 180;

// Directions in which light is collected: Gauss's rule in the cosine above and below the horizon,
// even azimuths of one half, for the other is its mirror image.
constexpr int kCosines = 6, kHalf = 6, kRays = 2 * kCosines * kHalf;
constexpr std::array<double, 3> kNodes{0.2386191860831969, 0.6612093864662645, 0.9324695142031521};
constexpr std::array<double, 3> kWeights{0.4679139345726910, 0.3607615730481386,
                                         0.1713244923791704};

struct Ray {
  double cosine, cos_azimuth;
  Vec3d direction;  // x towards the sun, z up
  double weight;    // steradians, of it and of its mirror image together
};

std::array<Ray, kRays> make_rays() {
  std::array<Ray, kRays> rays;
  for (int i = 0; i < 2 * kCosines; ++i) {
    const int j = i % kCosines, k = j % 3;
    const double node = (1 + (j < 3 ? kNodes[std::size_t(k)] : -kNodes[std::size_t(k)])) / 2;
    const double cosine = i < kCosines ? node : -node, sine = std::sqrt(1 - cosine * cosine);
    for (int m = 0; m < kHalf; ++m) {
      const double azimuth = kPi * (m + 0.5) / kHalf;
      rays[std::size_t(i * kHalf + m)] = {
          cosine,
          std::cos(azimuth),
          {sine * std::cos(azimuth), sine * std::sin(azimuth), cosine},
          kWeights[std::size_t(k)] / 2 * 2 * kPi / kHalf};
    }
  }
  return rays;
}
const std::array<Ray, kRays>& rays() {
  static const std::array<Ray, kRays> all = make_rays();
  return all;
}

/// Of each direction of an Incident, the weights of the rays, which sum up to 1.
std::vector<float> make_kernel(const Atmosphere& a) {
  std::vector<float> kernel;
  for (int i = 0; i < Incident::kAngles; ++i) {
    for (int j = 0; j < Incident::kAzimuths; ++j) {
      const double angle = kPi * i / (Incident::kAngles - 1);
      const double azimuth = kPi * j / (Incident::kAzimuths - 1);
      const Vec3d d(std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth),
                    std::cos(angle));
      double sum = 0;
      const std::size_t first = kernel.size();
      for (const Ray& r : rays()) {
        const Vec3d mirrored(r.direction.x, -r.direction.y, r.direction.z);
        const double weight = r.weight / 2 *
                              (double(phase_of_aerosols(a, float(dot(d, r.direction)))) +
                               double(phase_of_aerosols(a, float(dot(d, mirrored)))));
        sum += weight;
        kernel.push_back(float(weight));
      }
      for (std::size_t k = first; k < kernel.size(); ++k) kernel[k] /= float(sum);
    }
  }
  return kernel;
}

/// What a ray sees of light that arrives at its places, `arriving` at an AirPlace over what
/// scatters it; and the transmittance of all of it.
struct Gathered {
  ByMatter sum{};
  Spectrum through{1.0f};
  AirPlace end;
};
template <class Arriving>
Gathered gather(const AirPath& path, const AirRay& ray, const Arriving& arriving) {
  Gathered g{.end = ray.start()};
  ByMatter before = arriving(g.end);
  for (const AirStep& step : path.steps) {
    g.end = ray.at(step.to, step.t);
    const ByMatter after = arriving(g.end);
    const auto add = [&](Spectrum ByMatter::*part) {
      g.sum.*part +=
          g.through * (before.*part * (step.near.*part) + after.*part * (step.far.*part));
    };
    add(&ByMatter::molecules);
    add(&ByMatter::aerosols);
    g.through *= step.transmittance;
    before = after;
  }
  return g;
}

Spectrum trace(const Incident& i) { return i.xx + i.yy + i.zz; }

void add(Incident& to, const Incident& b, const Spectrum& factor) {
  to.xx += b.xx * factor, to.yy += b.yy * factor, to.zz += b.zz * factor, to.xz += b.xz * factor;
  to.down += b.down * factor, to.up += b.up * factor;
  for (std::size_t i = 0; i < to.by_aerosols.size(); ++i) {
    to.by_aerosols[i] += b.by_aerosols[i] * factor;
  }
}

}  // namespace

MomentFactors scattered_towards(double x, double z) {
  constexpr double kUnit = 3 / (16 * kPi);
  const double y2 = 1 - x * x - z * z;
  return {float(kUnit * (1 + x * x)), float(kUnit * (1 + y2)), float(kUnit * (1 + z * z)),
          float(kUnit * 2 * x * z)};
}

ScatteredLight::ScatteredLight(const Atmosphere& a, double sun_angle)
    : air_(a), at_(sun_angle), beam_(a), kernel_(make_kernel(a)) {
  const std::span<const double> offsets =
      sun_angle < kHigh ? std::span<const double>(kHighSuns) : kLowSuns;
  for (const double offset : offsets) {
    const double angle = sun_angle + offset * kPi / 180;
    if (angle >= 0 && angle <= kPi) suns_.push_back(angle);
  }
  for (int level = 0; level <= kTop; ++level) {
    for (std::size_t r = 0; r < kRays; r += kHalf) {
      paths_.push_back(make_path(a, level, rays()[r].cosine));
    }
  }
  last_.resize(suns_.size() * kLevels.size());
  all_ = last_;
  sum_up();
}

ScatteredLight::Mix ScatteredLight::mix(double sun_angle) const {
  std::size_t i = 0;
  while (i + 2 < suns_.size() && sun_angle >= suns_[i + 1]) ++i;
  const double u = (sun_angle - suns_[i]) / (suns_[i + 1] - suns_[i]);
  return {i, float(std::fmin(std::fmax(u, 0), 1))};
}

/// Of light straight from the sun, over its irradiance above the air.
ByMatter ScatteredLight::direct(const AirPlace& p, double to_sun) const {
  const Spectrum arrived = beam_.at(p.level, p.sun_angle);
  return {arrived * phase_of_molecules(float(to_sun)),
          arrived * phase_of_aerosols(air_, float(to_sun))};
}

/// Of scattered light: of its second moments for molecules, of the table for aerosols.
ByMatter ScatteredLight::diffuse(const std::vector<Incident>& light, const AirPlace& p) const {
  const double z = p.cosine, x = std::sqrt(1 - z * z) * p.cos_azimuth;
  const MomentFactors to = scattered_towards(x, z);
  const double angle = arc_cosine(z) / kPi * (Incident::kAngles - 1);
  const double azimuth = arc_cosine(p.cos_azimuth) / kPi * (Incident::kAzimuths - 1);
  const int i = std::min(int(angle), Incident::kAngles - 2);
  const int j = std::min(int(azimuth), Incident::kAzimuths - 2);
  const float u = float(angle - i), v = float(azimuth - j);
  const auto cell = std::size_t(i * Incident::kAzimuths + j);
  const Mix m = mix(p.sun_angle);
  Spectrum molecules, aerosols;
  for (const int side : {0, 1}) {
    const float share = side == 0 ? 1 - m.u : m.u;
    const Incident& n = light[node(m.at + std::size_t(side), p.level)];
    molecules.add(n.xx, share * to.xx).add(n.yy, share * to.yy);
    molecules.add(n.zz, share * to.zz).add(n.xz, share * to.xz);
    aerosols.add(n.by_aerosols[cell], share * (1 - u) * (1 - v));
    aerosols.add(n.by_aerosols[cell + 1], share * (1 - u) * v);
    aerosols.add(n.by_aerosols[cell + Incident::kAzimuths], share * u * (1 - v));
    aerosols.add(n.by_aerosols[cell + Incident::kAzimuths + 1], share * u * v);
  }
  return {molecules, aerosols};
}

/// Radiance of the ground where the sun is at this angle, by light straight from it or of the last
/// order.
Spectrum ScatteredLight::from_ground(double sun_angle, bool first) const {
  const Spectrum matt = air_.ground * float(1 / kPi);
  if (first) return beam_.at(0, sun_angle) * matt * std::max(float(std::cos(sun_angle)), 0.0f);
  const Mix m = mix(sun_angle);
  Spectrum lit = last_[node(m.at, 0)].down * (1 - m.u);
  return lit.add(last_[node(m.at + 1, 0)].down, m.u) * matt;
}

Spectrum ScatteredLight::radiance(const AirPath& path, const AirPlace& from, bool first) const {
  const AirRay ray(air_, from);
  const double to_sun = ray.to_sun();
  const Gathered g = first
                         ? gather(path, ray, [&](const AirPlace& p) { return direct(p, to_sun); })
                         : gather(path, ray, [&](const AirPlace& p) { return diffuse(last_, p); });
  const Spectrum air = g.sum.molecules + g.sum.aerosols;
  return path.grounded ? air + g.through * from_ground(g.end.sun_angle, first) : air;
}

/// What arrives at a node by one scattering more.
void ScatteredLight::collect(std::size_t sun, int level, bool first, Incident& to) const {
  std::array<Spectrum, kRays> arrived;
  for (std::size_t r = 0; r < kRays; ++r) {
    const Ray& ray = rays()[r];
    const AirPath& path = paths_[std::size_t(level) * 2 * kCosines + r / kHalf];
    arrived[r] = radiance(path, {level, suns_[sun], ray.cosine, ray.cos_azimuth}, first);
    const Vec3d d = ray.direction;
    const Spectrum light = arrived[r] * float(ray.weight);
    to.xx.add(light, float(d.x * d.x)), to.yy.add(light, float(d.y * d.y));
    to.zz.add(light, float(d.z * d.z)), to.xz.add(light, float(d.x * d.z));
    (d.z > 0 ? to.down : to.up).add(light, float(std::abs(d.z)));
  }
  for (std::size_t i = 0; i < to.by_aerosols.size(); ++i) {
    for (std::size_t r = 0; r < kRays; ++r) {
      to.by_aerosols[i].add(arrived[r], kernel_[i * kRays + r]);
    }
  }
}

void ScatteredLight::follow_order(bool first) {
  std::vector<Incident> next(last_.size());
  parallel_for(0, next.size(), [&](std::size_t i) {
    collect(i / kLevels.size(), int(i % kLevels.size()), first, next[i]);
  });
  last_ = std::move(next);
}

/// Follows orders until what is left, taken for a geometric series band by band, hardly changes
/// from order to order; then adds it.
void ScatteredLight::sum_up() {
  constexpr int kLeast = 4, kMost = 40;
  constexpr float kChange = 2e-3f;  // of all light
  const auto amount = [&](const std::vector<Incident>& light) {
    Spectrum sum;
    for (std::size_t i = 0; i < light.size(); ++i) {
      sum.add(trace(light[i]), amounts_at(air_, kLevels[i % kLevels.size()]).molecules);
    }
    return sum;
  };
  Spectrum before, tail;  // of the last order, and what follows it over that
  for (bool more = true; more && orders_ < kMost; ++orders_) {
    follow_order(orders_ == 0);
    for (std::size_t i = 0; i < all_.size(); ++i) add(all_[i], last_[i], Spectrum(1.0f));
    const Spectrum now = amount(last_), sum = amount(all_);
    more = orders_ + 1 < kLeast;
    for (int b = 0; b < kBands; ++b) {
      const float ratio = before[b] > 0 ? std::min(now[b] / before[b], 0.98f) : 0.0f;
      const float left = now[b] * ratio / (1 - ratio), expected = before[b] * tail[b] - now[b];
      more = more || std::abs(left - expected) > kChange * sum[b];
      tail[b] = ratio / (1 - ratio);
    }
    before = now;
  }
  for (std::size_t i = 0; i < all_.size(); ++i) add(all_[i], last_[i], tail);
}

std::vector<SkyLightParts> ScatteredLight::seen(double angle,
                                                std::span<const double> azimuths) const {
  const double cosine = std::max(std::cos(angle), 0.0);
  const AirPath path = make_path(air_, 0, cosine);
  std::vector<SkyLightParts> all;
  for (const double azimuth : azimuths) {
    const AirRay ray(air_, {0, at_, cosine, std::cos(azimuth)});
    const ByMatter once = gather(path, ray, [&](const AirPlace& p) {
                            const Spectrum arrived = beam_.at(p.level, p.sun_angle);
                            return ByMatter{arrived, arrived};
                          }).sum;
    const ByMatter more =
        gather(path, ray, [&](const AirPlace& p) { return diffuse(all_, p); }).sum;
    all.push_back({once.molecules, once.aerosols, more.molecules + more.aerosols});
  }
  return all;
}

Spectrum ScatteredLight::net_flux(int level) const {
  const Mix m = mix(at_);
  const auto at = [&](std::size_t sun) {
    const Incident& i = all_[node(sun, level)];
    return i.down - i.up;
  };
  return at(m.at) * (1 - m.u) + at(m.at + 1) * m.u;
}

}  // namespace pvol::detail
