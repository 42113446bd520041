// Path tracing of clouds.
#pragma once

#include <functional>
#include <span>

#include "pvol/render/film.h"
#include "pvol/render/plan.h"
#include "pvol/render/scene.h"
#include "pvol/volume/volume.h"

namespace pvol {

/// Called with finished and total camera samples, the latter 0 as long as it cannot be foreseen
/// (where noise is limited, not samples), from one thread at a time but not always the same
/// one: between batches of work and, however long those take, ten times a second. Returning false
/// stops the render, and what is finished is kept; what it throws, render throws.
using Progress = std::function<bool(std::uint64_t done, std::uint64_t total)>;

/// Called with the film between passes over the picture, while no thread works on it. The first
/// pass is of one sample in each pixel, later ones are of more. What it throws, render throws.
using PassDone = std::function<void(const Film& film)>;

/// CPU time that a render takes on this machine, estimated by timing a few of its camera paths,
/// with the same guide, kernel and threads: within a factor of 1.3 on an idle machine, mostly.
struct TimeForecast {
  double guide_seconds = 0;   ///< CPU time of making the guide, which has been spent by then
  double sample_seconds = 0;  ///< mean CPU time of a camera sample; 0 where none was timed
  double samples = 0;         ///< to be rendered; by expected_samples where they are adaptive
  int threads = 1;            ///< that share the work
  double own_seconds = 0;     ///< CPU time of the paths that were timed, beyond those of the render

  [[nodiscard]] double cpu_seconds() const { return guide_seconds + sample_seconds * samples; }
};

/// Who looks at a render while it goes on.
struct RenderCallbacks {
  Progress progress{};
  PassDone pass_done{};
  /// Asked as often as `progress` is told, if there is one. Where it returns true, threads end the
  /// tiles that they are at, and `pass_done` sees the film in the middle of a pass: pixels of one
  /// that is not adaptive yet then differ in their samples.
  std::function<bool()> wants_film{};
  /// Called once, between the guide and the first sample. No path is timed where it is empty.
  std::function<void(const TimeForecast&)> forecast{};
};

struct RenderResult {
  Film film;
  Counts counts;             ///< all zero unless options.count or AOVs ask for them
  bool guided = false;       ///< whether paths were guided: where light reached what is seen
  double guide_seconds = 0;  ///< CPU time of the process for finding out by what
  bool complete = true;      ///< false where `progress` stopped it; pixels then hold fewer samples
  std::uint64_t goal = 0;    ///< samples of the whole render, as far as they were foreseen, or 0
};

/// Renders what was planned. The same plan gives the same bytes for any number of threads, unless
/// time is limited. Throws Error for lights beyond single precision.
[[nodiscard]] RenderResult render(const RenderPlan& plan, const Progress& progress = {},
                                  const PassDone& pass_done = {});

/// The same for a film that an earlier render of this plan began, or nobody (an empty one): that
/// render may have been stopped anywhere, and together they give the bytes of one. `film` is the
/// plan's part of the image, with `sums`, the plan's layers and, if adaptive, perhaps `needs` and
/// more samples than the plan wants. It includes counts of an adaptive picture's pilot. Throws
/// Error for other films and for deep ones.
[[nodiscard]] RenderResult resume(const RenderPlan& plan, Film film,
                                  const RenderCallbacks& callbacks);

/// What render(plan) would take: makes the guide and times paths, about 20 ms of them for each
/// thread or 1 % of the render. Throws Error for lights beyond single precision.
[[nodiscard]] TimeForecast forecast_time(const RenderPlan& plan);

/// The part of a pilot from which an adaptive plan continues: `pilot` is of the whole picture, of
/// which the plan's crop is a part, with kPilot samples in each pixel and their counts. The result
/// has the needs of the whole. Throws Error for another film.
[[nodiscard]] Film begin_by_pilot(const RenderPlan& plan, const Film& pilot);

/// Plans without a limit on work, and renders. Several volumes may overlap.
[[nodiscard]] RenderResult render(std::span<const Volume> volumes, const Scene& scene,
                                  const Progress& progress = {});
[[nodiscard]] RenderResult render(const Volume& volume, const Scene& scene,
                                  const Progress& progress = {});

}  // namespace pvol
