// The path tracer of embed_bench, which asks any medium for flights and transmittances, and what it
// measures of each.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "nano_medium.h"
#include "pvol/embed.h"
#include "pvol/track/tally.h"
#include "pvol/volume/henyey_greenstein.h"

namespace pvol::bench {

/// Camera, lights and scattering: those of samples/peer_scene.toml, whose cloud is 1.75 units long.
struct Setting {
  Vec3d eye, forward, right, up;  ///< the sides as long as half the picture at distance 1
  Vec3f sun;                      ///< towards it
  HenyeyGreenstein phase;
  float albedo = 0.999f, sky = 0.5f, irradiance = 3;
};

[[nodiscard]] inline Setting make_setting(const Box& box, double g) {
  const Vec3d size = box.extent();
  const double scale = std::max({size.x, size.y, size.z}) / 1.75;
  const double half = std::tan(0.5 * 21.5 / 180 * std::numbers::pi);
  Setting s;
  s.eye = box.centre() + Vec3d(1.2, -0.3, 3.8) * scale;
  s.forward = normalize(box.centre() - s.eye);
  s.right = normalize(cross(s.forward, Vec3d(0, 1, 0))) * half;
  s.up = cross(s.right, s.forward);
  s.sun = Vec3f(normalize(Vec3d(0.6, 0.8, 0.35)));
  s.phase = HenyeyGreenstein(g);
  return s;
}

[[nodiscard]] inline Vec3d camera_direction(const Setting& s, Rng::Pair pixel) {
  return normalize(s.forward + s.right * double(2 * pixel.a - 1) + s.up * double(2 * pixel.b - 1));
}

/// The radiance of one camera sample: paths of any length, ended by a roulette of small weights.
/// visit(place) is called at every collision.
template <class Path, class Count, class Visit>
[[nodiscard]] float trace(const Setting& s, Path& path, Rng::Pair pixel, Rng& rng, Count& count,
                          const Visit& visit) {
  Ray ray{s.eye, camera_direction(s, pixel)};
  Vec3f direction(ray.d);
  const Vec3d sun(s.sun);
  float radiance = 0, weight = 1;
  for (;;) {
    const double t = path.flight(ray, rng, count);
    if (!(t < std::numeric_limits<double>::infinity())) return radiance + weight * s.sky;
    ray.o = ray.at(t);
    visit(ray.o);
    weight *= s.albedo;
    radiance += weight * s.irradiance * pdf_phase(s.phase, direction, s.sun) *
                path.transmittance({ray.o, sun}, rng, count);
    if (weight < 0.25f) {
      if (rng.uniform() < 0.5f) return radiance;
      weight *= 2;
    }
    const auto [u, v] = rng.uniform2();
    direction = sample_phase(s.phase, direction, u, v).direction;
    ray.d = Vec3d(direction);
  }
}

/// Mean and standard error of what was added.
struct Mean {
  double n = 0, sum = 0, squares = 0;
  void add(double x) { n += 1, sum += x, squares += x * x; }
  [[nodiscard]] double mean() const { return sum / n; }
  [[nodiscard]] double error() const {
    return std::sqrt(std::max(0.0, squares / n - mean() * mean()) / (n - 1));
  }
};

[[nodiscard]] inline double median(std::vector<double> x) {
  std::sort(x.begin(), x.end());
  return 0.5 * (x[(x.size() - 1) / 2] + x[x.size() / 2]);
}
[[nodiscard]] inline std::vector<double> ratios(std::vector<double> x,
                                                const std::vector<double>& base) {
  for (std::size_t i = 0; i < x.size(); ++i) x[i] /= base[i];
  return x;
}

/// Calls f, and says how much of the processor's time each of n parts of it took.
template <class F>
[[nodiscard]] double ns_each(std::size_t n, const F& f) {
  const std::clock_t start = std::clock();
  f();
  return 1e9 / CLOCKS_PER_SEC * double(std::clock() - start) / double(n);
}

/// Paths that a medium traces: those of the same round see the same camera rays, and the medium's
/// number gives it random numbers of its own.
struct Round {
  int round, number, paths;

