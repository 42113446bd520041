// Where the sun is in the sky of a place and time.
#pragma once

#include <optional>
#include <string_view>

namespace pvol {

/// The days since noon of 1 January 2000 UTC (the Julian date less 2451545) that a text means: ISO
/// 8601 in full, as 2024-06-21T14:30:00Z or 2024-06-21T14:30+02:00; seconds may have a fraction, or
/// be left out; a blank may stand for the T. Nothing for any other text, for dates that are not,
/// and for years before 1800 or after 2200.
[[nodiscard]] std::optional<double> parse_date(std::string_view text);

/// In degrees.
struct SunPosition {
  double elevation;  ///< of its centre above the horizon
  double azimuth;    ///< from north through east, in [0, 360)
};

/// Without the refraction of air, for an observer at sea level. Latitude is positive in the north,
/// longitude in the east. By the low-precision theory of Meeus (Astronomical Algorithms, 1998,
/// chapters 12, 13, 22, 25): within 0.015 degrees from 1950 to 2050, and 0.05 from 1800 to 2200.
[[nodiscard]] SunPosition sun_position(double days, double latitude, double longitude);

/// By how many degrees air of 1010 hPa and 10 degrees Celsius lifts what is at this elevation
/// without it: the fits of NOAA's solar calculator, which fade out below the horizon.
[[nodiscard]] double refraction(double elevation);

}  // namespace pvol
