// Whole renders of one cloud with every tracker and estimator, in turn in one process, with counts.
//
//   render_bench CLOUD [THICKNESS=64] [G=0] [ALBEDO=0.999] [ROUNDS=3] [INTERPOLATION=trilinear]
//
// With tricubic or procedural look-ups (of a recipe) closed forms are left out.
// THICKNESS is the mean optical thickness along the cloud's x axis. Quote the counts and the ratios
// of the times; the times themselves belong to one machine on one day.
#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <optional>
#include <utility>
#include <vector>

#include "pvol/formats/cloud.h"
#include "pvol/formats/scene_file.h"
#include "pvol/render/render.h"
#include "pvol/render/scene_volume.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/make_volume.h"

namespace {

using namespace pvol;

struct Configuration {
  Tracker tracker;
  Transmittance transmittance;
  std::optional<int> depth;
  MicroBoundsUse micro = MicroBoundsUse::none;
};

bool has_closed_form(const Configuration& c) {
  return c.tracker == Tracker::regular || c.transmittance == Transmittance::regular;
}

struct Measurement {
  double load = 1e300;            // CPU seconds to make the volume
  double microseconds = 1e300;    // CPU time per camera sample, the least of all rounds
  double mean = 0, variance = 0;  // luminance of the image and its variance for one sample
  Counts counts;
  int depth = 0;
};

double cpu_seconds() {
  rusage u{};
  getrusage(RUSAGE_SELF, &u);
  return double(u.ru_utime.tv_sec + u.ru_stime.tv_sec) +
         1e-6 * double(u.ru_utime.tv_usec + u.ru_stime.tv_usec);
}

/// A cloud, what it is made of, and how it is looked at.
struct Subject {
  formats::Cloud cloud;
  Medium medium;
  Scene scene;

