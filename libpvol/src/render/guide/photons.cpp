// Based on: Arvo. Backward Ray Tracing. 1986 (light from the sources); Wagner, Haghighat. Automated
// Variance Reduction of Monte Carlo Shielding Calculations Using the Discrete Ordinates Adjoint
// Function. 1998 (importance from the other end). What is estimated here only steers paths.
#include "render/guide/photons.h"

#include <atomic>
#include <cmath>
#include <numbers>

#include "math/parallel.h"
#include "render/path/gather_light.h"
#include "render/path/traversal.h"

namespace pvol::detail {
namespace {

constexpr float kPi = float(std::numbers::pi);

[[nodiscard]] Vec3f uniform_direction(Rng& rng) {
  const auto [u, v] = rng.uniform2();
  return turn(Vec3f(0, 0, 1), 2 * u, v);
}

/// A photon about to fly: its ray in the world and its power.
struct Photon {
  Ray ray;
  Rgb power{0.0f};
  std::size_t source = 0;  ///< number of its light; larger ones are the sky and matter
};

/// Directions around an axis.
struct Cap {
  Vec3d axis;  ///< unit
  double one_minus_cos;

  [[nodiscard]] double solid_angle() const { return 2 * double(kPi) * one_minus_cos; }
};

/// The box of the support as lights see it.
class Target {
 public:
  explicit Target(const Volume& volume) : to_world_(inverse(volume.density.world_to_cells)) {
    const Box box = volume.density.octree.support();
    low_ = to_world_.point(box.lo);
    for (int axis = 0; axis < 3; ++axis) {
      Vec3d step;
      step[axis] = box.extent()[axis];
      edges_[axis] = to_world_.vector(step);
    }
    for (int axis = 0; axis < 3; ++axis) {
      faces_[axis] = cross(edges_[(axis + 1) % 3], edges_[(axis + 2) % 3]);
    }
  }

  /// Area of the box's shadow on a plane across the direction.
  [[nodiscard]] double shadow(Vec3f d) const {
    double sum = 0;
    for (const Vec3d& face : faces_) sum += std::abs(dot(face, Vec3d(d)));
    return sum;
  }

  /// A ray along d, with its origin where it enters the box, uniform over the shadow.
  [[nodiscard]] Ray ray(Vec3f d, Rng& rng) const {
    const auto [u, v] = rng.uniform2();
    double left = double(rng.uniform()) * shadow(d);
    int axis = 0;
    while (axis < 2 && left >= std::abs(dot(faces_[axis], Vec3d(d)))) {
      left -= std::abs(dot(faces_[axis], Vec3d(d)));
      ++axis;
    }
    // The light comes in through the face whose inward normal points along it.
    const bool far = dot(faces_[axis], Vec3d(d)) * dot(faces_[axis], edges_[axis]) < 0;
    const Vec3d entry = low_ + edges_[axis] * (far ? 1 : 0) + edges_[(axis + 1) % 3] * double(u) +
                        edges_[(axis + 2) % 3] * double(v);
    return {entry, Vec3d(d)};
  }

  /// Around all directions in which the box lies from a place; all that there are, near it.
  [[nodiscard]] Cap seen_from(Vec3d place) const {
    const Vec3d diagonal = edges_[0] + edges_[1] + edges_[2], way = low_ + diagonal * 0.5 - place;
    double squared_radius = 0;  // of a sphere around the box, which need not have right angles
    for (const double y : {-1.0, 1.0}) {
      for (const double z : {-1.0, 1.0}) {
        const Vec3d half = (edges_[0] + edges_[1] * y + edges_[2] * z) * 0.5;
        squared_radius = std::max(squared_radius, dot(half, half));
      }
    }
    const double squared_sine = squared_radius / dot(way, way);
    if (!(squared_sine < 1)) return {{0, 1, 0}, 2};
    return {normalize(way), squared_sine / (1 + std::sqrt(1 - squared_sine))};
  }

  /// A point uniform in a coarse cell.
  [[nodiscard]] Vec3d point(const CoarseCells& cells, std::uint32_t row, Rng& rng) const {
    const auto [u, v] = rng.uniform2();
    const Vec3d within(double(u), double(v), double(rng.uniform()));
    const Vec3d place(cells.places[row] + vec3(cells.low));
    return to_world_.point((place + within) * std::ldexp(1.0, cells.shift));
  }

