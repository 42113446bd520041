// The library's flights, scattering and pictures in slabs against adding and doubling.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "pvol/bounds/pyramid.h"
#include "pvol/render/render.h"
#include "pvol/track/flight.h"
#include "pvol/volume/phase.h"
#include "support/cloud_scene.h"
#include "support/estimators.h"
#include "support/flights.h"
#include "support/slab_oracle.h"
#include "support/statistics.h"

namespace pvol::test {
namespace slab_test {

constexpr double kCosines[] = {1, 0.3};
constexpr double kDepths[] = {0.1, 1, 10};
constexpr double kAlbedos[] = {0.5, double(0.9f), 1};
constexpr double kMeanCosines[] = {0, 0.5, 0.877, -0.4};

/// Of each combination; closed forms take long.
int paths_of(Tracker tracker) {
  return proof::samples(tracker == Tracker::regular ? 2'000 : 5'000);
}

/// Each cosine twice, as view and as incidence. With 48 streams fluxes are still right to 1e-7.
Slab oracle(double depth, double albedo, double g) {
  return Slab({depth, albedo, g}, {kCosines[0], kCosines[1], kCosines[0], kCosines[1]}, 48);
}

/// A layer across z, so wide that light finds its sides only along the thin air of its faces.
struct Layer {
  std::string name;
  VoxelGrid grid;
  Pyramid pyramid;
  double mass = 0;         ///< density integrated along z
  double least_depth = 0;  ///< thinner ones lose light sideways
};

/// Eight samples thick, of different densities, 512 wide. Bounds are loose, so every tracker meets
/// null collisions.
Layer layer_of_bricks() {
  constexpr float kProfile[] = {0.25f, 1, 0.5f, 0.125f, 0.75f, 1, 0.375f, 0.625f};
  auto values = std::make_shared<std::array<float, kBrickSamples>>();
  for (std::size_t i = 0; i < kBrickSamples; ++i) (*values)[i] = kProfile[i % kBrickEdge];
  Layer layer;
  layer.name = "bricks";
  for (int x = -256; x < 256; x += kBrickEdge) {
    for (int y = -256; y < 256; y += kBrickEdge) {
      layer.grid.bricks.push_back({{x, y, 0}, values->data()});
    }
  }
  layer.grid.owner = values;
  layer.pyramid = build_pyramid(layer.grid);
  layer.mass = std::accumulate(std::begin(kProfile), std::end(kProfile), 0.0);
  layer.least_depth = 1;
  return layer;
}

/// 128 samples of one density thick, 512 wide; voxels 64 times flatter than wide.
Layer layer_of_tiles() {
  Layer layer;
  layer.name = "tiles";
  for (int x = -256; x < 256; x += 128) {
    for (int y = -256; y < 256; y += 128) layer.grid.tiles.push_back({{x, y, 0}, 128, 0.5f});
  }
  layer.grid.index_to_world = scaling({1, 1, 1.0 / 64});
  layer.pyramid = build_pyramid(layer.grid);
  layer.mass = 0.5 * 128 / 64;
  return layer;
}

const std::vector<Layer>& layers() {
  static const std::vector<Layer> all{layer_of_bricks(), layer_of_tiles()};
  return all;
}

/// A scene whose slab has this optical thickness.
CloudScene scene_of(const Layer& layer, double depth, Tracker tracker) {
  CloudScene s;
  s.medium.extinction = depth / layer.mass;
  s.options.tracker = tracker;
  return s;
}

Volume volume_of(const Layer& layer, const CloudScene& scene,
                 SampleStorage samples = SampleStorage::automatic) {
  VolumeOptions o = scene.volume_options();
  o.samples = samples;
  return pvol::make_volume(layer.grid, layer.pyramid, scene.medium.medium(), o);
}

enum Fate { reflected, transmitted, direct, absorbed, kFates };
using Fates = std::array<std::uint64_t, kFates>;

/// Whether a ray leaves the support through another face than those across z.
bool leaves_sideways(const Volume& v, const Cursor& cursor, Vec3d direction) {
  const Box support = v.density.octree.support();
  const Ray ray{Vec3d(vec3(cursor.at.cell)) + Vec3d(vec3(cursor.at.frac)), direction};
  const auto span = intersect(support, ray, 0, std::numeric_limits<double>::infinity());
  if (!span) return false;  // by rounding, from the face itself
  const Vec3d p = ray.at(span->t1);
  constexpr double kClose = 0.01;  // cells
  for (const int axis : {0, 1}) {
    if (p[axis] < support.lo[axis] + kClose || p[axis] > support.hi[axis] - kClose) return true;
  }
  return false;
}

/// A photon from above at this cosine, in the middle. Bounds hold, so flights weigh 1.
/// Where it leaves through a side, it would have left through the face ahead a little later.
template <Tracker kTracker>
Fate follow(const Volume& v, double cosine, double albedo, const HenyeyGreenstein& phase, Rng& rng,
            std::uint64_t& sideways) {
  const Vec3d middle = (v.density.world_box.lo + v.density.world_box.hi) * 0.5;
  Cursor cursor =
      make_cursor(v.density.octree,
                  v.density.world_to_cells.point({middle.x, middle.y, v.density.world_box.hi.z}));
  Vec3f d(Vec3d(std::sqrt(1 - cosine * cosine), 0, -cosine));
  NoTally tally;
  for (bool scattered = false;; scattered = true) {
    const Vec3d in_cells = v.density.world_to_cells.vector(Vec3d(d));
    Walk walk(v.density.octree, cursor, widen(Vec3f(in_cells)));
    const Flight flight = free_flight<kTracker>(walk, exact<LookUp::trilinear>(v), rng, tally);
    if (!flight.collided) {
      sideways += leaves_sideways(v, cursor, in_cells);
      return d.z > 0 ? reflected : scattered ? transmitted : direct;
    }
    if (!(double(rng.uniform()) < albedo)) return absorbed;
    cursor = walk.stop_at(walk.point(flight.t));
    d = sample_phase(phase, d, rng);
  }
}

Fates follow_many(const Volume& v, Tracker tracker, double cosine, double albedo, double g,
                  std::uint64_t stream, int paths) {
  const HenyeyGreenstein phase(g);
  Fates fates{};
  std::uint64_t sideways = 0;
  with_tracker(tracker, [&](auto constant) {
    for (int i = 0; i < paths; ++i) {
      Rng rng(kSeed, stream, std::uint64_t(i));
      ++fates[follow<decltype(constant)::value>(v, cosine, albedo, phase, rng, sideways)];
    }
  });
  EXPECT_LE(sideways, 1u);
  return fates;
}

/// The probability of each fate.
std::array<double, kFates> probabilities(const Fluxes& f) {
  const double lost = std::max(0.0, 1 - f.reflected - f.transmitted - f.direct);
  return {f.reflected, f.transmitted, f.direct, lost};
}

double fates_p_value(const Fates& fates, const Fluxes& f) {
  const double n = double(std::accumulate(fates.begin(), fates.end(), std::uint64_t{0}));
  std::array<double, kFates> expected = probabilities(f);
  for (double& e : expected) e *= n;
  return proof::counts_p_value(fates, expected);
}

/// The likelihood of all fates under a hypothesis that is a little wrong, relative to that under
/// the right one: of all statistics it tells the two apart best (Neyman, Pearson 1933). Its mean
/// and variance under the right hypothesis are known, and the logarithms may be approximate.
class LikelihoodRatio {
 public:
  void add(const Fates& fates, const Fluxes& expected, const Fluxes& right, const Fluxes& wrong) {
    const auto p = probabilities(expected), q = probabilities(right), r = probabilities(wrong);
    double n = 0, mean = 0, square = 0;
    for (std::size_t k = 0; k < kFates; ++k) {
      constexpr double kNever = 1e-5;
      const double ratio = q[k] > kNever && r[k] > kNever ? std::log(r[k] / q[k]) : 0;
      n += double(fates[k]);
      mean += p[k] * ratio;
      square += p[k] * ratio * ratio;
      excess_ += double(fates[k]) * ratio;
    }
    excess_ -= n * mean;
    variance_ += n * (square - mean * mean);
  }
  [[nodiscard]] double p_value() const {
    return proof::normal_p_value(excess_ / std::sqrt(variance_));
  }

