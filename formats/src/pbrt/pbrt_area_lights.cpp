// Shapes of pbrt that shine: whole spheres and flat rectangles. Others are named.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "file/mesh_read.h"
#include "pbrt/pbrt_bounds.h"
#include "pbrt/pbrt_shapes.h"
#include "pbrt/pbrt_world.h"

namespace pvol::formats::detail {
namespace {

/// Middle, half sides and front of a rectangle in the world.
struct Rectangle {
  Vec3d middle, across, up, front;
  int lights = 1;  ///< as pbrt has it, each of the whole power
};

/// Of two triangles or a patch whose four corners make right angles.
std::optional<Rectangle> rectangle_of(const PbrtShape& shape, const Affine& place,
                                      ImportNotes& notes) {
  if (shape.type != "bilinearmesh" && shape.type != "trianglemesh") return std::nullopt;
  const TriangleMesh mesh = triangles_of(shape, notes);
  if (mesh.triangles.size() != 2 || mesh.vertices.size() != 4) return std::nullopt;
  std::array<Vec3d, 4> p;
  std::ranges::transform(mesh.vertices, p.begin(), [&](Vec3d v) { return place.point(v); });
  // The corner opposite to the first: the sum of the sides to the other two leads there.
  for (const auto& [a, b, c] : {std::array{1, 2, 3}, {1, 3, 2}, {2, 3, 1}}) {
    const Vec3d across = p[std::size_t(a)] - p[0], up = p[std::size_t(b)] - p[0];
    const double size = length(across) + length(up);
    if (!(length(p[0] + across + up - p[std::size_t(c)]) < 1e-6 * size)) continue;
    if (!(std::abs(dot(across, up)) < 1e-6 * size * size)) return std::nullopt;
    const auto& t = mesh.triangles.front();
    Vec3d front = cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
    if ((determinant(place) < 0) != shape.reversed) front = -front;
    if (!(length(front) > 0)) return std::nullopt;
    // Each triangle is a light, while a patch is one as a whole.
    const int lights = shape.type == "trianglemesh" ? 2 : 1;
    return Rectangle{p[0] + (across + up) * 0.5, across, up, normalize(front), lights};
  }
  return std::nullopt;
}

void add_rectangle(const PbrtThing& light, const Rectangle& r, const PbrtMaking& making) {
  const bool two_sided = light.parameters.flag("twosided", false);
  AreaLight area;
  area.position = r.middle, area.direction = r.front, area.up = normalize(r.up);
  area.size = {length(r.across), length(r.up)};
  const double all = std::numbers::pi * area.size[0] * area.size[1] * (two_sided ? 2 : 1);
  area.radiance = strength(light, "L", "power", all / r.lights, making);
  making.scene->file.scene.lights.emplace_back(area);
  if (!two_sided) return;
  area.direction = -area.direction;
  making.scene->file.scene.lights.emplace_back(area);
}

/// Radiance L of a ball of radius r is an irradiance of pi r^2 L at distance 1 from its middle.
bool add_ball(const PbrtShape& shape, const Affine& place, const PbrtMaking& making) {
  const std::optional<double> scale = even_scale(place);
  if (shape.type != "sphere" || !scale || !is_whole_sphere(shape)) return false;
  const double r = shape.parameters.number("radius", 1) * *scale, pi = std::numbers::pi;
  if (!(r > 0)) fail_at(shape.where, "a sphere with a radius of 0 or less", "a radius above 0");
  const PbrtThing& light = *shape.area_light;
  const bool two_sided = light.parameters.flag("twosided", false);
  if (shape.reversed && !two_sided) return false;  // it shines inwards
  PointLight ball;
  ball.position = place.t, ball.radius = r;
  const double one = 4 * pi * r * r * pi * (two_sided ? 2 : 1);
  ball.intensity = Rgb(Vec3d(strength(light, "L", "power", one, making)) * (pi * r * r));
  making.scene->file.scene.lights.emplace_back(ball);
  return true;
}

}  // namespace

bool make_area_light(const PbrtShape& shape, const Affine& place, const PbrtMaking& making) {
  if (!shape.area_light) return false;
  const PbrtThing& light = *shape.area_light;
  bool made = light.type == "diffuse" && add_ball(shape, place, making);
  if (!made && light.type == "diffuse") {
    if (const auto rectangle = rectangle_of(shape, place, *making.notes)) {
      add_rectangle(light, *rectangle, making);
      made = true;
    }
  }
  if (!made) {
    making.note(shape.where, fmt::format("the light of this {} is left out: only whole spheres and "
                                         "rectangles become area lights",
                                         shown(shape.type)));
    return false;
  }
  making.note(shape.where, "area lights do not block light, unlike pbrt's");
  light.parameters.note_unused(*making.notes, "area light");
  return true;
}

}  // namespace pvol::formats::detail
