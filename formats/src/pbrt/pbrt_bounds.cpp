#include "pbrt/pbrt_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace pvol::formats::detail {
namespace {

/// Each vertex at a corner, and each corner at a vertex.
bool has_corners_alone(const Box& box, const std::vector<Vec3d>& vertices) {
  unsigned met = 0;
  for (const Vec3d v : vertices) {
    unsigned i = 0;
    while (i < 8 && !(corner(box, i) == v)) ++i;
    if (i == 8) return false;
    met |= 1u << i;
  }
  return met == 0xff;
}

}  // namespace

std::optional<double> even_scale(const Affine& map) {
  const std::array<Vec3d, 3>& m = map.m;
  const double s = length(m[0]);
  const double skew =
      std::max({std::abs(dot(m[0], m[1])), std::abs(dot(m[1], m[2])), std::abs(dot(m[2], m[0])),
                std::abs(dot(m[1], m[1]) - s * s), std::abs(dot(m[2], m[2]) - s * s)});
  if (!(skew <= 1e-6 * s * s)) return std::nullopt;
  return s;
}

bool is_whole_sphere(const PbrtShape& sphere) {
  const PbrtParameters& p = sphere.parameters;
  const double r = p.number("radius", 1);
  return p.number("zmin", -r) <= -r && p.number("zmax", r) >= r && p.number("phimax", 360) >= 360;
}

std::optional<PbrtHull> hull_of(const PbrtShape& shape) {
  if (shape.type == "sphere") {
    const double r = shape.parameters.number("radius", 1);
    if (!is_whole_sphere(shape) || !(r > 0)) return std::nullopt;
    return PbrtHull{{Vec3d(-r), Vec3d(r)}, true};
  }
  if (shape.type != "trianglemesh" && shape.type != "bilinearmesh") return std::nullopt;
  const std::vector<Vec3d> vertices = shape.parameters.points("P");
  Box box;
  for (const Vec3d v : vertices) box = extend(box, v);
  if (!has_corners_alone(box, vertices) || !(min_component(box.extent()) > 0)) return std::nullopt;
  return PbrtHull{box, false};
}

bool contains(const PbrtHull& hull, const Affine& map, const Box& box) {
  const Vec3d middle = hull.box.centre(), half = hull.box.extent() * 0.5;
  constexpr double kMost = 1.001;
  for (unsigned i = 0; i < 8; ++i) {
    const Vec3d p = map.point(corner(box, i)) - middle;
    const Vec3d share{std::abs(p.x) / half.x, std::abs(p.y) / half.y, std::abs(p.z) / half.z};
    if (!((hull.is_ball ? length(share) : max_component(share)) <= kMost)) return false;
  }
  return true;
}

}  // namespace pvol::formats::detail
