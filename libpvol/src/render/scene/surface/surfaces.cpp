#include "render/scene/surface/surfaces.h"

#include <algorithm>

#include "pvol/error.h"
#include "render/scene/boxes.h"

namespace pvol {
namespace {

void validate_body(const Body* body) {
  if (body == nullptr) throw Error("the body is missing");
  if (RayBody(*body).box().empty()) throw Error("the body is empty");
}

void validate_mesh(const TriangleMesh* mesh) {
  if (mesh == nullptr || mesh->triangles.empty()) throw Error("there are no triangles");
  for (const Vec3d v : mesh->vertices) {
    if (!is_finite(v)) throw Error("a coordinate is not finite; expected finite coordinates");
  }
  for (const auto& triangle : mesh->triangles) {
    if (*std::ranges::max_element(triangle) >= mesh->vertices.size()) {
      throw Error("a triangle refers to a vertex that does not exist");
    }
  }
}

/// A surface that has a placement of its own.
template <class AnySurface>
concept Placed = requires(const AnySurface& s) {
  { s.place } -> std::convertible_to<const Placement&>;
  { s.to } -> std::convertible_to<const std::optional<Placement>&>;
};

}  // namespace

std::optional<Misfit> misfit(const Surface& surface) {
  return std::visit(
      [](const auto& s) -> std::optional<Misfit> {
        if constexpr (Placed<std::remove_cvref_t<decltype(s)>>) {
          if (const auto wrong = misfit(s.place)) return wrong;
          if (!s.to) return std::nullopt;
          const auto wrong = misfit(*s.to);
          return wrong ? wrong : misfit(MovingPlacement{s.place, *s.to});
        }
        return std::nullopt;
      },
      surface);
}

std::optional<MovingMap> motion_of(const Surface& surface) {
  return std::visit(
      [](const auto& s) -> std::optional<MovingMap> {
        using Kind = std::remove_cvref_t<decltype(s)>;
        if constexpr (Placed<Kind>) {
          if (s.to && *s.to != s.place) return MovingPlacement{s.place, *s.to}.map();
        } else if constexpr (std::same_as<Kind, BallSurface>) {
          if (!s.to || s.to->centre == s.centre) return std::nullopt;
          MovingMap map;
          map.linear = scaling(Vec3d(s.radius));
          map.shift = s.centre, map.shift_rate = s.to->centre - s.centre;
          return map;
        }
        return std::nullopt;
      },
      surface);
}

void validate(const Surface& surface) {
  require_limits(kind_name(surface), without(entries(surface), "file"));
  try {
    if (const auto wrong = misfit(surface)) {
      throw Error(std::string(wrong->keys.front()) + ": expected " + wrong->expected);
    }
    if (const auto* solid = std::get_if<SolidSurface>(&surface)) {
      validate_body(solid->body.get());
    } else if (const auto* mesh = std::get_if<MeshSurface>(&surface)) {
      validate_mesh(mesh->mesh.get());
    }
  } catch (const Error& e) {
    throw Error(kind_name(surface) + std::string(": ") + e.what());
  }
}

}  // namespace pvol

namespace pvol::detail {
namespace {

/// A normal of the body's frame in the world: by the transpose of the map back.
[[nodiscard]] Vec3d to_world(const Affine& to_body, Vec3d normal) {
  Vec3d sum;
  for (int axis = 0; axis < 3; ++axis) sum += to_body.m[std::size_t(axis)] * normal[axis];
  return sum;
}

/// The hit at a distance along the ray, with its normal of any length. To a surface's own clearance
/// comes what is lost of places that are far from the origin, or from the ray's.
[[nodiscard]] SurfaceHit make_hit(const Ray& ray, double distance, Vec3d normal, double clearance,
                                  const Material& material, const MovingMap* moves = nullptr) {
  const double size = length(normal);
  Vec3d n = size > 0 ? normal / size : -ray.d;  // at a point where it is not known
  if (dot(n, ray.d) > 0) n = -n;
  constexpr double kLost = 1e-12;
  const Vec3d at = ray.at(distance);
  const double away = clearance + kLost * (length(at) + distance);
  return {distance, at + n * away, n, away, &material, moves};
}

}  // namespace

/// One for each kind of surface.
struct SurfaceSet::Add {
  SurfaceSet& to;
  const Material& material;  ///< of the surface, where the set keeps it
  const Shutter& shutter;
  std::vector<PlacedMesh>& meshes;