 private:
  Affine to_world_;
  Vec3d low_;
  std::array<Vec3d, 3> edges_, faces_;
};

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

/// The lights of the scene less its constant, to draw photons from in proportion to their power.
class Sources {
 public:
  Sources(const PathSetup& setup, const CoarseCells& cells)
      : s_(setup), cells_(cells), target_(setup.volumes.front().volume) {
    double sum = 0;
    const auto add = [&](double power) { up_to_.push_back(sum += power); };
    double strongest = 0;
    const auto propose_axis = [&](double power, Vec3f axis) {
      if (power > strongest) strongest = power, axis_ = axis;
    };
    for (const LightSource& source : s_.lights) {
      const Beam b = std::visit([&](const auto& light) { return beam(light, target_); }, source);
      add(b.power);
      if (b.has_axis) propose_axis(b.power, b.axis);
    }
    add_sky(add, propose_axis);
    add(matter_power());
  }

  [[nodiscard]] double power() const { return up_to_.back(); }
  [[nodiscard]] Vec3f axis() const { return axis_; }

  /// A photon, whose luminance is 1 on average, a share of power(): in units of the world powers
  /// may be beyond what a float holds.
  [[nodiscard]] Photon sample(Rng& rng) const {
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

 private:
  /// The sky by its own sampling and uniformly, half and half.
  [[nodiscard]] LightSample sample_sky(Rng& rng) const {
    LightSample l;
    const bool own = s_.sky.sampled() && rng.uniform() < 0.5f;
    l.direction = own ? s_.sky.sample(rng).direction : uniform_direction(rng);
    constexpr float kUniform = 1 / (4 * kPi);
    l.pdf = s_.sky.sampled() ? 0.5f * (kUniform + s_.sky.pdf(l.direction)) : kUniform;
    const Rgb more = s_.sky.radiance(l.direction) - s_.constant;
    l.radiance = Rgb(std::abs(more.x), std::abs(more.y), std::abs(more.z));
    return l;
  }

  template <class Add, class ProposeAxis>
  void add_sky(const Add& add, const ProposeAxis& propose_axis) {
    constexpr int kSamples = 4096;
    constexpr std::uint64_t kKey = 0x736b79;
    double power = 0;
    Vec3d mean;
    for (int i = 0; i < kSamples; ++i) {
      Rng rng(kKey, 0, std::uint64_t(i));
      const LightSample l = sample_sky(rng);
      const double radiance = double(luminance(l.radiance)),
                   weight = 1 / (double(l.pdf) * kSamples);
      power += radiance * weight * target_.shadow(l.direction);
      mean +=
          Vec3d(l.direction) * (radiance * radiance * weight);  // squared: where it is brightest
    }
    add(power);
    if (length(mean) > 0) propose_axis(power, Vec3f(normalize(mean)));
  }

  [[nodiscard]] Rgb emitted() const {
    Rgb sum(0.0f);
    float before = 0;
    for (const Matter& m : s_.volumes.front().matter) {
      const Rgb e = m.emitted;
      sum += Rgb(std::abs(e.x), std::abs(e.y), std::abs(e.z)) * (m.share_up_to - before);
      before = m.share_up_to;
    }
    return sum;
  }

  [[nodiscard]] double matter_power() {
    double sum = 0;
    for (const double m : cells_.mass) mass_up_to_.push_back(sum += m);
    return 4 * double(kPi) * sum * double(luminance(emitted()));
  }

  [[nodiscard]] Photon from_light(const LightSource& source, Rng& rng) const {
    return std::visit([&](const auto& light) { return emit(light, target_, power(), rng); },
                      source);
  }

  [[nodiscard]] Photon from_sky(Rng& rng) const {
    const LightSample l = sample_sky(rng);
    const Vec3f d = -l.direction;
    return {target_.ray(d, rng), l.radiance * float(target_.shadow(d) / (double(l.pdf) * power()))};
  }

  [[nodiscard]] Photon from_matter(Rng& rng) const {
    const double u = to_uniform_double(rng.block().lo) * mass_up_to_.back();
    const auto above = std::upper_bound(mass_up_to_.begin(), mass_up_to_.end() - 1, u);
    const auto row = std::uint32_t(above - mass_up_to_.begin());
    const Vec3d at = target_.point(cells_, row, rng);
    return {{at, Vec3d(uniform_direction(rng))},
            emitted() * float(4 * double(kPi) * mass_up_to_.back() / power())};
  }

  const PathSetup& s_;
  const CoarseCells& cells_;
  Target target_;
  Vec3f axis_{0, 1, 0};
  std::vector<double> up_to_;       // powers: lights, the sky, matter
  std::vector<double> mass_up_to_;  // by row of the cells
};

/// Sums of photons as whole numbers, so that the order in which threads add does not matter.
class LightCounts {
 public:
  LightCounts(const IncidentLight& light, std::size_t rows, std::size_t lights, int photons)
      : lights_(lights),
        axis_(light.axis),
        unit_(light.power / (double(photons) * kSteps)),
        counts_(rows * kLightNodes),
        direct_(rows * lights) {}