  [[nodiscard]] Rng::Pair camera(int path) const {
    return Rng(1, std::uint64_t(round), std::uint64_t(path)).uniform2();
  }
};

/// A medium, and what was measured of it.
struct Row {
  std::string name;
  std::function<void(const Round&, Mean&)> trace;  ///< adds each path's radiance
  std::function<void(const Round&, Tally&, std::vector<Vec3d>*)> count{};  ///< where it counts
  Mean radiance{};
  std::vector<double> ns{};  ///< per path, by round
  Tally tally{};
  int counted = 0;  ///< paths that the tally is of
};

/// One path after the other, each by a medium that start() makes.
template <class Start, class Count, class Visit>
void trace_paths(const Setting& s, const Start& start, const Round& round, Mean& mean, Count& count,
                 const Visit& visit) {
  for (int k = 0; k < round.paths; ++k) {
    Rng rng(2 + std::uint64_t(round.number), std::uint64_t(round.round), std::uint64_t(k));
    auto path = start();
    mean.add(double(trace(s, path, round.camera(k), rng, count, visit)));
  }
}

struct Bench {
  static constexpr std::size_t kMostPlaces = 1 << 20;
  Setting setting;
  int paths, rounds;
  std::vector<Row> rows{};
  std::vector<Vec3d> places{};  ///< of collisions of the first medium, in the order of the paths

  template <class Start>
  void add_paths(std::string name, const Start& start) {
    const auto time = [this, start](const Round& round, Mean& mean) {
      NoTally none;
      trace_paths(setting, start, round, mean, none, [](Vec3d) {});
    };
    const auto count = [this, start](const Round& round, Tally& tally, std::vector<Vec3d>* to) {
      Mean unused;
      trace_paths(setting, start, round, unused, tally, [&](Vec3d at) {
        if (to != nullptr && to->size() < kMostPlaces) to->push_back(at);
      });
    };
    rows.push_back({.name = std::move(name), .trace = time, .count = count});
  }

  /// All media in turn, round after round; what they count in a round of its own.
  void run() {
    for (Row& row : rows) count(row);
    for (int round = 0; round < rounds; ++round) {
      for (std::size_t i = 0; i < rows.size(); ++i) {
        rows[i].ns.push_back(ns_each(std::size_t(paths), [&] {
          rows[i].trace({round, int(i), paths}, rows[i].radiance);
        }));
      }
    }
  }

 private:
  void count(Row& row) {
    if (!row.count) return;
    const int n = std::min(paths, 20000);
    row.count({-1, 0, n}, row.tally, places.empty() ? &places : nullptr);
    if (row.tally.segments > 0) row.counted = n;
  }
};

/// Prints what look-ups alone take at places: one after the other, where each waits for the one
/// before as in a path, and as many at once as the processor makes of them.
inline void print_points(const NanoMedium& nano, const Volume& volume,
                         const std::vector<Vec3d>& places, int rounds) {
  const auto accessor = nano.grid().getAccessor();
  const NanoTree& tree = nano.grid().tree();
  const auto nano_at = [&](const auto& access, Vec3d p) {
    const Vec3f at = nano.point(Vec3f(p));
    return nanovdb::SampleFromVoxels<std::remove_cvref_t<decltype(access)>, 1, false>(access)(
        nanovdb::Vec3f(at.x, at.y, at.z));
  };
  const auto by_tree = [&](Vec3d p) { return nano_at(tree, p); };
  const auto by_accessor = [&](Vec3d p) { return nano_at(accessor, p); };
  const auto by_volume = [&](Vec3d p) { return density_at(volume, p); };

  struct Times {
    std::vector<double> waiting, at_once;
    double sum = 0;
  } times[3];
  const auto measure = [&](Times& t, const auto& look_up) {
    float last = 0;
    double sum = 0;
    t.waiting.push_back(ns_each(places.size(), [&] {
      for (const Vec3d& p : places) last = look_up(p + Vec3d(double(last) * 0));
    }));
    t.at_once.push_back(ns_each(places.size(), [&] {
      for (const Vec3d& p : places) sum += double(look_up(p));
    }));
    t.sum = sum + double(last) * 0;
  };
  for (int round = 0; round < rounds; ++round) {
    measure(times[0], by_tree);
    measure(times[1], by_accessor);
    measure(times[2], by_volume);
  }
  std::printf("%zu points, mean densities %.6f, %.6f, %.6f\n", places.size(),
              times[0].sum / double(places.size()), times[1].sum / double(places.size()),
              times[2].sum / double(places.size()));
  constexpr const char* kNames[] = {"NanoVDB tree", "NanoVDB accessor", "pvol density_at"};
  std::printf("%-34s %12s %7s %12s %7s\n", "look-up at points", "ns, waiting", "ratio",
              "ns, at once", "ratio");
  for (int i = 0; i < 3; ++i) {
    std::printf("%-34s %12.1f %7.3f %12.1f %7.3f\n", kNames[i], median(times[i].waiting),
                median(ratios(times[i].waiting, times[0].waiting)), median(times[i].at_once),
                median(ratios(times[i].at_once, times[0].at_once)));
  }
}

}  // namespace pvol::bench
