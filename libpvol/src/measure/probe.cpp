#include "pvol/measure/probe.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "pvol/bounds/statistics.h"
#include "pvol/error.h"
#include "pvol/measure/student.h"
#include "pvol/render/render.h"
#include "pvol/render/scene_volume.h"
#include "pvol/render/shell_choice.h"
#include "pvol/shell/shell.h"
#include "pvol/volume/estimators.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/make_volume.h"

namespace pvol::measure {
namespace {

constexpr std::uint32_t kReplicates = 8;
constexpr double kMeanThickness = 10;  // of the extinction chosen

/// Several renders of the same, each with a seed of its own.
struct Replicates {
  std::vector<Counts> counts;
  Film film;  // all of them together
};

Replicates replicate(const Volume& volume, Scene scene) {
  const std::uint32_t samples = scene.options.samples;
  scene.options.samples = (samples + kReplicates - 1) / kReplicates;
  Replicates r;
  for (std::uint32_t i = 0; i < kReplicates; ++i) {
    scene.options.seed = i + 1;
    RenderResult one = render(volume, scene);
    r.counts.push_back(one.counts);
    if (i == 0) {
      r.film = std::move(one.film);
      continue;
    }
    add_samples(r.film, one.film);
  }
  return r;
}

Counts total(const Replicates& r) {
  Counts all;
  for (const Counts& c : r.counts) all += c;
  return all;
}

using Count = std::uint64_t (*)(const Counts&);

/// The ratio of two totals.
CountRatio ratio(const Replicates& r, Count above, Count below) {
  const Counts all = total(r);
  if (below(all) == 0) return {};
  const double value = double(above(all)) / double(below(all));
  double squares = 0;
  for (const Counts& c : r.counts) {
    const double residual = double(above(c)) - value * double(below(c));
    squares += residual * residual;
  }
  const double n = double(r.counts.size());
  return {value,
          student_quantile(0.95, n - 1) * std::sqrt(squares * n / (n - 1)) / double(below(all))};
}

PathCosts summarise(const Replicates& r, std::uint64_t micro_bytes) {
  PathCosts c;
  c.counts = total(r);
  c.lookups = ratio(
      r, [](const Counts& k) { return k.path.lookups; },
      [](const Counts& k) { return k.collisions; });
  c.micro_bytes = micro_bytes;
  const double collisions = double(c.counts.collisions);
  if (collisions == 0) return c;
  c.tentative = (collisions + double(c.counts.path.null_collisions)) / collisions;
  c.bounds_tests = double(c.counts.path.bounds_tests) / collisions;
  c.segments = double(c.counts.path.segments) / collisions;
  return c;
}

double choose_extinction(const VoxelGrid& grid) {
  const VolumeFacts f = describe(grid, 1, {});
  const double* t = f.mean_optical_thickness;
  const double mean = (t[0] + t[1] + t[2]) / 3;
  if (!(mean > 0))
    throw Error("the cloud is too thin to choose an extinction; set medium.extinction");
  return kMeanThickness / mean;
}

/// The cloud in front of the camera.
struct Stage {
  Scene scene;
  Volume volume;
};

Stage set_up(const VoxelGrid& grid, const Pyramid& pyramid, const ProbeOptions& options) {
  Stage s;
  Scene& scene = s.scene;
  scene.environment = ConstantSky{};
  scene.options.samples = options.samples;
  scene.options.width = options.width;
  scene.options.micro_bounds = MicroBoundsUse::none;
  scene.options.guide = GuideUse::off;
  scene.options.count = true;
  scene.options.kernel = KernelKind::scalar;  // the same walk for all
  const Medium medium{
      .extinction = options.extinction ? *options.extinction : choose_extinction(grid),
      .components = {{.albedo = options.albedo, .phase = HenyeyGreenstein(options.g)}}};
  s.volume = make_volume(grid, pyramid, medium, volume_options(scene.options));
  const Vec3d size = s.volume.density.world_box.extent();
  scene.options.height = std::clamp(int(options.width * size.y / std::max(size.x, size.y)),
                                    std::max(1, options.width / 4), options.width);
  scene.camera = frame(s.volume.density.world_box, double(options.width) / scene.options.height);
  return s;
}

}  // namespace

Probe probe(const VoxelGrid& grid, const Pyramid& pyramid, const ProbeOptions& options) {
  auto [scene, volume] = set_up(grid, pyramid, options);
  Probe p;
  p.extinction = volume.medium.extinction;
  p.facts = describe(volume, describe(grid, volume.medium.extinction, volume.object_to_world));
  scene.options.tracker = Tracker::delta;
  p.delta = summarise(replicate(volume, scene), 0);
  scene.options.tracker = Tracker::decomposition;
  Replicates decomposed = replicate(volume, scene);
  p.decomposition = summarise(decomposed, 0);
  p.film = std::move(decomposed.film);
  volume.density.micro = build_micro_bounds(volume.density.bricks(), 2);
  p.squeezed = summarise(replicate(volume, scene), volume.density.micro.bytes());
  const double mass = measure_content(grid, pyramid).back()[0].mass;
  p.squeezed_expected = integrate_open(volume) / (double(volume.density.scale) * mass);
  return p;
}

ShellProbe probe_shell(const VoxelGrid& grid, const Pyramid& pyramid, const Shell& shell,
                       const ProbeOptions& options) {
  auto [scene, volume] = set_up(grid, pyramid, options);
  ShellProbe p;
  p.extinction = volume.medium.extinction;
  p.without = total(replicate(volume, scene));
  scene.options.shells = ShellUse::on;
  volume.shell = std::make_shared<const Shell>(shell);
  p.estimate = choose_shell(volume, scene).estimate;
  const Replicates with_shell = replicate(volume, scene);
  p.with_shell = total(with_shell);
  for (const PixelSums& pixel : with_shell.film.pixels) p.rays += pixel.samples;
  p.rejected = ratio(
      with_shell, [](const Counts& k) { return k.shell_rejections; },
      [](const Counts& k) { return k.shell_tests; });
  return p;
}

}  // namespace pvol::measure