  [[nodiscard]] Volume make() const {
    return make_volume(cloud.density, cloud.pyramid, medium, volume_options(scene.options));
  }
  [[nodiscard]] double samples() const {
    return double(scene.options.width) * scene.options.height * scene.options.samples;
  }
};

void measure(Subject subject, const Configuration& c, Measurement& m) {
  Scene& scene = subject.scene;
  scene.options.tracker = c.tracker;
  scene.options.transmittance = c.transmittance;
  scene.options.depth = c.depth;
  scene.options.micro_bounds = c.micro;
  const double start = cpu_seconds();
  const Volume volume = subject.make();
  m.load = std::min(m.load, cpu_seconds() - start);
  const double begin = cpu_seconds();
  const Film film = render(volume, scene).film;
  const double seconds = cpu_seconds() - begin;
  m.microseconds = std::min(m.microseconds, seconds / subject.samples() * 1e6);
  if (m.counts.collisions > 0) return;  // the same in every round

  m.depth = volume.density.octree.depth;
  for (const PixelSums& p : film.pixels) {
    m.mean += luminance(mean(p)) / double(film.pixels.size());
    m.variance +=
        luminance(variance_of_mean(p)) * scene.options.samples / double(film.pixels.size());
  }
  scene.options.count = true;
  m.counts = render(volume, scene).counts;
}

void print(const Configuration& c, const Measurement& m, double samples) {
  const Counts& k = m.counts;
  const auto per_collision = [&](std::uint64_t n) { return double(n) / double(k.collisions); };
  const auto per_sample = [&](std::uint64_t n) { return double(n) / samples; };
  std::printf(
      "%-22s %-14s %-4s %5d | %8.2f %8.2f %8.2f %8.2f | %8.1f %8.1f %8.1f | %7.4f %8.4f | %8.2f "
      "%9.3f %9.3f %9.3f | %6.2f\n",
      name(c.tracker), name(c.transmittance), name(c.micro), m.depth, per_collision(k.path.lookups),
      per_collision(k.path.bounds_tests), per_collision(k.path.segments),
      per_collision(k.path.null_collisions), per_sample(k.collisions),
      per_sample(k.path.lookups + k.shadow.lookups),
      per_sample(k.path.segments + k.shadow.segments), m.mean, m.variance, m.microseconds,
      m.microseconds * m.variance, per_sample(k.path.lookups + k.shadow.lookups) * m.variance,
      per_sample(k.path.lookups + k.shadow.lookups + k.path.bounds_tests + k.shadow.bounds_tests) *
          m.variance,
      m.load);
}

Subject make_subject(formats::Cloud cloud, LookUp look_up, double thickness, double g,
                     double albedo) {
  Subject s{std::move(cloud), {}, {}};
  s.medium.components = {{.albedo = Rgb(float(albedo)), .phase = HenyeyGreenstein(g)}};
  s.scene.environment = ConstantSky{Rgb(0.5f)};
  s.scene.lights = {Sun{{0.6, 0.8, 0.35}, Rgb(3.0f), 0}};
  s.scene.options.width = s.scene.options.height = 96;
  s.scene.options.samples = 16;
  s.scene.options.threads = 1;
  s.scene.options.guide = GuideUse::off;  // it is trackers that are compared
  s.scene.options.look_up = look_up;
  const Volume unit = s.make();
  s.scene.camera = frame(unit.density.world_box, 1);
  const VolumeFacts facts = describe(s.cloud.density, s.medium.extinction, unit.object_to_world);
  s.medium.extinction = thickness / facts.mean_optical_thickness[0];
  return s;
}

std::vector<Configuration> make_configurations(LookUp look_up) {
  using T = Transmittance;
  using M = MicroBoundsUse;
  std::vector<Configuration> all{{Tracker::delta_global, T::ratio, std::nullopt},
                                 {Tracker::delta_global, T::analog, std::nullopt},
                                 {Tracker::delta, T::ratio, std::nullopt},
                                 {Tracker::delta, T::analog, std::nullopt},
                                 {Tracker::weighted_delta, T::analog, std::nullopt},
                                 {Tracker::weighted_decomposition, T::analog, std::nullopt},
                                 {Tracker::regular, T::regular, std::nullopt}};
  for (const T t : {T::analog, T::ratio, T::residual_ratio, T::regular}) {
    for (const M m : {M::none, M::edge_2, M::edge_1}) {
      all.push_back({Tracker::decomposition, t, std::nullopt, m});
    }
  }
  if (look_up == LookUp::tricubic || look_up == LookUp::procedural) {
    std::erase_if(all, has_closed_form);
  }
  return all;
}

void print_head() {
  std::printf(
      "%-48s | camera path, per collision          | per camera sample          | luminance        "
      "|            times variance\n",
      "");
  std::printf(
      "%-22s %-14s %-4s %5s | %8s %8s %8s %8s | %8s %8s %8s | %7s %8s | %8s %9s %9s %9s | %6s\n",
      "tracker", "shadow", "mic.", "depth", "look-ups", "tests", "segments", "nulls", "collis.",
      "look-ups", "segments", "mean", "variance", "CPU us", "CPU us", "look-ups", "+ tests",
      "load s");
}

int run(int argc, char** argv) {
  const auto argument = [&](int i, double otherwise) {
    return argc > i ? std::strtod(argv[i], nullptr) : otherwise;
  };
  if (argc < 2) {
    std::fprintf(stderr,
                 "usage: render_bench CLOUD [THICKNESS=64] [G=0] [ALBEDO=0.999] [ROUNDS=3] "
                 "[INTERPOLATION=trilinear]\n");
    return 2;
  }
  const double thickness = argument(2, 64), g = argument(3, 0), albedo = argument(4, 0.999);
  const int rounds = int(argument(5, 3));
  const LookUp look_up = find_named<LookUp>(argc > 6 ? argv[6] : "trilinear").value();
  const Subject subject =
      make_subject(formats::load_cloud(argv[1], {}, look_up), look_up, thickness, g, albedo);

  const std::vector<Configuration> configurations = make_configurations(look_up);
  std::vector<Measurement> results(configurations.size());
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < configurations.size(); ++i) {
      measure(subject, configurations[i], results[i]);
    }
  }
  std::printf("%s: mean optical thickness %g along x, g %g, albedo %g, extinction %g\n", argv[1],
              thickness, g, albedo, subject.medium.extinction);
  print_head();
  for (std::size_t i = 0; i < configurations.size(); ++i) {
    print(configurations[i], results[i], subject.samples());
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "render_bench: error: %s\n", e.what());
    return 1;
  }
}
