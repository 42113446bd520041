#include "render/engine/passes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pvol::detail {

Passes::Passes(const RenderOptions& options, std::size_t pixels)
    : adaptive_(is_adaptive(options)),
      pilot_only_(adaptive_ && options.part_end > 0),
      samples_(options.part_end > 0 ? options.part_end - options.part_begin : options.samples),
      noise_(options.noise),
      time_(options.time),
      least_(options.aovs.has(Aov::halves) ? 2 : 1) {
  if (pilot_only_) samples_ = kPilot;
  if (!adaptive_ || pilot_only_) total_ = std::uint64_t(pixels) * samples_;
}

void Passes::resume(const Film& film) {
  uniform_ = std::numeric_limits<std::uint32_t>::max();
  for (const PixelSums& p : film.pixels) uniform_ = std::min(uniform_, p.samples);
}

std::optional<SampleTargets> Passes::next(Film& film, double seconds) {
  if (!adaptive_ || pilot_only_) return next_equal(film, samples_);
  measure(film, seconds);
  if (time_ && done_ > 0) total_ = std::uint64_t(done_ + affordable());
  if (uniform_ < kPilot && !film.needs) {
    if (std::optional<SampleTargets> targets = next_equal(film, kPilot)) return targets;
    total_ = std::uint64_t(done_);
    return std::nullopt;
  }
  return next_adaptive(film);
}

/// Counts what is done and how fast the last pass was.
void Passes::measure(const Film& film, double seconds) {
  double done = 0;
  for (const PixelSums& p : film.pixels) done += p.samples;
  // The clock may not have moved during a short pass.
  const double took = std::max(seconds - seconds_, 1e-9);
  if (done > done_) speed_ = (done - done_) / took;
  seconds_ = seconds, done_ = done;
}

/// Samples for which there is time left.
double Passes::affordable() const {
  if (!time_) return std::numeric_limits<double>::infinity();
  return std::max(0.0, *time_ - seconds_) * speed_;
}

/// As many samples again as there are, 16 at most, and as there is time for. The first ones are
/// taken whatever the time: one in each pixel, or one for each half of the samples, which a filter
/// needs.
std::optional<SampleTargets> Passes::next_equal(const Film& film, std::uint32_t end) {
  std::uint32_t more = std::min(std::clamp(uniform_, 1u, kMostOfEqualPass), end - uniform_);
  if (uniform_ >= least_) {
    const double paid = std::floor(affordable() / double(film.pixels.size()));
    more = std::uint32_t(std::min(double(more), paid));
  }
  if (more == 0) return std::nullopt;
  uniform_ += more;
  return SampleTargets{uniform_, {}};
}

std::optional<SampleTargets> Passes::next_adaptive(Film& film) {
  if (!film.needs) film.needs = find_adaptive_samples(film, noise_);
  if (noise_) {
    double sum = 0;
    for (std::size_t i = 0; i < film.pixels.size(); ++i) sum += samples_of(film, i, kMostSamples);
    total_ = std::uint64_t(std::min(sum, done_ + affordable()));
  }
  const bool late = time_ && seconds_ >= *time_;
  if (!late) {
    // A film that goes on may be beyond the first goals.
    do {
      if (std::optional<SampleTargets> targets = towards_goal(film)) return targets;
    } while (raise_goal(film));
  }
  total_ = std::uint64_t(done_);
  return std::nullopt;
}

/// Samples that a pixel is to have where the average is this; never fewer than the pilot's.
double Passes::samples_of(const Film& film, std::size_t pixel, double average) const {
  const double wanted = std::min(average, film.needs->samples[colour_of(film, pixel)]);
  return std::max(double(kPilot), std::round(wanted * double(film.needs->share[pixel])));
}

/// Twice as many samples, if there is time and need for them. Half of the time left at most goes
/// into one step, whose speed is not known before.
bool Passes::raise_goal(const Film& film) {
  constexpr double kLeast = 0.02;  // more samples, as a share of those at hand, worth a pass
  const double most = *std::max_element(film.needs->samples.begin(), film.needs->samples.end());
  if (most <= 0) return false;
  if (goal_.empty() && most < average_) {
    average_ = most;  // few pixels are noisy: the goal is below the pilot's average
  } else {
    const double step = std::min(average_, 0.5 * affordable() / double(film.pixels.size()));
    const double before = average_;
    average_ = std::min(average_ + step, most);
    if (!(average_ > before * (1 + (average_ < most ? kLeast : 0)))) return false;
  }
  goal_.resize(film.pixels.size());
  for (std::size_t i = 0; i < goal_.size(); ++i) {
    goal_[i] = std::uint32_t(std::min(samples_of(film, i, average_), double(kMostOfPixel)));
  }
  return true;
}

/// The next pass on the way to the goal; none where that is reached.
std::optional<SampleTargets> Passes::towards_goal(const Film& film) const {
  SampleTargets targets;
  bool any = false;
  for (std::size_t i = 0; i < goal_.size(); ++i) {
    const std::uint32_t has = film.pixels[i].samples;
    targets.each.push_back(std::clamp(std::max(goal_[i], has), has, has + kMostOfPass));
    any = any || targets.each.back() > has;
  }
  return any ? std::optional(std::move(targets)) : std::nullopt;
}

}  // namespace pvol::detail
