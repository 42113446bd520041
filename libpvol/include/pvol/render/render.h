// Path tracing of one cloud.
#pragma once

#include <functional>
#include <span>

#include "pvol/render/film.h"
#include "pvol/render/scene.h"
#include "pvol/volume/volume.h"

namespace pvol {

/// Called between batches of work, from one thread at a time, with finished and total camera
/// samples; returning false stops the render, and what is finished is kept.
using Progress = std::function<bool(std::uint64_t done, std::uint64_t total)>;

struct RenderResult {
  Film film;
  Counts counts;             ///< all zero unless options.count
  bool guided = false;       ///< whether paths were guided by importance
  double guide_seconds = 0;  ///< CPU time of the process for finding out by what
  bool complete = true;      ///< false where `progress` stopped it; pixels then hold fewer samples
};

/// Renders the scene with the volume that `make_volume` made for it. The same scene gives the same
/// bytes for any number of threads. Throws Error for options out of range (sizes, crops, albedo, g,
/// degenerate cameras), and for regular tracking or transmittance of tricubic or procedural fields.
[[nodiscard]] RenderResult render(const Volume& volume, const Scene& scene,
                                  const Progress& progress = {});

/// The same for several volumes, which may overlap. Throws Error for several and a weighted
/// tracker.
[[nodiscard]] RenderResult render(std::span<const Volume> volumes, const Scene& scene,
                                  const Progress& progress = {});

/// A camera that looks at `world_box` from the front and slightly above, with all of it in view.
[[nodiscard]] Camera frame(const Box& world_box, double aspect);

/// Rough number of scatterings of a path that enters a cloud of this mean optical thickness: with
/// albedo 1 it grows without limit, and so does the time of a picture (THEORY.md, T6.1).
[[nodiscard]] double estimate_scatterings(double optical_thickness, double albedo);

}  // namespace pvol
