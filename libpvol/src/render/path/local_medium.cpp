#include "render/path/local_medium.h"

#include "pvol/volume/albedo_field.h"
#include "volume/any_source.h"

namespace pvol::detail {

LocalMedium local_medium(const CollisionPlace& place, const MediumComponent& component,
                         float time) {
  const VolumeSetup& volume = *place.volume;
  const AlbedoField* const field = volume.volume.albedo.get();
  if (field == nullptr) return everywhere(component);
  const Vec3d cells = place_at_rest(volume.volume.density, time, place.cells);
  return colored(component, color_in(*field, volume.cells_to_albedo.point(cells)));
}

}  // namespace pvol::detail
