// A short render that counts what collisions cost, beside what the bounds lead to expect.
#pragma once

#include <cstdint>
#include <optional>

#include "pvol/render/film.h"
#include "pvol/render/scene.h"
#include "pvol/render/shell_choice.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/volume.h"

namespace pvol::measure {

/// A ratio of two counts, and the half width of its 95 % interval: from how the counts of several
/// renders with seeds of their own scatter around it (the delta method, Student's t).
struct CountRatio {
  double value = 0, half_width = 0;
};

/// What paths did with one way of deciding collisions.
struct PathCosts {
  Counts counts;
  CountRatio lookups;             ///< per real collision
  double tentative = 0;           ///< tentative collisions per real one
  double bounds_tests = 0;        ///< per real collision
  double segments = 0;            ///< per real collision
  std::uint64_t micro_bytes = 0;  ///< of the micro-bounds used
};

struct Probe {
  double extinction = 0;
  VolumeFacts facts;
  PathCosts delta, decomposition, squeezed;  ///< the last with micro-bounds of 2^3 cells
  double squeezed_expected = 0;  ///< its look-ups per collision that lies as the density does
  Film film;                     ///< of decomposition, with counts for each pixel
};

struct ProbeOptions {
  std::optional<double> extinction;  ///< per world unit and unit of density; else see below
  int width = 160;                   ///< of the picture; its height follows the cloud's shape
  std::uint32_t samples = 8;         ///< a pixel; rounded up to a multiple of 8, for eight renders
  Rgb albedo{0.99f};
  double g = 0;
};

/// Renders the cloud from the front, all in view, under an even sky; camera paths only, without
/// shadow rays. Without an extinction, that with which the mean optical thickness along the axes is
/// 10 on average: a cloud one cannot see through, whose core some paths still reach. The pyramid is
/// not empty. Throws Error as make_volume and render do.
[[nodiscard]] Probe probe(const VoxelGrid& grid, const Pyramid& pyramid,
                          const ProbeOptions& options = {});

/// What a shell costs camera rays and saves them.
struct ShellProbe {
  double extinction = 0;
  ShellEstimate estimate;      ///< by the cost model, for this camera
  std::uint64_t rays = 0;      ///< of the camera
  CountRatio rejected;         ///< of those that meet the box
  Counts with_shell, without;  ///< of the same render: the paths are the same
};

/// The same render by decomposition, once with the shell and once without.
[[nodiscard]] ShellProbe probe_shell(const VoxelGrid& grid, const Pyramid& pyramid,
                                     const Shell& shell, const ProbeOptions& options = {});

}  // namespace pvol::measure
