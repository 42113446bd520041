// Surfaces of a scene: ground, meshes, balls and solids in closed form, which scatter light evenly
// (Lambert) and let none through. A kind of surface has its name, which is that of its sections in
// scene files, and its keys beside it; to add one, see libpvol/SOURCES.md.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "pvol/form/body.h"
#include "pvol/math/keys.h"
#include "pvol/math/moving_map.h"
#include "pvol/math/names.h"
#include "pvol/math/triangle_mesh.h"
#include "pvol/render/placement.h"

namespace pvol {

/// What camera rays see of a surface that they meet before all else. All other light meets it as a
/// surface of its albedo.
enum class Visibility {
  surface,
  shadow_catcher,  ///< stands for the ground of a photograph: only the shadow on it (THEORY.md,
                   ///< T5.18)
  holdout,         ///< a hole in the picture, with alpha 0
};
[[nodiscard]] constexpr auto names(Visibility) {
  return std::to_array<Named<Visibility>>({{Visibility::surface, "surface"},
                                           {Visibility::shadow_catcher, "shadow-catcher"},
                                           {Visibility::holdout, "holdout"}});
}

/// How a surface scatters, on either side, and which rays meet it.
struct Material {
  Rgb albedo{0.5f};  ///< share of the light that falls on it; 0: black
  Visibility visibility = Visibility::surface;
  // Rays pass what they do not meet as if it were not there (THEORY.md, T5.18).
  bool visible_camera = true;  ///< camera rays meet it
  bool visible_shadow = true;  ///< it is in the way of light from lights, the sky and fires
  bool visible_light = true;   ///< scattered light meets it, and is scattered again
  friend bool operator==(const Material&, const Material&) = default;
};
template <std::same_as<Material> F>
[[nodiscard]] constexpr auto keys(const F&) {
  return std::to_array<Key<F>>({
      key<&F::albedo>({.key = "albedo",
                       .metavar = "RGB",
                       .limits = number(Range::closed(0, 1)).or_three(),
                       .help = "Fraction of the incident light that is scattered, evenly in all "
                               "directions; 0 is black"}),
      key<&F::visibility>({.key = "look",
                           .help = "How the camera sees the surface; of a shadow-catcher only the "
                                   "shadows on it are visible, a holdout is a hole with alpha 0"}),
      key<&F::visible_camera>({.key = "visible_camera",
                               .help = "Whether the camera sees the surface; what stands behind it "
                                       "is visible otherwise"}),
      key<&F::visible_shadow>({.key = "visible_shadow",
                               .help = "Whether the surface casts shadows: whether it blocks the "
                                       "light of lights, the sky and fires"}),
      key<&F::visible_light>({.key = "visible_light",
                              .help = "Whether light that was scattered before meets the surface, "
                                      "which absorbs a part and scatters the rest"}),
  });
}

/// Without end: ground, walls.
struct PlaneSurface {
  static constexpr const char* kName = "plane";
  Vec3d point{0, 0, 0};
  Vec3d normal{0, 1, 0};  ///< of any length > 0
  Material material{};
  friend bool operator==(const PlaneSurface&, const PlaneSurface&) = default;
};
template <std::same_as<PlaneSurface> P>
[[nodiscard]] constexpr auto keys(const P&) {
  return std::to_array<Key<P>>({
      key<&P::point>({.key = "point",
                      .metavar = "XYZ",
                      .limits = number().times(3),
                      .help = "A point of the plane, in world units"}),
      key<&P::normal>({.key = "normal",
                       .metavar = "XYZ",
                       .limits = direction(),
                       .help = "Normal of the plane; both sides are alike",
                       .otherwise = "up"}),
      keys_of_kind<&P::material>(),
  });
}

/// Where a ball is a frame later.
struct BallPlace {
  Vec3d centre{0, 0, 0};
  friend bool operator==(const BallPlace&, const BallPlace&) = default;
};
template <std::same_as<BallPlace> B>
[[nodiscard]] constexpr auto keys(const B&) {
  return std::to_array<Key<B>>({
      key<&B::centre>({.key = "centre",
                       .metavar = "XYZ",
                       .limits = number().times(3),
                       .help = "Centre of the sphere one frame later, in world units",
                       .required = true}),
  });
}

struct BallSurface {
  static constexpr const char* kName = "ball";
  Vec3d centre{0, 0, 0};
  double radius = 1;
  Material material{};
  std::optional<BallPlace> to{};  ///< none: it stands still
  friend bool operator==(const BallSurface&, const BallSurface&) = default;
};
template <std::same_as<BallSurface> B>
[[nodiscard]] constexpr auto keys(const B&) {
  return std::to_array<Key<B>>({
      key<&B::centre>({.key = "centre",
                       .metavar = "XYZ",
                       .limits = number().times(3),
                       .help = "Centre of the sphere, in world units"}),
      key<&B::radius>({.key = "radius",
                       .metavar = "X",
                       .limits = number(Range::above(0)),
                       .help = "Radius of the sphere, in world units"}),
      keys_of_kind<&B::material>(),
  });
}

/// Free forms and trees of them (form/body.h).
struct SolidSurface {
  static constexpr const char* kName = "solid";
  std::string file{};                  ///< that the body comes from; empty where it is from memory
  std::shared_ptr<const Body> body{};  ///< bounded, its perturbations without ones of their own
  Placement place{};
  Material material{};
  std::optional<Placement> to{};  ///< one frame later; none: it stands still
  friend bool operator==(const SolidSurface&, const SolidSurface&) = default;
};
template <std::same_as<SolidSurface> S>
[[nodiscard]] constexpr auto keys(const S&) {
  return std::to_array<Key<S>>({
      key<&S::file>({.key = "file",
                     .metavar = "FILE",
                     .limits = file_name(),
                     .help = "A recipe (.toml), of which the surface is taken: the union of its "
                             "forms within its cuts and of its solids, without noise",
                     .required = true}),
      keys_of_kind<&S::place>(),
      keys_of_kind<&S::material>(),
  });
}

/// Triangles, flat each.
struct MeshSurface {
  static constexpr const char* kName = "mesh";
  std::string file{};  ///< that the triangles come from; empty where they are from memory
  std::shared_ptr<const TriangleMesh> mesh{};
  Placement place{};
  Material material{};
  std::optional<Placement> to{};  ///< one frame later; none: it stands still
  friend bool operator==(const MeshSurface&, const MeshSurface&) = default;
};
template <std::same_as<MeshSurface> M>
[[nodiscard]] constexpr auto keys(const M&) {
  return std::to_array<Key<M>>({
      key<&M::file>({.key = "file",
                     .metavar = "FILE",
                     .limits = file_name(),
                     .help = "File of triangles or other polygons (.obj, .ply)",
                     .required = true}),
      keys_of_kind<&M::place>(),
      keys_of_kind<&M::material>(),
  });
}

using Surface = std::variant<PlaneSurface, BallSurface, SolidSurface, MeshSurface>;

[[nodiscard]] inline const Material& material_of(const Surface& surface) {
  return std::visit([](const auto& s) -> const Material& { return s.material; }, surface);
}

/// A place that cannot be undone, or a matrix besides the rest.
[[nodiscard]] std::optional<Misfit> misfit(const Surface& surface);

/// How the surface goes from its own frame, in which a ball is one of radius 1 about the origin, to
/// the world; nothing of one that stands still.
[[nodiscard]] std::optional<MovingMap> motion_of(const Surface& surface);

/// Throws Error, which says what is wrong: values out of range, a mesh without triangles or with
/// vertices that are missing or not finite, a body that RayBody does not take, places that cannot
/// be undone or that no way leads between (misfit(MovingPlacement)).
void validate(const Surface& surface);

}  // namespace pvol
