#include "pvol/math/color_space.h"

#include <cmath>

namespace pvol {
namespace {

constexpr Chromaticity kD65White{0.3127, 0.3290}, kAcesWhite{0.32168, 0.33767};

/// X, Y, Z of a chromaticity, of Y = 1.
Vec3d xyz_of(Chromaticity c) { return {c.x / c.y, 1, (1 - c.x - c.y) / c.y}; }

Affine columns(Vec3d a, Vec3d b, Vec3d c) {
  return {{Vec3d(a.x, b.x, c.x), Vec3d(a.y, b.y, c.y), Vec3d(a.z, b.z, c.z)}, {}};
}

Vec3d direction(Chromaticity c) { return {c.x, c.y, 1 - c.x - c.y}; }

Affine directions(const Primaries& p) {
  return columns(direction(p.red), direction(p.green), direction(p.blue));
}

/// How much of each primary gives white.
Vec3d shares_of_white(const Primaries& p) { return inverse(directions(p)).vector(xyz_of(p.white)); }

/// X, Y, Z of colours by these primaries, of which white has Y = 1.
Affine to_xyz(const Primaries& p) { return directions(p) * scaling(shares_of_white(p)); }

/// Responses of Bradford's cones to X, Y, Z.
Affine cones() {
  return {{Vec3d(0.8951, 0.2664, -0.1614), Vec3d(-0.7502, 1.7135, 0.0367),
           Vec3d(0.0389, -0.0685, 1.0296)},
          {}};
}

/// Whether the primaries are corners of a triangle with white inside, which has light.
bool is_usable(const Primaries& p) {
  constexpr double kLeast = 1e-6;
  const double area =
      (p.green.x - p.red.x) * (p.blue.y - p.red.y) - (p.blue.x - p.red.x) * (p.green.y - p.red.y);
  if (!(std::abs(area) > kLeast) || !(p.white.y > kLeast)) return false;
  const Vec3d shares = shares_of_white(p), responses = cones().vector(xyz_of(p.white));
  return min_component(shares) > 0 && min_component(responses) > 0 && is_finite(shares) &&
         is_finite(responses);
}

/// Scales the responses of cones from one white to another.
Affine adaptation(Chromaticity from, Chromaticity to) {
  const Vec3d a = cones().vector(xyz_of(from)), b = cones().vector(xyz_of(to));
  return inverse(cones()) * scaling({b.x / a.x, b.y / a.y, b.z / a.z}) * cones();
}

bool same(Chromaticity a, Chromaticity b, double tolerance) {
  return std::abs(a.x - b.x) <= tolerance && std::abs(a.y - b.y) <= tolerance;
}

bool same(const Primaries& a, const Primaries& b, double tolerance) {
  return same(a.red, b.red, tolerance) && same(a.green, b.green, tolerance) &&
         same(a.blue, b.blue, tolerance) && same(a.white, b.white, tolerance);
}

}  // namespace

Primaries primaries_of(ColorSpace space) {
  switch (space) {
    case ColorSpace::rec2020:
      return {{0.708, 0.292}, {0.170, 0.797}, {0.131, 0.046}, kD65White};
    case ColorSpace::p3:
      return {{0.680, 0.320}, {0.265, 0.690}, {0.150, 0.060}, kD65White};
    case ColorSpace::acescg:
      return {{0.713, 0.293}, {0.165, 0.830}, {0.128, 0.044}, kAcesWhite};
    case ColorSpace::aces:
      return {{0.7347, 0.2653}, {0.0, 1.0}, {0.0001, -0.0770}, kAcesWhite};
    default:
      return {{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}, kD65White};
  }
}

std::optional<ColorSpace> find_space(const Primaries& primaries) {
  constexpr double kTolerance = 0.002;
  for (const auto& named : names(ColorSpace{})) {
    if (same(primaries_of(named.value), primaries, kTolerance)) return named.value;
  }
  return std::nullopt;
}

std::optional<Affine> conversion(const Primaries& from, const Primaries& to) {
  if (same(from, to, 0)) return Affine{};
  if (!is_usable(from) || !is_usable(to)) return std::nullopt;
  return inverse(to_xyz(to)) * (adaptation(from.white, to.white) * to_xyz(from));
}

Affine conversion(ColorSpace from, ColorSpace to) {
  return *conversion(primaries_of(from), primaries_of(to));
}

Vec3d luminance_weights(ColorSpace space) {
  if (space == ColorSpace::rec709) return {0.2126, 0.7152, 0.0722};  // as `luminance`
  return to_xyz(primaries_of(space)).m[1];
}

Vec3d into_gamut(Vec3d color, Vec3d weights) {
  const Vec3d inside = max(color, Vec3d(0.0));
  const double wanted = dot(color, weights), now = dot(inside, weights);
  return wanted > 0 ? inside * (wanted / now) : Vec3d(0.0);
}

}  // namespace pvol
