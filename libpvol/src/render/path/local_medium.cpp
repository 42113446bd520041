#include "render/path/local_medium.h"

#include "pvol/volume/albedo_field.h"
#include "volume/any_source.h"

namespace pvol::detail {

Rgb local_color(const CollisionPlace& place, float time) {
  const VolumeSetup& volume = *place.volume;
  const AlbedoField* const field = volume.volume.albedo.get();
  if (field == nullptr) return Rgb(1.0f);
  const Vec3d cells = place_at_rest(volume.volume.density, time, place.cells);
  return color_in(*field, volume.cells_to_albedo.point(cells));
}

LocalMedium local_medium(const CollisionPlace& place, float time) {
  const VolumeSetup& volume = *place.volume;
  if (volume.volume.albedo == nullptr) return volume.mean;
  return mean_of(volume.components, local_color(place, time));
}

}  // namespace pvol::detail
