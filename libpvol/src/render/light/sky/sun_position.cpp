#include "pvol/render/sun_position.h"

#include <array>
#include <cmath>

#include "render/light/sky/angles.h"

namespace pvol {
namespace {

using detail::kDegree;

double sine(double degrees) { return std::sin(degrees * kDegree); }
double cosine(double degrees) { return std::cos(degrees * kDegree); }

/// Reads a text from its beginning.
struct Reader {
  std::string_view rest;

  bool take(char c) {
    if (rest.empty() || rest.front() != c) return false;
    rest.remove_prefix(1);
    return true;
  }
  /// A number of so many digits; -1 for none.
  int digits(std::size_t count) {
    if (rest.size() < count) return -1;
    int n = 0;
    for (const char c : rest.substr(0, count)) {
      if (c < '0' || c > '9') return -1;
      n = 10 * n + (c - '0');
    }
    rest.remove_prefix(count);
    return n;
  }
};

/// Days from 1 January 2000 to the beginning of a day of the Gregorian calendar; nothing for days
/// that are not.
std::optional<double> read_day(Reader& in) {
  const int year = in.digits(4);
  if (year < 1800 || year > 2200 || !in.take('-')) return std::nullopt;
  const int month = in.digits(2);
  if (month < 1 || month > 12 || !in.take('-')) return std::nullopt;
  const bool leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
  const std::array<int, 12> lengths{31, leap ? 29 : 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  const int day = in.digits(2);
  if (day < 1 || day > lengths[std::size_t(month) - 1]) return std::nullopt;
  double days = 365.0 * (year - 2000) + day - 1;
  // Leap years before this one, less those before 2000.
  const int y = year - 1;
  days += (y / 4 - y / 100 + y / 400) - (1999 / 4 - 1999 / 100 + 1999 / 400);
  for (int m = 1; m < month; ++m) days += lengths[std::size_t(m) - 1];
  return days;
}

/// A fraction after a point, where there is one; negative where no digit follows.
double read_fraction(Reader& in) {
  if (!in.take('.')) return 0;
  double value = 0, unit = 1;
  int digit = in.digits(1);
  if (digit < 0) return -1;
  for (; digit >= 0; digit = in.digits(1)) value += digit * (unit /= 10);
  return value;
}

std::optional<double> read_seconds(Reader& in) {
  const int hours = in.digits(2);
  if (hours < 0 || hours > 23 || !in.take(':')) return std::nullopt;
  const int minutes = in.digits(2);
  if (minutes < 0 || minutes > 59) return std::nullopt;
  double seconds = 0;
  if (in.take(':')) {
    const int whole = in.digits(2);
    if (whole < 0 || whole > 60) return std::nullopt;  // 60 is a leap second
    const double fraction = read_fraction(in);
    if (fraction < 0) return std::nullopt;
    seconds = whole + fraction;
  }
  return 3600.0 * hours + 60.0 * minutes + seconds;
}

/// Of local time to the east of Greenwich.
std::optional<double> read_offset(Reader& in) {
  if (in.take('Z')) return 0;
  const bool east = in.take('+');
  if (!east && !in.take('-')) return std::nullopt;
  const int hours = in.digits(2);
  if (hours < 0 || hours > 23) return std::nullopt;
  (void)in.take(':');
  const int minutes = in.digits(2);
  if (minutes < 0 || minutes > 59) return std::nullopt;
  return (east ? 1 : -1) * (3600.0 * hours + 60.0 * minutes);
}

}  // namespace

std::optional<double> parse_date(std::string_view text) {
  Reader in{text};
  const auto day = read_day(in);
  if (!day || (!in.take('T') && !in.take(' '))) return std::nullopt;
  const auto seconds = read_seconds(in);
  if (!seconds) return std::nullopt;
  const auto offset = read_offset(in);
  if (!offset || !in.rest.empty()) return std::nullopt;
  return *day + (*seconds - *offset) / 86400 - 0.5;
}

SunPosition sun_position(double days, double latitude, double longitude) {
  // Universal time for terrestrial: they differ by a minute or so, in which the sun moves by a
  // thousandth of a degree among the stars.
  const double t = days / 36525;
  const double mean_longitude = 280.46646 + t * (36000.76983 + t * 0.0003032);
  const double anomaly = 357.52911 + t * (35999.05029 - t * 0.0001537);
  const double centre = (1.914602 - t * (0.004817 + t * 0.000014)) * sine(anomaly) +
                        (0.019993 - t * 0.000101) * sine(2 * anomaly) +
                        0.000289 * sine(3 * anomaly);
  const double node = 125.04 - 1934.136 * t;  // of the moon, for nutation
  const double nutation = -0.00478 * sine(node);
  const double ecliptic = mean_longitude + centre - 0.00569 + nutation;  // with aberration
  const double obliquity =
      23.4392911 - t * (0.0130042 + t * (1.64e-7 - t * 5.04e-7)) + 0.00256 * cosine(node);
  const double ascension =
      std::atan2(cosine(obliquity) * sine(ecliptic), cosine(ecliptic)) / kDegree;
  const double declination = std::asin(sine(obliquity) * sine(ecliptic)) / kDegree;
  const double sidereal =
      280.46061837 + 360.98564736629 * days + t * t * 0.000387933 + nutation * cosine(obliquity);
  const double hour = sidereal + longitude - ascension;
  const double up =
      sine(latitude) * sine(declination) + cosine(latitude) * cosine(declination) * cosine(hour);
  const double north =
      cosine(latitude) * sine(declination) - sine(latitude) * cosine(declination) * cosine(hour);
  const double east = -cosine(declination) * sine(hour);
  constexpr double kParallax = 8.794 / 3600;
  const double elevation = std::atan2(up, std::hypot(north, east)) / kDegree;
  const double azimuth = std::atan2(east, north) / kDegree;
  return {elevation - kParallax * cosine(elevation), azimuth < 0 ? azimuth + 360 : azimuth};
}

double refraction(double elevation) {
  if (elevation > 85) return 0;
  const double h = elevation, tangent = std::tan(h * kDegree);
  double seconds = 0;
  if (h > 5) {
    const double t3 = tangent * tangent * tangent;
    seconds = 58.1 / tangent - 0.07 / t3 + 0.000086 / (t3 * tangent * tangent);
  } else if (h > -0.575) {
    seconds = 1735 + h * (-518.2 + h * (103.4 + h * (-12.79 + h * 0.711)));
  } else {
    seconds = -20.774 / tangent;
  }
  return seconds / 3600;
}

}  // namespace pvol
