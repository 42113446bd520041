#include "render/plan/fire_lights.h"

#include <limits>

#include "render/path/path_setup.h"
#include "render/plan/camera_probe.h"
#include "render/plan/forecast.h"

namespace pvol::detail {
namespace {

/// How much more noise, at equal time, scattered light would have without samples of fires; not a
/// number where nothing is scattered. Few paths bring most of it: where they do not decide, more
/// are followed.
double noise_without_samples(const RenderPlan& plan) {
  RenderPlan plain = plain_plan_of_whole(plan);
  plain.scene.options.background = false;  // of no account where light is scattered
  plain.scene.options.aovs.add(Aov::scattering);
  FirePilot pilot;
  PathSetup setup(plain);
  setup.pilot = &pilot;
  CameraProbe probe;
  double square = 0;  // sum over the paths of that of their scattered luminance
  const auto visit = [&](const Film& film, std::size_t pixel) {
    const Rgb scattered(mean(film.pixels[pixel]) - film.layers.front().sums[pixel]);
    square += double(luminance(scattered)) * double(luminance(scattered));
  };
  const auto ratio = [&] {
    if (pilot.flights == 0) return std::numeric_limits<double>::infinity();  // they cost nothing
    const double pdfs = kDirectionsPdf * double(pilot.pdfs);
    const double flights = nanoseconds(probe.counts.shadow, probe.counts.shadow_rays) *
                           double(pilot.flights) / double(probe.counts.shadow_rays);
    const double all = 1e9 * seconds_of(probe.counts, probe.paths) + pdfs;
    const double without = square + pilot.unsampled - pilot.sampled;
    return without * (all - pdfs - flights) / (square * all);
  };
  constexpr int kFewest = 1024, kMost = 2048;
  constexpr double kClear = 2;
  follow_paths(setup, kMost, probe, visit, [&] {
    const double now = ratio();
    return probe.paths >= kFewest && (now < 1 / kClear || now > kClear);
  });
  return ratio();
}

}  // namespace

std::shared_ptr<const EmissionSetup> choose_fire_lights(const RenderPlan& plan) {
  if (noise_without_samples(plan) > 1) return plan.emission;
  auto without = std::make_shared<EmissionSetup>(*plan.emission);
  without->sampled_in_volumes = false;
  return without;
}

}  // namespace pvol::detail
