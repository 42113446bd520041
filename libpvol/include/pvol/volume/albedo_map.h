// How a grid of a cloud varies its albedo: what users say of it.
#pragma once

#include <optional>
#include <string>

#include "pvol/math/color_ramp.h"
#include "pvol/math/field_map_keys.h"
#include "pvol/volume/medium_keys.h"

namespace pvol {

/// A colour in [0, 1] at each place, by which the albedo of every component is multiplied there. A
/// grid of colours is taken as it is. A grid of numbers, which is 0 where it says nothing, is
/// mapped; the map's value is the colour's, or where the ramp says one. THEORY.md, T5.14.
struct AlbedoMap {
  std::string grid{};  ///< of the file; "": by the usual names
  FieldMap map{};      ///< of a grid of numbers
  ColorRamp colors{};  ///< along what the map makes of them
  friend bool operator==(const AlbedoMap&, const AlbedoMap&) = default;

  /// Whether a key is set that grids of colours have no use for.
  [[nodiscard]] bool is_of_numbers() const { return !map.is_identity() || !colors.empty(); }
};

template <std::same_as<AlbedoMap> A>
[[nodiscard]] constexpr auto keys(const A&) {
  return std::to_array<Key<A>>({
      key<&A::grid>({.key = "grid",
                     .metavar = "NAME",
                     .limits = any_text(),
                     .help = "Grid of colours or of numbers by which the albedo is multiplied; "
                             "none: the albedo is the same everywhere",
                     .otherwise = "Cd, color, colour or albedo"}),
      Key<A>{{.key = ""},
             nullptr,
             nullptr,
             [](A& a) { return entries(a.map); },
             [](const A& a) { return entries(a.map); }},
      key<&A::colors>({.key = "colors",
                       .metavar = "X,R,G,B",
                       .limits = number().times(4).in_rows().also(expect_points),
                       .help = "Colours for the mapped values of a grid of numbers, by rows",
                       .otherwise = "the mapped value, a grey"}),
  });
}

/// Colours that are none of an albedo.
[[nodiscard]] std::optional<Misfit> misfit(const AlbedoMap& map);

/// The colour that a number stands for, each channel in [0, 1].
[[nodiscard]] Rgb color_of(const AlbedoMap& map, float value);

/// At least the colours of all values in [0, most], channel by channel.
[[nodiscard]] Rgb largest_color(const AlbedoMap& map, float most);

/// Throws Error, which says what is wrong, for values out of range.
void validate(const AlbedoMap& map);

}  // namespace pvol