  void add(std::uint32_t row, Vec3f towards_light, float power) {
    const auto node = std::size_t(half_sine(towards_light, axis_) * float(kLightNodes - 1) + 0.5f);
    add(counts_[row * std::size_t(kLightNodes) + std::min<std::size_t>(node, kLightNodes - 1)],
        power);
  }

  /// Of a photon that comes straight from its source.
  void add_direct(std::uint32_t row, std::size_t source, float power) {
    if (source < lights_) add(direct_[row * lights_ + source], power);
  }

  [[nodiscard]] std::vector<float> direct() const {
    std::vector<float> all;
    for (const std::uint64_t count : direct_) all.push_back(float(double(count) * unit_));
    return all;
  }

  [[nodiscard]] std::vector<std::array<float, kLightNodes>> sums() const {
    std::vector<std::array<float, kLightNodes>> all(counts_.size() / kLightNodes);
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      all[i / kLightNodes][i % kLightNodes] = float(double(counts_[i]) * unit_);
    }
    return all;
  }

 private:
  static constexpr int kSteps = 1 << 16;                   // per photon of mean power
  static constexpr std::uint64_t kMostSteps = 1ull << 32;  // no photon is worth more

  static void add(std::uint64_t& count, float power) {
    const double steps = std::min(double(power) * kSteps, double(kMostSteps));
    std::atomic_ref(count).fetch_add(std::uint64_t(steps), std::memory_order_relaxed);
  }

  std::size_t lights_;
  Vec3f axis_;
  double unit_;
  std::vector<std::uint64_t> counts_, direct_;
};

/// Photons that scatter more often have seen all of the cloud.
constexpr int kMostFlights = 1000;

void trace(const Sources& sources, const PathSetup& setup, const CoarseCells& cells,
           std::uint64_t number, LightCounts& counts) {
  constexpr std::uint64_t kKey = 0x70686f746f6e;
  OneVolume traversal(setup);
  Rng rng(kKey, 0, number);
  Photon p = sources.sample(rng);
  if (!traversal.start(p.ray)) return;
  Rgb power = p.power;
  if (!is_finite(power)) return;
  Vec3f d(p.ray.d);
  for (int flight = 0; flight < kMostFlights && !*setup.stop; ++flight) {
    const Hit hit = traversal.fly(d, rng);
    if (hit.matter == nullptr) return;
    const std::uint32_t row = cells.row(traversal.place().at.cell);
    counts.add(row, -d, luminance(power));
    if (flight == 0) counts.add_direct(row, p.source, luminance(power));
    power *= hit.matter->albedo;
    constexpr float kRoulette = 0.25f;
    const float most = largest(power);
    if (most < kRoulette) {
      if (!(rng.uniform() * kRoulette < most)) return;
      power *= kRoulette / most;
    }
    d = sample_phase(hit.matter->phase, d, rng);
  }
}

}  // namespace

IncidentLight trace_photons(const PathSetup& setup, const CoarseCells& cells, int photons) {
  const Sources sources(setup, cells);
  IncidentLight light;
  light.axis = sources.axis();
  light.power = sources.power();
  if (!(light.power > 0) || !std::isfinite(light.power)) {
    light.power = 0;
    return light;
  }
  LightCounts counts(light, cells.count(), setup.lights.size(), photons);
  parallel_for(0, std::size_t(photons), [&](std::size_t i) {
    if (!*setup.stop) trace(sources, setup, cells, i, counts);
  });
  light.collided = counts.sums();
  light.direct = counts.direct();
  return light;
}

}  // namespace pvol::detail
