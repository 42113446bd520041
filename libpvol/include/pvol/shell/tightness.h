// How tight a shell is: volumes, and the rays that it lets in for nothing.
#pragma once

#include <cstdint>
#include <optional>

#include "pvol/math/affine.h"
#include "pvol/math/box.h"
#include "pvol/shell/shell.h"
#include "pvol/shell/support.h"

namespace pvol {

inline constexpr std::uint64_t kTightnessLines = 1 << 17;

/// Measures a shell against its support, which is not empty.
///
/// Volume: bounds decide boxes as a whole; single cells that they leave undecided, or cubes of at
/// least 1/512 of the longest side, count by 2^3 points. Hits: `lines` lines that meet the box,
/// isotropic and uniform in the world that the map leads to; where no line meets a cell, as for two
/// voxels far apart, one is taken to. From a fixed seed, in parallel; the same for any number of
/// threads.
[[nodiscard]] ShellTightness measure_tightness(const Shell& shell, const Support& support,
                                               std::uint64_t lines = kTightnessLines,
                                               const Affine& index_to_world = {});

/// The standard error of a hit ratio h, of the shell or of the box, from so many lines, of which
/// lines / r meet a cell, r being the box's ratio: sqrt(h (h - 1) r / lines), that of a quotient of
/// two counts of which one is part of the other. None where fewer than 30 lines meet a cell.
[[nodiscard]] std::optional<double> standard_error_of_hits(double hit_ratio, double box_hit_ratio,
                                                           std::uint64_t lines = kTightnessLines);

/// The first and last t >= 0 at which a ray given in index space is in an occupied cell, exactly
/// but for rounding; nothing if it meets none.
[[nodiscard]] std::optional<Span> first_and_last(const Support& support, const Ray& ray);

}  // namespace pvol
