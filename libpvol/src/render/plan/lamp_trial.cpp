#include "render/plan/lamp_trial.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "render/path/lamps_along.h"
#include "render/path/path_setup.h"
#include "render/plan/camera_probe.h"
#include "render/plan/forecast.h"

namespace pvol::detail {
namespace {

constexpr double kAsk = 1.5e-7;  // seconds of asking a lamp along a flight, besides its shadow ray

struct PixelSamples {
  double sum = 0, squares = 0;
  int count = 0;

  /// Of a sample.
  [[nodiscard]] double variance() const {
    return count > 1 ? std::max(0.0, squares - sum * sum / count) / (count - 1) : 0;
  }
};

struct Trial {
  std::vector<PixelSamples> pixels{};
  double seconds = 0;  ///< of a path, without what asking lamps along its flights takes
  int paths = 0;
};

Trial follow(const PathSetup& setup, int passes) {
  Trial trial;
  CameraProbe probe;
  const auto visit = [&](const Film& film, std::size_t pixel) {
    trial.pixels.resize(film.pixels.size());
    const double value = luminance(mean(film.pixels[pixel]));
    PixelSamples& p = trial.pixels[pixel];
    p.sum += value, p.squares += value * value, ++p.count;
  };
  follow_paths(setup, passes * kRaysAlong * kRaysAlong, probe, visit);
  trial.seconds = share_of_time(setup.kernel) * seconds_of(probe.counts, probe.paths) /
                  std::max(1, probe.paths);
  trial.paths = probe.paths;
  return trial;
}

/// The mean over the pixels of the variance of a sample.
double noise_of(const Trial& trial) {
  double sum = 0;
  for (const PixelSamples& p : trial.pixels) sum += p.variance();
  return sum / std::max<double>(1, double(trial.pixels.size()));
}

/// By which the square of a path's luminance is less on average, by what the pilot noted; no path
/// decides alone.
double saved_by(const LampPilot& pilot, const PathSetup& setup, int paths) {
  constexpr std::uint64_t kKey = 0x6c616d7073;
  double all = 0, most = 0;
  for (std::size_t i = 0; i < pilot.asked.size(); ++i) {
    const LampPilot::Asked& a = pilot.asked[i];
    Rng rng(kKey, 0, i);
    if (setup.surfaces && setup.surfaces->hide(a.towards, a.distance, 0)) continue;
    const double depth = sample_depth(setup, a.towards, a.distance, rng).value_or(0);
    const double saved = a.saved * std::exp(-depth);
    all += saved, most = std::max(most, saved);
  }
  return (all - most) / std::max(1, paths);
}

}  // namespace

LampTrial try_lamps(const RenderPlan& plan, int passes) {
  RenderPlan plain = plain_plan_of_whole(plan);
  const Trial without = follow(PathSetup(plain), passes);
  plain.line_lamps = plan.line_lamps;
  PathSetup setup(plain);
  LampPilot pilot;
  setup.lamp_pilot = &pilot;
  const Trial with = follow(setup, passes);
  // Most of what is saved comes rarely: few of the paths without would see it.
  const double own = noise_of(with);
  const double other = std::max(noise_of(without), own + saved_by(pilot, setup, with.paths));
  const double asking = kAsk * double(pilot.flights) / std::max(1, with.paths);
  return {own, other, (with.seconds + asking) / without.seconds};
}

}  // namespace pvol::detail
