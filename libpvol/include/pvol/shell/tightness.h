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
/// isotropic and uniform in the world that the map leads to, so that a hit ratio's standard error
/// is about sqrt(r / lines) with the box's hit ratio r; where no line meets a cell, as for two
/// voxels far apart, one is taken to. From a fixed seed, in parallel; the same for any number of
/// threads.
[[nodiscard]] ShellTightness measure_tightness(const Shell& shell, const Support& support,
                                               std::uint64_t lines = kTightnessLines,
                                               const Affine& index_to_world = {});

/// The first and last t >= 0 at which a ray given in index space is in an occupied cell, exactly
/// but for rounding; nothing if it meets none.
[[nodiscard]] std::optional<Span> first_and_last(const Support& support, const Ray& ray);

}  // namespace pvol