  void operator()(const PlaneSurface& p) const {
    to.planes_.push_back({p.point, normalize(p.normal), material});
  }
  void operator()(const BallSurface& b) const {
    const Affine map = translation(b.centre) * scaling(Vec3d(b.radius));
    add_body(Body(FreeForm{unit_ball(), {}}), place_of(b, map));
  }
  void operator()(const SolidSurface& s) const {
    add_body(*s.body, place_of(s, s.place.map()));
  }
  void operator()(const MeshSurface& m) const {
    Place place = place_of(m, m.place.map());
    if (place.open) {
      const PlacedMesh own{m.mesh.get(), {}};
      to.moving_meshes_.push_back({MeshScene({&own, 1}), std::move(place), material});
    } else {
      meshes.push_back({m.mesh.get(), place.still.to_world});
      to.mesh_looks_.push_back({material, std::move(place.moves)});
    }
  }

  [[nodiscard]] Place place_of(const Surface& surface, const Affine& map) const {
    Place place{{map, inverse(map)}, motion_of(surface), false};
    place.open = place.moves && shutter.moves();
    to.move_ = to.move_ || place.open;
    const double t0 = std::min(shutter.open, 0.0), t1 = std::max(shutter.close, 0.0);
    if (place.open && !stays_regular(*place.moves, t0, t1)) {
      throw Error(std::string("a ") + kind_name(surface) +
                  " becomes flat while the shutter is open, because a scale passes through 0. "
                  "Close the shutter earlier, or give scales that do not pass 0.");
    }
    return place;
  }

  void add_body(const Body& body, Place place) const {
    auto ready = std::make_unique<const RayBody>(body);
    constexpr double kClearance = 1e-9;  // of the diagonal; roots are good to 1e-14 of it
    const double clearance =
        kClearance * length(transform(place.still.to_world, ready->box()).extent());
    to.bodies_.push_back({std::move(ready), std::move(place), clearance, material});
  }
};

SurfaceSet::SurfaceSet(std::span<const Surface> surfaces, const Shutter& shutter) {
  std::vector<PlacedMesh> meshes;
  for (const Surface& s : surfaces) materials_.push_back(material_of(s));  // and stay where they are
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const Material& m = materials_[i];
    std::visit(Add{*this, m, shutter, meshes}, surfaces[i]);
    catch_shadows_ = catch_shadows_ || m.visibility == Visibility::shadow_catcher;
    are_grey_ = are_grey_ && m.albedo.x == m.albedo.y && m.albedo.y == m.albedo.z;
  }
  if (!meshes.empty()) meshes_.emplace(meshes);
}

SurfaceSet::Frame SurfaceSet::Place::frame_at(float time) const {
  const Affine to_world = moves->at(double(time));
  return {to_world, inverse(to_world)};
}

std::optional<double> SurfaceSet::meet(const Plane& plane, const Ray& ray, double limit) {
  const double t = dot(plane.normal, plane.point - ray.o) / dot(plane.normal, ray.d);
  return t > 0 && t < limit ? std::optional(t) : std::nullopt;
}

std::optional<RayBody::Hit> SurfaceSet::meet(const PlacedBody& body, const Frame& frame,
                                             const Ray& ray, double limit) {
  return body.body->first_hit({frame.from_world.point(ray.o), frame.from_world.vector(ray.d)}, 0,
                              limit);
}

/// With t and clearance in the world, and the normal in the mesh's frame.
std::optional<MeshScene::Hit> SurfaceSet::meet(const MovingMesh& mesh, const Frame& frame,
                                               const Ray& ray, double limit) {
  const Vec3d d = frame.from_world.vector(ray.d);
  const double stretch = length(d);  // the triangles take rays of unit direction
  auto hit =
      mesh.triangles.first_hit({frame.from_world.point(ray.o), d / stretch}, limit * stretch);
  if (!hit) return std::nullopt;
  hit->t /= stretch;
  const Affine& m = frame.to_world;
  hit->clearance *= length(m.m[0]) + length(m.m[1]) + length(m.m[2]);  // at least its norm
  return hit;
}

