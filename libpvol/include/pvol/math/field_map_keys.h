// What users set of a map of values.
#pragma once

#include "pvol/math/field_map.h"
#include "pvol/math/keys.h"

namespace pvol {

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
                       .help = "Number added to the values, applied second"}),
      {{.key = "clamp",
        .metavar = "LEAST,MOST",
        .limits = number().times(2).also(expect_ends),
        .help = "Values outside this range are moved to its ends, applied third"},
       clamp_value,
       assign_clamp},
      key<&M::power>(
          {.key = "power",
           .metavar = "X",
           .limits = number(Range{0, 64, true, false}),
           .help =
               "Power to which values are raised, negative ones counting as 0; applied fourth"}),
      {{.key = "ramp",
        .metavar = "X,Y",
        .limits = number().times(2).in_rows().also(expect_points),
        .help = "Points of a function that maps the values, applied last"},
       ramp_value,
       assign_ramp},
      {{.key = "smooth",
        .limits = flag(),
        .help = "Interpolate the ramp by a monotone cubic instead of straight lines"},
       [](const M& m) { return to_value(m.ramp.smooth); },
       [](M& m, const Value& v) { assign(m.ramp.smooth, v); }},
  });
}

}  // namespace pvol
