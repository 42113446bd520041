// Measuring several settings in turn within a budget of time, whatever renders them (THEORY.md,
// T9.2).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pvol/render/film.h"

namespace pvol::measure {

/// What a setting takes besides its samples.
struct SetUp {
  double seconds = 0;  ///< CPU time up to the first sample: bounds, bricks, micro-bounds
  std::uint64_t field_bytes = 0, octree_bytes = 0, micro_bytes = 0;  ///< in memory
  int depth = 0;                                                     ///< of the octree's cut
  [[nodiscard]] std::uint64_t bytes() const { return field_bytes + octree_bytes + micro_bytes; }
};

/// One render of one setting.
struct RunRequest {
  std::size_t setting = 0;
  std::uint32_t samples = 1;  ///< a pixel
  std::uint64_t seed = 1;
  bool count = false;       ///< look-ups and the like; the time then does not matter
  bool pilot = false;       ///< only its cost is wanted: a much smaller picture will do
  double most_seconds = 0;  ///< of the clock; stop after that
};

struct Run {
  Film film;
  Counts counts;
  SetUp set_up;
  double seconds = 0;  ///< CPU time of the samples
  std::optional<std::uint64_t> instructions;
  bool complete = true;
};

/// Renders; throws Error for a setting that the scene does not allow.
using Render = std::function<Run(const RunRequest&)>;

/// What all rounds of a setting gave.
struct Measured {
  std::string left_out;  ///< why there are no figures; empty where there are
  Film film;             ///< all samples together
  SetUp set_up;
  Counts counts;  ///< of `counted` samples
  std::uint64_t counted = 0;
  Film counted_film;                   ///< with look-ups by pixel
  std::vector<int> round;              ///< which one each of the following is of, ascending
  std::vector<double> seconds;         ///< CPU time of a sample, by round
  std::vector<double> variance;        ///< of a sample, by round
  std::vector<double> set_up_seconds;  ///< by round
  std::vector<double> instructions;    ///< of a sample, by round; empty where not counted
  std::uint32_t samples = 0;           ///< a pixel, in one round
  [[nodiscard]] int rounds() const { return int(seconds.size()); }
};

struct SweepOptions {
  double budget = 300;                    ///< seconds of the clock
  int rounds = 7;                         ///< at most; the first one counts instead of being timed
  std::uint32_t most_samples = 1u << 16;  ///< a pixel and round
  std::uint64_t seed = 1;
  std::uint64_t pixels = 1;           ///< of the picture
  std::function<double()> clock;      ///< seconds since any time
  std::function<bool()> interrupted;  ///< measure no more
  /// Settings that are measured even where they do what the first one does, to the last bit and
  /// count: they are left out else. Absent: all of them.
  std::function<bool(std::size_t setting)> always{};
  /// What the error about a budget that is too short tells the user to do.
  std::string remedy = "raise the budget or make the picture smaller";
  /// Told before each render: what comes next ("round 2 of 6: depth 4"), and seconds left.
  std::function<void(const std::string& next, double seconds_left)> progress;
};

/// What a pilot render says of a setting, in seconds of the clock.
struct PilotCost {
  double set_up = 0, sample = 0;
};

/// How a setting is to be measured: `rounds` times `samples` a pixel, the first one counted; no
/// rounds where its share is too short for four of two samples, which it takes for an error.
struct Plan {
  int rounds = 0;
  std::uint32_t samples = 0;
  double seconds = 0;  ///< that it should take in all
};
[[nodiscard]] Plan plan_rounds(const PilotCost& cost, double share, const SweepOptions& options);

/// Measures settings of these names, the first of which is the one that the others are compared
/// with. A small pilot render of each shows what it costs; each gets an equal share of the time
/// left, the first one more where it needs it, and they are rendered in turn, round by round, each
/// time with another seed; settings for whose pilots the time does not suffice are left out. No
/// render begins that would not end within the budget, and one that takes too long is stopped, so
/// that the whole takes hardly more than the budget. Interrupted, it returns what was measured
/// until then, in whole rounds. Throws Error where the first setting cannot be measured in it, and
/// what `render` throws for the first.
[[nodiscard]] std::vector<Measured> sweep(const std::vector<std::string>& names,
                                          const SweepOptions& options, const Render& render);

/// What a sweep is judged against: setting 0 rendered for about the budget, in whole films of more
/// and more samples a pixel with seeds from `options.seed` on, added up. `pixels`, `rounds` and
/// `progress` do not count. Throws Error where two samples a pixel take
/// longer.
[[nodiscard]] Film render_reference(const SweepOptions& options, const Render& render);

}  // namespace pvol::measure
