#include "render/scene/surface/surfaces.h"

#include <algorithm>
#include <cmath>

#include "pvol/error.h"

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
};

}  // namespace

std::optional<Misfit> misfit(const Surface& surface) {
  return std::visit(
      [](const auto& s) -> std::optional<Misfit> {
        if constexpr (Placed<std::remove_cvref_t<decltype(s)>>) return misfit(s.place);
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
                                  const Material& material) {
  const double size = length(normal);
  Vec3d n = size > 0 ? normal / size : -ray.d;  // at a point where it is not known
  if (dot(n, ray.d) > 0) n = -n;
  constexpr double kLost = 1e-12;
  const Vec3d at = ray.at(distance);
  const double away = clearance + kLost * (length(at) + distance);
  return {distance, at + n * away, n, away, &material};
}

}  // namespace

/// One for each kind of surface.
struct SurfaceSet::Add {
  SurfaceSet& to;
  std::vector<PlacedMesh>& meshes;

  void operator()(const PlaneSurface& p) const {
    to.planes_.push_back({p.point, normalize(p.normal), p.material});
  }
  void operator()(const BallSurface& b) const {
    add_body(Body(FreeForm{unit_ball(), {}}), translation(b.centre) * scaling(Vec3d(b.radius)),
             b.material);
  }
  void operator()(const SolidSurface& s) const { add_body(*s.body, s.place.map(), s.material); }
  void operator()(const MeshSurface& m) const {
    meshes.push_back({m.mesh.get(), m.place.map()});
    to.mesh_materials_.push_back(m.material);
  }

  void add_body(const Body& body, const Affine& map, const Material& material) const {
    auto ready = std::make_unique<const RayBody>(body);
    constexpr double kClearance = 1e-9;  // of the diagonal; roots are good to 1e-14 of it
    const double clearance = kClearance * length(transform(map, ready->box()).extent());
    to.bodies_.push_back({std::move(ready), map, inverse(map), clearance, material});
  }
};

SurfaceSet::SurfaceSet(std::span<const Surface> surfaces) {
  std::vector<PlacedMesh> meshes;
  for (const Surface& s : surfaces) {
    std::visit(Add{*this, meshes}, s);
    const Material& m = material_of(s);
    catch_shadows_ = catch_shadows_ || m.visibility == Visibility::shadow_catcher;
    are_grey_ = are_grey_ && m.albedo.x == m.albedo.y && m.albedo.y == m.albedo.z;
  }
  if (!meshes.empty()) meshes_.emplace(meshes);
}

std::optional<double> SurfaceSet::meet(const Plane& plane, const Ray& ray, double limit) {
  const double t = dot(plane.normal, plane.point - ray.o) / dot(plane.normal, ray.d);
  return t > 0 && t < limit ? std::optional(t) : std::nullopt;
}

std::optional<RayBody::Hit> SurfaceSet::meet(const PlacedBody& body, const Ray& ray, double limit) {
  return body.body->first_hit({body.to_body.point(ray.o), body.to_body.vector(ray.d)}, 0, limit);
}

SurfaceHit SurfaceSet::first_hit(const Ray& ray, double limit) const {
  SurfaceHit hit;
  hit.distance = limit;
  for (const Plane& p : planes_) {
    const auto t = meet(p, ray, hit.distance);
    if (!t) continue;
    constexpr double kClearance = 1e-12;
    hit = make_hit(ray, *t, p.normal, kClearance * length(p.point), p.material);
  }
  for (const PlacedBody& b : bodies_) {
    if (const auto found = meet(b, ray, hit.distance)) {
      hit = make_hit(ray, found->t, to_world(b.to_body, found->normal), b.clearance, b.material);
    }
  }
  if (meshes_) {
    if (const auto found = meshes_->first_hit(ray, hit.distance)) {
      hit = make_hit(ray, found->t, found->normal, found->clearance, mesh_materials_[found->mesh]);
    }
  }
  if (hit.material == nullptr) hit.distance = std::numeric_limits<double>::infinity();
  return hit;
}

bool SurfaceSet::block(const Ray& ray, double limit) const {
  const auto meets = [&](const auto& surface) { return meet(surface, ray, limit).has_value(); };
  return std::ranges::any_of(planes_, meets) || std::ranges::any_of(bodies_, meets) ||
         (meshes_ && meshes_->blocks(ray, limit));
}

std::shared_ptr<const Surfaces> make_surfaces(std::span<const Surface> surfaces) {
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
    return made.emplace_back(meets, std::make_shared<const SurfaceSet>(some)).second;
  };
  return std::make_shared<const Surfaces>(Surfaces{met_by(&Material::visible_camera),
                                                   met_by(&Material::visible_shadow),
                                                   met_by(&Material::visible_light)});
}

}  // namespace pvol::detail
