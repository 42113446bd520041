// Scenes described once, in terms of lattices and functions, for two readers: pvol, which makes its
// volumes of them, and the path tracer of definitions (reference_tracer.h).
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "pvol/math/field_map.h"
#include "pvol/volume/fire.h"
#include "pvol/volume/moving_places.h"
#include "support/cloud_scene.h"
#include "support/fields.h"

namespace pvol::test {

/// A fire over samples of its own, in the object's space.
struct ReferenceFire {
  const Field* field;
  double intensity;  ///< radiance per world unit where the field is 1
  Rgb color;
};

/// A volume whose object space is its field's index space.
struct ReferenceVolume {
  const Field* field;  ///< lives as long as all volumes that are made of it
  Medium medium{};
  std::vector<MovingPlace> places{1};  ///< at least one; they may stand still
  FieldMap map{};                      ///< of densities
  // Linear functions of places of the object, which interpolation gives back exactly:
  std::function<Vec3d(Vec3d)> albedo{};    ///< by which albedos are multiplied; null: 1
  std::function<Vec3d(Vec3d)> velocity{};  ///< displacement of a frame; null: it stands still
  std::optional<ReferenceFire> fire{};
  bool share_samples = false;
};

/// Lattice points at which albedos and velocities are told, which is all around any field here.
inline constexpr Vec3i kToldFrom{-24, -24, -24}, kToldSize{64, 64, 64};

struct ReferenceScene {
  CloudScene scene;  ///< all but its medium, which those of the volumes stand for
  std::vector<ReferenceVolume> volumes;
};

/// The scene's volumes as pvol has them. Throws Error where pvol refuses one.
[[nodiscard]] std::vector<Volume> make_volumes(const ReferenceScene& scene);

}  // namespace pvol::test