 private:
  double excess_ = 0, variance_ = 0;
};

/// Independent p-values taken together, so that a small error everywhere is seen as well: minus
/// twice the sum of their logarithms is a chi-square variable (Fisher. Statistical Methods for
/// Research Workers. 1932).
class Combined {
 public:
  void add(double p) { sum_ += std::log(std::max(p, 1e-300)), ++count_; }
  [[nodiscard]] double p_value() const {
    return proof::chi_square_p_value(-2 * sum_, 2 * double(count_));
  }

 private:
  double sum_ = 0;
  int count_ = 0;
};

/// All combinations of optical thickness, albedo and phase function; f(number, depth, albedo, g).
template <class F>
void for_each_slab(const F& f) {
  std::uint64_t number = 0;
  for (const double depth : kDepths) {
    for (const double albedo : kAlbedos) {
      for (const double g : kMeanCosines) f(number++, depth, albedo, g);
    }
  }
}

/// What is expected of a slab; and, to a few digits, how it differs from one whose extinction or
/// mean cosine is 1 % larger.
struct Expectation {
  Slab exact, rough, denser, more_forward;
};
Expectation expectation(double depth, double albedo, double g) {
  constexpr int kFew = 24;
  const std::vector<double> cosines(std::begin(kCosines), std::end(kCosines));
  return {oracle(depth, albedo, g),
          {{depth, albedo, g}, cosines, kFew},
          {{1.01 * depth, albedo, g}, cosines, kFew},
          {{depth, albedo, 1.01 * g}, cosines, kFew}};
}

TEST(Slab, FlightsReflectAndTransmitWhatTheyShould) {
  std::vector<Expectation> expected;
  for_each_slab([&](std::uint64_t, double depth, double albedo, double g) {
    expected.push_back(expectation(depth, albedo, g));
  });
  proof::Family family;
  for (const Tracker tracker : kTrackers) {
    Combined all;
    LikelihoodRatio extinction, mean_cosine;
    for (const Layer& layer : layers()) {
      std::optional<Volume> volume;
      double made_for = 0;
      for_each_slab([&](std::uint64_t number, double depth, double albedo, double g) {
        if (depth < layer.least_depth) return;
        if (made_for != depth) {
          volume = volume_of(layer, scene_of(layer, depth, tracker), SampleStorage::copied);
        }
        made_for = depth;
        const Expectation& e = expected[number];
        for (const std::size_t i : {0, 1}) {
          const std::uint64_t stream = number * 64 + std::uint64_t(tracker) * 4 + i * 2 +
                                       std::uint64_t(&layer - layers().data());
          // An optical thickness of 1 tells most about the extinction.
          const Fates fates = follow_many(*volume, tracker, kCosines[i], albedo, g, stream,
                                          depth == 1 ? 4 * paths_of(tracker) : paths_of(tracker));
          const Fluxes fluxes = e.exact.collimated(i), rough = e.rough.collimated(i);
          const double p = fates_p_value(fates, fluxes);
          extinction.add(fates, fluxes, rough, e.denser.collimated(i));
          mean_cosine.add(fates, fluxes, rough, e.more_forward.collimated(i));
          all.add(p);
          family.add(std::string(label(tracker)) + ", " + layer.name + ", depth " +
                         std::to_string(depth) + ", albedo " + std::to_string(albedo) + ", g " +
                         std::to_string(g) + ", cosine " + std::to_string(kCosines[i]),
                     p);
        }
      });
    }
    family.add(std::string(label(tracker)) + ", all together", all.p_value());
    family.add(std::string(label(tracker)) + ", extinction", extinction.p_value());
    family.add(std::string(label(tracker)) + ", mean cosine", mean_cosine.p_value());
  }
  EXPECT_TRUE(family.passes());
}

/// At optical thickness 60 nothing comes through.
TEST(Slab, ThickSlabsReflectAsTheHFunctionSays) {
  const Layer& layer = layers()[1];
  proof::Family family;
  for (const Tracker tracker : kTrackers) {
    const Volume volume = volume_of(layer, scene_of(layer, 60, tracker));
    for (const double albedo : {0.5, 0.9, 0.95}) {
      const HFunction h(albedo);
      for (const double cosine : {1.0, 0.3, 0.1}) {
        const Fates fates = follow_many(volume, tracker, cosine, albedo, 0,
                                        1000 + std::uint64_t(tracker), 4 * paths_of(tracker));
        family.add(std::string(label(tracker)) + ", albedo " + std::to_string(albedo) +
                       ", cosine " + std::to_string(cosine),
                   fates_p_value(fates, {h.plane_albedo(cosine), 0, 0}));
      }
    }
  }
  EXPECT_TRUE(family.passes());
}

/// A camera that looks at the middle of the slab at this cosine, from above or from below.
Camera looking_at(const Volume& v, double cosine, bool from_above) {
  const Vec3d middle = (v.density.world_box.lo + v.density.world_box.hi) * 0.5;
  const double sine = std::sqrt(1 - cosine * cosine);
  Camera c;
  c.target = middle;
  c.position = middle + Vec3d(-sine, 0, from_above ? cosine : -cosine) * 50.0;
  c.up = {0, 1, 0};
  c.fov = 0.01;
  return c;
}

/// The slab in the dark, of optical thickness `depth`; the channels' albedos are kAlbedos.
CloudScene dark_scene(const Layer& layer, double depth, Tracker tracker) {
  CloudScene s = scene_of(layer, depth, tracker);
  s.medium.albedo = Rgb(float(kAlbedos[0]), float(kAlbedos[1]), float(kAlbedos[2]));
  s.environment = ConstantSky{Rgb(0.0f)};
  s.options.width = s.options.height = 4;
  s.options.samples = proof::samples(250);
  s.options.threads = 1;
  return s;
}

/// Of a mean, to which rare samples may bring most, against its expectation: it is summed to a
/// gamma law, whose skewness of twice the relative deviation is about that of few large events
/// among many small ones, and to the normal law where there are many. Only an error above
/// `rounding` counts.
double skewed_p_value(double mean, double variance, double expected, double rounding) {
  constexpr double kMany = 1e4;
  const double excess = std::max(0.0, std::abs(mean - expected) - rounding);
  if (std::isnan(mean)) return 0;
  if (excess == 0) return 1;
  // Where the mean is low by chance, so is the variance.
  const double shape = expected * mean / variance;
  if (!(shape < kMany)) return proof::normal_p_value(excess / std::sqrt(variance));
  const double shifted = expected + (mean < expected ? -excess : excess);
  const proof::Tails tails = proof::gamma_tails(shape, shape * shifted / expected);
  return std::min(1.0, 2 * std::min(tails.lower, tails.upper));
}

/// Compares the mean of each channel with the expected one.
void compare(const Volume& v, const CloudScene& scene, const std::string& name,
             const Vec3d& expected, proof::Family& family, Combined& all) {
  const Film film = render(v, scene).film;
  const double n = double(film.pixels.size());
  Vec3d average, variance;
  for (const PixelSums& p : film.pixels) {
    average += mean(p) / n;
    variance += variance_of_mean(p) / (n * n);
  }
  // Fainter light comes by paths too rare for the normal law.
  constexpr double kFaint = 2e-3;
  for (int c = 0; c < 3; ++c) {
    if (expected[c] < kFaint) continue;
    const double rounding = 2e-6 * expected[c];  // throughputs and directions are floats
    const double p = skewed_p_value(average[c], variance[c], expected[c], rounding);
    family.add(name + ", channel " + std::to_string(c), p);
    if (c == 1) all.add(p);
  }
}

/// The slab of this thickness for each of kMeanCosines, and for each channel.
std::vector<std::array<Slab, 3>> oracles(double depth) {
  std::vector<std::array<Slab, 3>> slabs;
  for (const double g : kMeanCosines) {
    slabs.push_back({oracle(depth, kAlbedos[0], g), oracle(depth, kAlbedos[1], g),
                     oracle(depth, kAlbedos[2], g)});
  }
  return slabs;
}

std::string case_name(const CloudScene& s, double depth, double cosine) {
  return std::string(label(s.options.tracker)) + ", " + label(s.options.transmittance) +
         ", depth " + std::to_string(depth) + ", g " + std::to_string(s.medium.g) + ", cosine " +
         std::to_string(cosine);
}

/// In light of radiance 1 from everywhere one sees what the slab would reflect and transmit of a
/// beam from the camera.
TEST(Slab, PicturesInConstantLightShowItsPlaneAlbedo) {
  const Layer& layer = layers()[1];
  proof::Family family;
  Combined all;
  for (const double depth : kDepths) {
    const auto slabs = oracles(depth);
    for (const Tracker tracker : kTrackers) {
      CloudScene s = dark_scene(layer, depth, tracker);
      s.environment = ConstantSky{Rgb(1.0f)};
      if (is_slow(tracker, s.options.transmittance)) s.options.samples /= 5;
      const Volume v = volume_of(layer, s);
      for (std::size_t i = 0; i < 2 * slabs.size(); ++i) {
        const std::size_t view = i % 2;
        Vec3d expected;
        for (int c = 0; c < 3; ++c) {
          const Fluxes f = slabs[i / 2][std::size_t(c)].collimated(view);
          expected[c] = f.reflected + f.transmitted + f.direct;
        }
        s.medium.g = kMeanCosines[i / 2];
        s.camera = looking_at(v, kCosines[view], view == 0);
        s.options.seed = proof::seeded(std::uint64_t(tracker) * 8 + i);
        compare(v, s, case_name(s, depth, kCosines[view]), expected, family, all);
      }
    }
  }
  family.add("all together", all.p_value());
  EXPECT_TRUE(family.passes());
}

/// The radiance that the slab reflects and transmits of a delta sun: along the normal or, with an
/// isotropic phase function, at a slant. Phase functions take turns among trackers and estimators.
TEST(Slab, PicturesInTheSunShowItsReflectionFunction) {
  const Layer& layer = layers()[1];
  proof::Family family;
  Combined all;
  for (const double depth : kDepths) {
    const auto slabs = oracles(depth);
    std::size_t turn = 0;
    for (const Tracker tracker : kTrackers) {
      CloudScene s = dark_scene(layer, depth, tracker);
      const Volume v = volume_of(layer, s);
      for (const Transmittance transmittance : kTransmittances) {
        const std::size_t phase = (turn + turn / 4) % slabs.size();
        s.options.transmittance = transmittance;
        s.medium.g = kMeanCosines[phase];
        // A narrow peak that shadow rays seldom meet makes skewed sums: of fewer no law is known.
        s.options.samples = s.medium.g > 0.8 ? 1000 : proof::samples(250, 2);
        if (is_slow(tracker, transmittance)) s.options.samples = s.medium.g > 0.8 ? 200 : 50;
        const std::size_t view = s.medium.g == 0 ? turn / 4 % 2 : 0;
        for (const std::size_t i : {0, 1, 2, 3}) {
          const bool from_above = i < 2;
          const std::size_t sun = 2 + i % 2;  // its entry among the oracle's cosines
          const double mu = kCosines[i % 2];
          s.lights = {Sun{{std::sqrt(1 - mu * mu), 0, mu}, Rgb(2.0f), 0}};
          s.camera = looking_at(v, kCosines[view], from_above);
          s.options.seed = proof::seeded(turn * 4 + i);
          Vec3d expected;
          for (int c = 0; c < 3; ++c) {
            const Slab& slab = slabs[phase][std::size_t(c)];
            expected[c] = 2 * (from_above ? slab.reflected_radiance(view, sun)
                                          : slab.transmitted_radiance(view, sun));
          }
          compare(v, s, case_name(s, depth, mu) + (from_above ? " from above" : " from below"),
                  expected, family, all);
        }
        ++turn;
      }
    }
  }
  family.add("all together", all.p_value());
  EXPECT_TRUE(family.passes());
}

}  // namespace slab_test
}  // namespace pvol::test
