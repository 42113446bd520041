// The surfaces of a scene ready for rays.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "pvol/form/ray_body.h"
#include "pvol/math/moving_map.h"
#include "pvol/render/surface.h"
#include "pvol/volume/shutter.h"
#include "render/scene/surface/mesh_scene.h"

namespace pvol::detail {

/// Where a ray meets a surface.
struct SurfaceHit {
  double distance = std::numeric_limits<double>::infinity();
  Vec3d place;                         ///< just before it, on the ray's side
  Vec3d normal;                        ///< unit, on the ray's side
  double clearance = 0;                ///< of the place from the surface, along the normal
  const Material* material = nullptr;  ///< null: there is none
  const MovingMap* moves = nullptr;    ///< what moves it, shutter open or not; null: nothing

  /// How far beyond it lamps count as before it: those that lie on it.
  [[nodiscard]] double beyond_for_lamps() const { return 2 * clearance + 1e-6 * distance; }
};

/// What rays of one kind meet. Immutable; safe to use from any thread.
class SurfaceSet {
 public:
  /// Of valid surfaces. Throws Error where their triangles cannot be had, and for a place that
  /// cannot be undone at all times of the shutter.
  SurfaceSet(std::span<const Surface> surfaces, const Shutter& shutter);
  SurfaceSet(const SurfaceSet&) = delete;
  SurfaceSet& operator=(const SurfaceSet&) = delete;

  /// The first one that a ray of unit direction meets before the limit, at a time in frames.
  [[nodiscard]] SurfaceHit first_hit(const Ray& ray, double limit, float time) const;
  /// Whether there is one.
  [[nodiscard]] bool block(const Ray& ray, double limit, float time) const;
  /// Whether some are elsewhere at another time of the shutter.
  [[nodiscard]] bool move() const { return move_; }
  /// False only where none reaches into a box of the world at any time of the shutter.
  [[nodiscard]] bool may_reach(const Box& box) const;
  /// How far a place of the world is at least from all of them while the shutter is open, up to
  /// `most`; 0 where some move.
  [[nodiscard]] double distance(Vec3d place, double most) const;

  /// Whether the camera sees shadows alone of some.
  [[nodiscard]] bool catch_shadows() const { return catch_shadows_; }
  /// Whether all scatter every channel alike.
  [[nodiscard]] bool are_grey() const { return are_grey_; }
  /// Which of the set's surfaces has this material, that of a hit.
  [[nodiscard]] std::size_t number_of(const Material& material) const {
    return std::size_t(&material - materials_.data());
  }

 private:
  struct Plane {
    Vec3d point, normal;  // unit
    const Material& material;
  };
  /// Where what has a frame of its own is in the world.
  struct Frame {
    Affine to_world, from_world;
  };
  /// The same of what may move.
  struct Place {
    Frame still;  ///< at time 0
    std::optional<MovingMap> moves{};
    bool open = false;  ///< whether it does while the shutter is open

    /// At a time; of what moves in `moved`.
    [[nodiscard]] const Frame& at(float time, Frame& moved) const {
      return open ? moved = frame_at(time) : still;
    }
    [[nodiscard]] Frame frame_at(float time) const;
    [[nodiscard]] const MovingMap* motion() const { return moves ? &*moves : nullptr; }
  };
  struct PlacedBody {
    std::unique_ptr<const RayBody> body;
    Place place;
    double clearance;  // world units, beside that of places far away
    const Material& material;
  };
  /// Of triangles in their own frame.
  struct MovingMesh {
    MeshScene triangles;
    Place place;
    const Material& material;
  };
  struct Add;

  [[nodiscard]] static std::optional<double> meet(const Plane& plane, const Ray& ray, double limit);
  [[nodiscard]] static std::optional<RayBody::Hit> meet(const PlacedBody& body, const Frame& frame,
                                                        const Ray& ray, double limit);
  [[nodiscard]] static std::optional<MeshScene::Hit> meet(const MovingMesh& mesh,
                                                          const Frame& frame, const Ray& ray,
                                                          double limit);

  std::vector<Material> materials_;  ///< of all, in their order
  std::vector<Plane> planes_;
  std::vector<PlacedBody> bodies_;
  std::vector<MovingMesh> moving_meshes_;
  /// Of those that stand still while the shutter is open.
  struct MeshLook {
    const Material& material;
    std::optional<MovingMap> moves;
  };
  std::vector<MeshLook> mesh_looks_;
  std::optional<MeshScene> meshes_;
  bool catch_shadows_ = false, are_grey_ = true, move_ = false;
};

/// The surfaces that each kind of ray meets; the same set where all meet the same ones.
struct Surfaces {
  std::shared_ptr<const SurfaceSet> camera, shadow, scattered;
  std::vector<std::size_t> seen;  ///< numbers in the scene of those that the camera meets

  /// Whether one is in the way of light that comes along a ray from this distance. A lamp on a wall
  /// is not hidden by it.
  [[nodiscard]] bool hide(const Ray& ray, double distance, float time) const {
    constexpr double kUpTo = 1 - 1e-6;
    return shadow->block(ray, distance * kUpTo, time);
  }
  /// False only where none of any kind reaches into a box of the world while the shutter is open.
  [[nodiscard]] bool may_reach(const Box& box) const {
    return camera->may_reach(box) || shadow->may_reach(box) || scattered->may_reach(box);
  }
  /// How far a place of the world is at least from all of them then, up to `most`.
  [[nodiscard]] double distance(Vec3d place, double most) const {
    double nearest = camera->distance(place, most);
    if (shadow != camera) nearest = shadow->distance(place, nearest);
    if (scattered != camera && scattered != shadow) nearest = scattered->distance(place, nearest);
    return nearest;
  }
  [[nodiscard]] bool move() const { return camera->move() || shadow->move() || scattered->move(); }
  /// Whether scattered rays meet others than those that cast shadows.
  [[nodiscard]] bool shadows_differ() const { return shadow != scattered; }
  /// Whether light is the same whatever rays it meets the surfaces by, but for what the camera sees
  /// first: a constant may be left out of it then.
  [[nodiscard]] bool are_even() const { return !shadows_differ() && !camera->catch_shadows(); }
  /// Whether those that scatter light scatter every channel alike.
  [[nodiscard]] bool are_grey() const { return camera->are_grey() && scattered->are_grey(); }
};

/// Null for none.
[[nodiscard]] std::shared_ptr<const Surfaces> make_surfaces(std::span<const Surface> surfaces,
                                                            const Shutter& shutter);

}  // namespace pvol::detail
