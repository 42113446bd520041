// UsdGeomXformable: the first operation in xformOpOrder is applied last. USD multiplies rows by
// matrices, whose last row is the translation; here columns are multiplied.
#include "usda/usda_xform.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "pvol/render/placement.h"

namespace pvol::formats::detail {
namespace {

constexpr std::string_view kInvert = "!invert!";

/// Of sixteen numbers, row by row.
Affine map_of_rows(const UsdView& prim, const std::string& name) {
  const std::vector<double> n = prim.numbers(name, 16);
  const UsdWhere& where = prim.find(name)->where;
  if (n.size() != 16) fail_at(where, fmt::format("{} numbers", n.size()), "sixteen of a matrix");
  if (n[3] != 0 || n[7] != 0 || n[11] != 0 || n[15] != 1) {
    fail_at(where, "a matrix with a perspective", "a last column of 0, 0, 0, 1");
  }
  Affine map;
  for (std::size_t row = 0; row < 3; ++row) {
    map.m[row] = Vec3d{n[row], n[4 + row], n[8 + row]};
    map.t[int(row)] = n[12 + row];
  }
  return map;
}

Affine turn_about(char axis, double degrees) {
  Placement p;
  p.rotate = {{Vec3d(axis == 'X', axis == 'Y', axis == 'Z'), degrees}};
  return p.map();
}

/// About the axes one after another, the first letter first.
Affine turns(std::string_view axes, Vec3d degrees) {
  Affine map;
  for (const char axis : axes) map = turn_about(axis, degrees[axis - 'X']) * map;
  return map;
}

Vec3d along(char axis, double value, double others) {
  Vec3d v(others);
  v[axis - 'X'] = value;
  return v;
}

bool is_axis(std::string_view text) { return text == "X" || text == "Y" || text == "Z"; }
bool is_order(std::string_view text) {
  std::string sorted(text);
  std::ranges::sort(sorted);
  return sorted == "XYZ";
}

/// One of an operation's kind, as "rotateXYZ".
Affine operation(const UsdView& prim, const std::string& name, std::string_view kind) {
  const auto rest_of = [&](std::string_view verb) {
    return kind.starts_with(verb) ? kind.substr(verb.size()) : "";
  };
  if (kind == "translate") return translation(prim.vector(name, {0, 0, 0}));
  if (kind == "scale") return scaling(prim.vector(name, {1, 1, 1}));
  if (kind == "transform") return prim.says(name) ? map_of_rows(prim, name) : Affine{};
  if (kind == "orient") {
    const std::vector<double> q = prim.numbers(name, 4);
    return q.size() == 4 ? turn_of({q[0], q[1], q[2], q[3]}) : Affine{};
  }
  const std::string_view turned = rest_of("rotate"), moved = rest_of("translate");
  const std::string_view scaled = rest_of("scale");
  if (is_axis(turned)) return turn_about(turned.front(), prim.number(name, 0));
  if (is_order(turned)) return turns(turned, prim.vector(name, {0, 0, 0}));
  if (is_axis(moved)) return translation(along(moved.front(), prim.number(name, 0), 0));
  if (is_axis(scaled)) return scaling(along(scaled.front(), prim.number(name, 1), 1));
  fail_at(prim.find("xformOpOrder")->where, fmt::format("\"{}\"", usd_shown(name)),
          "operations such as xformOp:translate, xformOp:rotateXYZ, xformOp:transform");
}

/// Of the xformOp:KIND or xformOp:KIND:NAME that an order has.
Affine map_of_operation(const UsdView& prim, std::string_view text) {
  const bool inverted = text.starts_with(kInvert);
  if (inverted) text.remove_prefix(kInvert.size());
  constexpr std::string_view kPrefix = "xformOp:";
  const std::string name(text);
  const std::string_view rest = text.starts_with(kPrefix) ? text.substr(kPrefix.size()) : "";
  const Affine map = operation(prim, name, rest.substr(0, rest.find(':')));
  return inverted ? inverse(map) : map;
}

Affine map_at(const UsdView& prim, bool& resets) {
  Affine map;
  for (const std::string& text : prim.words("xformOpOrder")) {
    if (text == "!resetXformStack!") {
      resets = true;
      map = {};
    } else {
      map = map * map_of_operation(prim, text);
    }
  }
  return map;
}

}  // namespace

UsdXform xform_of(const UsdView& now) {
  UsdXform xform;
  xform.place.now = map_at(now, xform.resets);
  xform.place.later = map_at(UsdView(now.prim(), now.frame() + 1), xform.resets);
  return xform;
}

std::optional<double> uniform_scale(const Affine& map) {
  const std::array<Vec3d, 3>& m = map.m;
  const double size = dot(m[0], m[0]);
  const double skew =
      std::max({std::abs(dot(m[0], m[1])), std::abs(dot(m[1], m[2])), std::abs(dot(m[2], m[0])),
                std::abs(dot(m[1], m[1]) - size), std::abs(dot(m[2], m[2]) - size)});
  if (!(skew <= 1e-6 * size)) return std::nullopt;
  return std::sqrt(size);
}

Affine turn_of(const std::array<double, 4>& q) {
  const double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(size > 0)) return {};
  const double w = q[0] / size, x = q[1] / size, y = q[2] / size, z = q[3] / size;
  Affine turn;
  turn.m = {Vec3d{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
            Vec3d{2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
            Vec3d{2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
  return turn;
}

}  // namespace pvol::formats::detail
