#include "render/plan/fire_lights.h"

#include "render/path/path_setup.h"
#include "render/plan/camera_probe.h"
#include "render/plan/forecast.h"

namespace pvol::detail {
namespace {

bool pays_to_sample_fires(const RenderPlan& plan) {
  RenderPlan plain = plain_plan(plan);
  plain.scene.options.background = false;  // of no account where light is scattered
  plain.scene.options.aovs.add(Aov::scattering);
  FirePilot pilot;
  PathSetup setup(plain);
  setup.pilot = &pilot;
  constexpr int kPaths = 1024;
  CameraProbe probe;
  double square = 0;  // sum over the paths of that of their scattered luminance
  follow_paths(setup, kPaths, probe, [&](const Film& film, std::size_t pixel) {
    const Rgb scattered(mean(film.pixels[pixel]) - film.layers.front().sums[pixel]);
    square += double(luminance(scattered)) * double(luminance(scattered));
  });
  if (pilot.flights == 0) return true;  // and costs nothing
  const double pdfs = kDirectionsPdf * double(pilot.pdfs);
  const double flights = nanoseconds(probe.counts.shadow, probe.counts.shadow_rays) *
                         double(pilot.flights) / double(probe.counts.shadow_rays);
  const double all = 1e9 * seconds_of(probe.counts, probe.paths) + pdfs;
  const double without = square + pilot.unsampled - pilot.sampled;
  return without * (all - pdfs - flights) > square * all;
}

}  // namespace

std::shared_ptr<const EmissionSetup> choose_fire_lights(const RenderPlan& plan) {
  if (pays_to_sample_fires(plan)) return plan.emission;
  auto without = std::make_shared<EmissionSetup>(*plan.emission);
  without->sampled_in_volumes = false;
  return without;
}

}  // namespace pvol::detail
