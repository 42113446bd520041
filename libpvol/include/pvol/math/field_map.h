// From the values of a grid to what they mean: density, emission, a share of either.
#pragma once

#include <array>
#include <optional>

#include "pvol/math/keys.h"
#include "pvol/math/ramp.h"

namespace pvol {

/// y = ramp(clamp(scale v + offset) ^ power), at least 0; each step that is not asked for is left
/// out. Powers are of what is at least 0. Each step but the ramp never falls, or never rises, as
/// its argument rises: the range of the map over a range of values is known exactly (THEORY.md,
/// T1.5).
struct FieldMap {
  double scale = 1, offset = 0;
  std::optional<std::array<double, 2>> clamp{};  ///< least and most
  double power = 1;                              ///< above 0
  Ramp ramp{};                                   ///< none: without points
  friend bool operator==(const FieldMap&, const FieldMap&) = default;

  [[nodiscard]] bool is_identity() const { return *this == FieldMap{}; }
};

/// Of a finite v. Not negative; infinite where it is more than a float holds.
[[nodiscard]] float value_at(const FieldMap& map, float v);

/// Bounds on all values over [from.lo, from.hi]: the exact range, but for a factor of 1 + 2^-20 for
/// the rounding of a power and of a smooth ramp.
[[nodiscard]] ValueRange range_over(const FieldMap& map, ValueRange from);

// Rows that take more than a member.

[[nodiscard]] const char* expect_ends(const Value& value);
[[nodiscard]] const char* expect_points(const Value& value);
[[nodiscard]] Value clamp_value(const FieldMap& map);
void assign_clamp(FieldMap& map, const Value& value);
[[nodiscard]] Value ramp_value(const FieldMap& map);
void assign_ramp(FieldMap& map, const Value& value);

template <std::same_as<FieldMap> M>
[[nodiscard]] constexpr auto keys(const M&) {
  return std::to_array<Key<M>>({
      key<&M::scale>({.key = "scale",
                      .metavar = "X",
                      .limits = number(),
                      .help = "Factor on the field's values, applied first"}),
      key<&M::offset>({.key = "offset",
                       .metavar = "X",
                       .limits = number(),
                       .help = "Added to them, applied second"}),
      {{.key = "clamp",
        .metavar = "LEAST,MOST",
        .limits = number().times(2).also(expect_ends),
        .help = "Values outside are moved to these ends, applied third"},
       clamp_value,
       assign_clamp},
      key<&M::power>({.key = "power",
                      .metavar = "X",
                      .limits = number(Range{0, 64, true, false}),
                      .help = "Power of what is at least 0, applied fourth"}),
      {{.key = "ramp",
        .metavar = "X,Y",
        .limits = number().times(2).in_rows().also(expect_points),
        .help = "Points of a function through which they go, applied last"},
       ramp_value,
       assign_ramp},
      {{.key = "smooth",
        .limits = flag(),
        .help = "The ramp is a monotone cubic instead of straight lines"},
       [](const M& m) { return to_value(m.ramp.smooth); },
       [](M& m, const Value& v) { assign(m.ramp.smooth, v); }},
  });
}

}  // namespace pvol
