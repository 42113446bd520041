#include "pvol/render/daylight.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "math/turn_up.h"
#include "pvol/math/parallel.h"
#include "render/light/sky/angles.h"
#include "render/light/sky/scattered_light.h"

namespace pvol {
namespace {

using namespace detail;
constexpr double kDiameter = 0.53;  // of the sun, degrees
constexpr double kNight = -18;      // elevation of the sun from which nothing is left
constexpr int kWidth = 720, kHeight = 360;

Vec3d across(Vec3d up, Vec3d v) { return v - up * dot(v, up); }

/// Towards a point on the horizon.
Vec3d on_horizon(const ClearSky& sky, double azimuth) {
  const Vec3d up = normalize(sky.up);
  const Vec3d north = normalize(across(up, normalize(sky.north))), east = cross(north, up);
  return north * std::cos(azimuth * kDegree) + east * std::sin(azimuth * kDegree);
}

/// A sky by colours, in a table that is dense towards the horizon, by azimuths from the sun's.
class SkyTable {
 public:
  SkyTable(const ScatteredLight& light, ColorSpace space)
      : weights_(luminance_weights(space)), at_(kElevations * kAzimuths) {
    std::vector<double> azimuths;
    for (std::size_t j = 0; j < kAzimuths; ++j)
      azimuths.push_back(kPi * double(j) / (kAzimuths - 1));
    parallel_for(0, kElevations, [&](std::size_t i) {
      const double u = double(i) / (kElevations - 1);
      const auto row = light.seen(kPi / 2 * (1 - u * u), azimuths);
      for (std::size_t j = 0; j < kAzimuths; ++j) {
        at_[i * kAzimuths + j] = {seen_as(row[j].molecules, space), seen_as(row[j].aerosols, space),
                                  seen_as(row[j].rest, space)};
      }
    });
  }

  /// Radiance where the sun's irradiance above the air is 1; `to_sun` is the cosine to it.
  [[nodiscard]] Rgb at(const Atmosphere& a, double elevation, double azimuth, double to_sun) const {
    const double x = std::sqrt(elevation / (kPi / 2)) * (kElevations - 1);
    const double y = azimuth / kPi * (kAzimuths - 1);
    const std::size_t i = std::min(std::size_t(x), kElevations - 2);
    const std::size_t j = std::min(std::size_t(y), kAzimuths - 2);
    const double u = x - double(i), v = y - double(j);
    const Vec3d phases(double(phase_of_molecules(float(to_sun))),
                       double(phase_of_aerosols(a, float(to_sun))), 1);
    const auto sum = [&](std::size_t k) {
      const Parts& p = at_[k];
      return p.molecules * phases.x + p.aerosols * phases.y + p.rest * phases.z;
    };
    const std::size_t k = i * kAzimuths + j;
    return Rgb(into_gamut((sum(k) * (1 - v) + sum(k + 1) * v) * (1 - u) +
                              (sum(k + kAzimuths) * (1 - v) + sum(k + kAzimuths + 1) * v) * u,
                          weights_));
  }

