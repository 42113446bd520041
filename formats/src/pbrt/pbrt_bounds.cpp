#include "pbrt/pbrt_bounds.h"

#include <cmath>

namespace pvol::formats::detail {
namespace {

Vec3d corner(const Box& box, unsigned i) {
  return {i & 1 ? box.hi.x : box.lo.x, i & 2 ? box.hi.y : box.lo.y, i & 4 ? box.hi.z : box.lo.z};
}

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
