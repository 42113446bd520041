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

struct RenderResult {
  Film film;
  Counts counts;             ///< all zero unless options.count or AOVs ask for them
  bool guided = false;       ///< whether paths were guided: where light reached what is seen
  double guide_seconds = 0;  ///< CPU time of the process for finding out by what
  bool complete = true;      ///< false where `progress` stopped it; pixels then hold fewer samples
};

/// Renders what was planned. The same plan gives the same bytes for any number of threads, unless
/// time is limited. Throws Error for lights beyond single precision.
[[nodiscard]] RenderResult render(const RenderPlan& plan, const Progress& progress = {},
                                  const PassDone& pass_done = {});

/// Plans without a limit on work, and renders. Several volumes may overlap.
[[nodiscard]] RenderResult render(std::span<const Volume> volumes, const Scene& scene,
                                  const Progress& progress = {});
[[nodiscard]] RenderResult render(const Volume& volume, const Scene& scene,
                                  const Progress& progress = {});

/// A camera that looks at `world_box` with all of it in view and all else as `like` has it: its
/// kind, `up`, lens and field of view, from its azimuth and elevation, and then by its zoom. The
/// front is where z is largest or, where z is up, y least. Straight from above or below the front is
/// down or up in the picture.
[[nodiscard]] Camera frame(const Box& world_box, double aspect, const Camera& like = {});

}  // namespace pvol
