// From scene light to what a screen shows.

#include "pvol/formats/image.h"

namespace pvol::formats {
namespace {

/// Khronos PBR Neutral Tone Mapper (The Khronos Group, 2024), with the names and constants of its
/// specification: colours below 0.8 stay as they are but for a toe against the specular reflection
/// of 4 %, brighter ones are compressed towards 1 and fade to white.
Vec3d neutral(Vec3d colour) {
  constexpr double kFresnel = 0.04, kStartCompression = 0.8 - kFresnel, kDesaturation = 0.15;
  const double x = min_component(colour);
  const double offset = x < 2 * kFresnel ? x - x * x / (4 * kFresnel) : kFresnel;
  colour = colour - Vec3d(offset);
  const double peak = max_component(colour);
  if (peak < kStartCompression) return colour;
  constexpr double kRest = 1 - kStartCompression;
  const double new_peak = 1 - kRest * kRest / (peak + kRest - kStartCompression);
  const double white = 1 - 1 / (kDesaturation * (peak - new_peak) + 1);
  return colour * (new_peak / peak) * (1 - white) + Vec3d(new_peak * white);
}

/// J. Hable, "Filmic Tonemapping Operators" (2010), the curve of the game Uncharted 2 with the
/// exposure bias and white point published there.
double filmic(double linear) {
  const auto curve = [](double x) {
    constexpr double a = 0.15, b = 0.50, c = 0.10, d = 0.20, e = 0.02, f = 0.30;
    return (x * (a * x + c * b) + d * e) / (x * (a * x + b) + d * f) - e / f;
  };
  constexpr double kExposureBias = 2, kWhite = 11.2;
  return curve(kExposureBias * linear) / curve(kWhite);
}

}  // namespace

Vec3d to_display(Vec3d linear, ToneMap map) {
  // Larger ones are white in every curve, and their squares must stay finite.
  const Vec3d c = min(max(linear, Vec3d{}), Vec3d(1e6));
  const Vec3d shown = map == ToneMap::neutral  ? neutral(c)
                      : map == ToneMap::filmic ? Vec3d(filmic(c.x), filmic(c.y), filmic(c.z))
                                               : c;
  return min(max(shown, Vec3d{}), Vec3d(1));
}

}  // namespace pvol::formats