SurfaceHit SurfaceSet::first_hit(const Ray& ray, double limit, float time) const {
  SurfaceHit hit;
  Frame moved;
  hit.distance = limit;
  for (const Plane& p : planes_) {
    const auto t = meet(p, ray, hit.distance);
    if (!t) continue;
    constexpr double kClearance = 1e-12;
    hit = make_hit(ray, *t, p.normal, kClearance * length(p.point), p.material);
  }
  for (const PlacedBody& b : bodies_) {
    const Frame& frame = b.place.at(time, moved);
    if (const auto found = meet(b, frame, ray, hit.distance)) {
      hit = make_hit(ray, found->t, to_world(frame.from_world, found->normal), b.clearance,
                     b.material, b.place.motion());
    }
  }
  if (meshes_) {
    if (const auto found = meshes_->first_hit(ray, hit.distance)) {
      const MeshLook& look = mesh_looks_[found->mesh];
      hit = make_hit(ray, found->t, found->normal, found->clearance, look.material,
                     look.moves ? &*look.moves : nullptr);
    }
  }
  for (const MovingMesh& m : moving_meshes_) {
    const Frame& frame = m.place.at(time, moved);
    if (const auto found = meet(m, frame, ray, hit.distance)) {
      hit = make_hit(ray, found->t, to_world(frame.from_world, found->normal), found->clearance,
                     m.material, m.place.motion());
    }
  }
  if (hit.material == nullptr) hit.distance = std::numeric_limits<double>::infinity();
  return hit;
}

bool SurfaceSet::block(const Ray& ray, double limit, float time) const {
  Frame moved;
  const auto in_way = [&](const auto& placed) {
    return meet(placed, placed.place.at(time, moved), ray, limit).has_value();
  };
  return std::ranges::any_of(planes_,
                             [&](const Plane& p) { return meet(p, ray, limit).has_value(); }) ||
         std::ranges::any_of(bodies_, in_way) || (meshes_ && meshes_->blocks(ray, limit)) ||
         std::ranges::any_of(moving_meshes_, in_way);
}

bool SurfaceSet::may_reach(const Box& box) const {
  const auto cuts = [&](const Plane& p) {
    const Vec3d half = box.extent() * 0.5;
    const Vec3d n(std::abs(p.normal.x), std::abs(p.normal.y), std::abs(p.normal.z));
    return std::abs(dot(box.centre() - p.point, p.normal)) <= dot(half, n);
  };
  const auto holds = [&](const PlacedBody& b) {
    return b.place.open || detail::meet(transform(b.place.still.to_world, b.body->box()), box);
  };
  return std::ranges::any_of(planes_, cuts) || std::ranges::any_of(bodies_, holds) ||
         (meshes_ && meshes_->may_reach(box)) || !moving_meshes_.empty();
}

double SurfaceSet::distance(Vec3d place, double most) const {
  double nearest = moving_meshes_.empty() ? most : 0;
  for (const Plane& p : planes_) {
    nearest = std::min(nearest, std::abs(dot(place - p.point, p.normal)));
  }
  for (const PlacedBody& b : bodies_) {
    const Box box = transform(b.place.still.to_world, b.body->box());
    nearest = b.place.open ? 0 : std::min(nearest, detail::distance(box, place));
  }
  return meshes_ ? meshes_->distance(place, nearest) : nearest;
}

std::shared_ptr<const Surfaces> make_surfaces(std::span<const Surface> surfaces,
                                              const Shutter& shutter) {
  if (surfaces.empty()) return nullptr;
  // Kinds of rays that meet the same surfaces share one set, and so its triangles.
  std::vector<std::pair<std::vector<bool>, std::shared_ptr<const SurfaceSet>>> made;
  const auto met_by = [&](bool Material::*kind) {
    std::vector<bool> meets;
    std::vector<Surface> some;
    for (const Surface& s : surfaces) {
      meets.push_back(material_of(s).*kind);
      if (meets.back()) some.push_back(s);
    }
    for (const auto& [of, set] : made) {
      if (of == meets) return set;
    }
    return made.emplace_back(meets, std::make_shared<const SurfaceSet>(some, shutter)).second;
  };
  Surfaces all{met_by(&Material::visible_camera), met_by(&Material::visible_shadow),
               met_by(&Material::visible_light), {}};
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    if (material_of(surfaces[i]).visible_camera) all.seen.push_back(i);
  }
  return std::make_shared<const Surfaces>(std::move(all));
}

}  // namespace pvol::detail
