// The sky of clear air, by day and at dusk.
#pragma once

#include <optional>
#include <string>

#include "pvol/math/keys.h"
#include "pvol/math/vec.h"

namespace pvol {

/// Light of the sun that air and ground scatter, seen from the ground, and the sun itself as far as
/// it gets through (THEORY.md, T5.16). The planet is a ball, its air without clouds. The sun is
/// at the angles given or where it was at a date: then as the eye sees it, lifted by refraction
/// (sun_position.h). Below the horizon it leaves a dusk that fades; from 18 degrees on all is
/// black.
struct ClearSky {
  static constexpr const char* kName = "clear";
  std::optional<double> elevation{};  ///< of the sun in degrees; none: by date, or 37
  std::optional<double> azimuth{};    ///< from north through east, degrees; none: by date, or 245
  std::string date{};                 ///< as `parse_date` takes it; empty: none
  std::optional<double> latitude{};   ///< degrees, north positive; goes with the date
  std::optional<double> longitude{};  ///< degrees, east positive; goes with the date
  double turbidity = 2;               ///< aerosols, of optical depth 0.1 (turbidity - 1) at 550 nm
  double ozone = 300;                 ///< Dobson units
  Rgb ground{0.2f};                   ///< albedo of the ground
  double irradiance = 4;              ///< luminance of the sun's irradiance above the air
  bool sun = true;                    ///< whether the sun shines, beside the sky
  Vec3d up{0, 1, 0};
  Vec3d north{0, 0, -1};  ///< what it has across `up` counts; east is on its right
  friend bool operator==(const ClearSky&, const ClearSky&) = default;
};

/// What was expected of a date, or null.
[[nodiscard]] const char* expect_date(const Value& value);

template <std::same_as<ClearSky> S>
[[nodiscard]] constexpr auto keys(const S&) {
  return std::to_array<Key<S>>({
      key<&S::elevation>(
          {.key = "elevation",
           .metavar = "DEGREES",
           .limits = number(Range::closed(-90, 90)).or_word("none"),
           .help = "Elevation of the sun above the horizon in degrees; below -18 it is night",
           .otherwise = "none: computed from date, else 37"}),
      key<&S::azimuth>({.key = "azimuth",
                        .metavar = "DEGREES",
                        .limits = number(Range::closed(-360, 360)).or_word("none"),
                        .help = "Azimuth of the sun in degrees, from north towards east",
                        .otherwise = "none: computed from date, else 245"}),
      {{.key = "date",
        .metavar = "TIME",
        .limits = any_text().also(expect_date),
        .help =
            "Replaces elevation and azimuth: date and time from which the sun's position at "
            "latitude and longitude is computed, e.g. 2024-06-21T14:30:00+02:00, or with Z for UTC",
        .otherwise = "none"},
       [](const S& s) { return s.date.empty() ? Value() : Value(s.date); },
       [](S& s, const Value& v) { s.date = *v.word(); }},
      key<&S::latitude>({.key = "latitude",
                         .metavar = "DEGREES",
                         .limits = number(Range::closed(-90, 90)).or_word("none"),
                         .help = "Latitude in degrees, used with date; north is positive",
                         .otherwise = "none"}),
      key<&S::longitude>({.key = "longitude",
                          .metavar = "DEGREES",
                          .limits = number(Range::closed(-360, 360)).or_word("none"),
                          .help = "Longitude in degrees, used with date; east is positive",
                          .otherwise = "none"}),
      key<&S::turbidity>({.key = "turbidity",
                          .metavar = "X",
                          .limits = number(Range::closed(1, 20)),
                          .help = "Haze: 1 is pure air, 2 clear, 4 hazy, 10 thick; aerosols have "
                                  "the optical depth 0.1 (turbidity - 1) at 550 nm"}),
      key<&S::ozone>({.key = "ozone",
                      .metavar = "DU",
                      .limits = number(Range::closed(0, 1000)),
                      .help = "Ozone in Dobson units; it keeps the sky blue at dusk"}),
      key<&S::ground>(
          {.key = "ground",
           .metavar = "RGB",
           .limits = number(Range::closed(0, 1)).or_three(),
           .help = "Albedo of the ground, which lights the air and is visible below the horizon"}),
      key<&S::irradiance>(
          {.key = "irradiance",
           .metavar = "X",
           .limits = number(Range::closed(0, 1e29)),
           .help = "Irradiance of a plane that faces the sun outside the atmosphere; it scales all "
                   "light of the sky, and 133300 yields candela per square metre"}),
      key<&S::sun>(
          {.key = "sun", .help = "Whether the sun itself shines, as a disc of 0.53 degrees"}),
      key<&S::up>({.key = "up",
                   .metavar = "XYZ",
                   .limits = direction(),
                   .help = "Direction of the zenith"}),
      key<&S::north>({.key = "north",
                      .metavar = "XYZ",
                      .limits = direction(),
                      .help = "Direction of north, from which azimuths are measured"}),
  });
}

/// A date without its place, or with angles that it tells itself; a place without a date; north
/// along up.
[[nodiscard]] std::optional<Misfit> misfit(const ClearSky& sky);

}  // namespace pvol
