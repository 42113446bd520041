// Light that a grid of a cloud emits: flames, hot gas, lava, glowing fog.
#pragma once

#include <optional>
#include <string>

#include "pvol/math/color_ramp.h"
#include "pvol/math/color_space.h"
#include "pvol/math/field_map_keys.h"
#include "pvol/volume/medium_keys.h"

namespace pvol {

/// Emission of its own, apart from the extinction: per unit length
///   intensity x map(field) x color x (color of the body or ramp at the value of color_by).
/// How bright it is and which colour it has are two questions, and simulations answer them by two
/// grids. THEORY.md, T5.11.
struct Fire {
  std::string field{};     ///< name of a grid; "": flames, else what else the file has (formats)
  FieldMap map{};          ///< of its values
  double intensity = 1;    ///< radiance per world unit where the map is 1, >= 0
  Rgb color{1.0f};         ///< factor
  std::string color_by{};  ///< another grid that says the colour; "": temperature, else `field`
  /// Temperature in Kelvin where color_by is 1; none: no black body's colour.
  std::optional<double> kelvin{};
  /// The temperature at which the intensity is as said; elsewhere it goes with the fourth power of
  /// the temperature (Stefan-Boltzmann). None: the intensity is apart from the temperature.
  std::optional<double> kelvin_of_intensity{};
  ColorRamp colors{};                           ///< along the values of color_by
  ColorSpace color_space = ColorSpace::rec709;  ///< of `color`, `colors` and the black body
  friend bool operator==(const Fire&, const Fire&) = default;

  /// Whether colours take a field's value.
  [[nodiscard]] bool colored() const { return kelvin.has_value() || !colors.empty(); }
};

inline constexpr Range kKelvinRange{0, 1e9, true, false};

template <std::same_as<Fire> F>
[[nodiscard]] constexpr auto keys(const F&) {
  return std::to_array<Key<F>>({
      key<&F::field>({.key = "field",
                      .metavar = "NAME",
                      .limits = any_text(),
                      .help = "Grid of the emission's strength",
                      .otherwise = "flames, flame, fire, burn, emission, heat or temperature"}),
      Key<F>{{.key = ""},
             nullptr,
             nullptr,
             [](F& f) { return entries(f.map); },
             [](const F& f) { return entries(f.map); }},
      key<&F::intensity>({.key = "intensity",
                          .metavar = "X",
                          .limits = number(kRadianceRange),
                          .help = "Radiance emitted per world unit where the mapped value is 1",
                          .otherwise = "chosen for the cloud, and printed"}),
      key<&F::color>({.key = "color",
                      .metavar = "RGB",
                      .limits = number(kRadianceRange).or_three(),
                      .help = "Factor on the emitted radiance"}),
      key<&F::color_by>({.key = "color_by",
                         .metavar = "NAME",
                         .limits = any_text(),
                         .help = "Grid to which kelvin and colors apply",
                         .otherwise = "temperature, else that of field"}),
      key<&F::kelvin>({.key = "kelvin",
                       .metavar = "K",
                       .limits = number(kKelvinRange),
                       .help = "Emit the colour of a black body, which has this temperature where "
                               "color_by is 1; set it to 1 for values in Kelvin",
                       .otherwise = "no black body"}),
      key<&F::kelvin_of_intensity>(
          {.key = "kelvin_of_intensity",
           .metavar = "K",
           .limits = number(kKelvinRange),
           .help = "Temperature at which the emission has the given intensity; it grows with the "
                   "fourth power of temperature (Stefan-Boltzmann)",
           .otherwise = "independent of temperature"}),
      key<&F::colors>({.key = "colors",
                       .metavar = "X,R,G,B",
                       .limits = number().times(4).in_rows().also(expect_points),
                       .help = "Colours for the values of color_by, by rows"}),
  });
}

/// Kelvins of what is no black body, or colours of two kinds.
[[nodiscard]] std::optional<Misfit> misfit(const Fire& fire);

/// The radiance per unit length of the field's value and that of color_by.
[[nodiscard]] Rgb emission(const Fire& fire, float value, float color_value);

/// Throws Error, which says what is wrong, for values out of range.
void validate(const Fire& fire);

}  // namespace pvol