 private:
  static constexpr std::size_t kElevations = 64, kAzimuths = 37;
  struct Parts {
    Vec3d molecules, aerosols, rest;
  };
  Vec3d weights_;  // of luminance
  std::vector<Parts> at_;
};

/// Fills the upper half; the sun is in the middle of the seam. Returns the irradiance of the
/// ground.
Vec3d paint(const ScatteredLight& light, const Atmosphere& a, double elevation, float unit,
            ColorSpace space, std::vector<Rgb>& pixels) {
  const SkyTable table(light, space);
  constexpr int kHalf = kHeight / 2;
  std::vector<Vec3d> lit(kHalf);
  parallel_for(0, kHalf, [&](std::size_t y) {
    const double up = kPi * (kHalf - 0.5 - double(y)) / kHeight;
    const double area =
        2 * kPi / kWidth *
        (std::cos(kPi * double(y) / kHeight) - std::cos(kPi * double(y + 1) / kHeight));
    for (int x = 0; x < kWidth / 2; ++x) {
      const double azimuth = 2 * kPi * (x + 0.5) / kWidth;
      const double to_sun = std::sin(up) * std::sin(elevation) +
                            std::cos(up) * std::cos(elevation) * std::cos(azimuth);
      const Rgb c = table.at(a, up, azimuth, to_sun) * unit;
      Rgb* row = &pixels[y * kWidth];
      row[x] = row[kWidth - 1 - x] = c;
      lit[y] += Vec3d(c) * (2 * area * std::sin(up));
    }
  });
  Vec3d sum;
  for (const Vec3d& row : lit) sum += row;
  return sum;
}

}  // namespace

const char* expect_date(const Value& value) {
  const std::string* text = value.word();
  if (text != nullptr && (text->empty() || parse_date(*text))) return nullptr;
  return "a date from 1800 to 2200 with a time and its zone, as \"2024-06-21T14:30:00+02:00\" or "
         "\"2024-06-21T12:30:00Z\"";
}

std::optional<Misfit> misfit(const ClearSky& sky) {
  const Vec3d up = normalize(sky.up), north = normalize(sky.north);
  if (!(length(across(up, north)) > 1e-6))
    return Misfit{{"north", "up"}, "a direction not parallel to up"};
  if (sky.date.empty()) {
    const char* const expected = "none without date, and none beside elevation";
    if (sky.latitude) return Misfit{{"latitude"}, expected};
    if (sky.longitude) return Misfit{{"longitude"}, expected};
    return std::nullopt;
  }
  const char* const told = "none beside date, which sets the position of the sun";
  if (sky.elevation) return Misfit{{"elevation"}, told};
  if (sky.azimuth) return Misfit{{"azimuth"}, told};
  const char* const place = "latitude and longitude in degrees beside it";
  if (!sky.latitude || !sky.longitude) return Misfit{{"date"}, place};
  return std::nullopt;
}

SunPosition sun_of(const ClearSky& sky) {
  if (sky.date.empty()) return {sky.elevation.value_or(37), sky.azimuth.value_or(245)};
  SunPosition sun = sun_position(*parse_date(sky.date), *sky.latitude, *sky.longitude);
  sun.elevation += refraction(sun.elevation);
  return sun;
}

Daylight make_daylight(const ClearSky& sky, ColorSpace space) {
  const SunPosition sun = sun_of(sky);
  const double elevation = sun.elevation * kDegree;
  const Vec3d up = normalize(sky.up), side = on_horizon(sky, sun.azimuth);
  Daylight day;
  day.picture.width = kWidth, day.picture.height = kHeight;
  std::vector<Rgb>& pixels = day.picture.pixels.edit();
  pixels.assign(std::size_t(kWidth) * kHeight, Rgb(0.0f));
  day.picture.up = sky.up;
  day.picture.rotation =
      std::atan2(dot(side, turn_up(up, {0, 0, 1})), dot(side, turn_up(up, {1, 0, 0}))) / kDegree;
  day.sun = {side * std::cos(elevation) + up * std::sin(elevation), Rgb(0.0f), kDiameter};
  if (sun.elevation <= kNight || sky.irradiance == 0) return day;
  const Atmosphere a = make_atmosphere(0.1 * (sky.turbidity - 1), sky.ozone, sky.ground);
  const ScatteredLight light(a, kPi / 2 - elevation);
  const float unit = float(sky.irradiance);
  const Spectrum beam = light.beam().of_disc(kPi / 2 - elevation, kDiameter / 2 * kDegree);
  day.sun.irradiance = Rgb(into_gamut(seen_as(beam, space), luminance_weights(space))) * unit;
  const Vec3d scattered = paint(light, a, elevation, unit, space, pixels);
  const Vec3d direct = Vec3d(day.sun.irradiance) * std::max(std::sin(elevation), 0.0);
  const Rgb ground(Vec3d(sky.ground) * (scattered + direct) / kPi);
  std::fill(pixels.begin() + kWidth * kHeight / 2, pixels.end(), ground);
  return day;
}

}  // namespace pvol
