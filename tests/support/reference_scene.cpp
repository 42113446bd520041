#include "support/reference_scene.h"

#include <memory>

#include "pvol/volume/emitter.h"
#include "pvol/volume/motion.h"
#include "support/colors.h"
#include "support/velocities.h"

namespace pvol::test {
namespace {

VolumeOptions options_of(const ReferenceVolume& v, const CloudScene& scene) {
  VolumeOptions o = volume_options(scene.options);
  o.object_to_world = v.places.front().object.at(0);
  const bool instanced = v.places.size() > 1 || v.places.front().instance != MovingMap{};
  for (const MovingPlace& place : v.places) {
    if (instanced) o.instances.push_back(place.instance.at(0));
  }
  if (!v.map.is_identity()) o.map = std::make_shared<const FieldMap>(v.map);
  if (v.share_samples) o.samples = SampleStorage::shared;
  return o;
}

Volume make(const ReferenceVolume& v, const CloudScene& scene) {
  const VolumeOptions o = options_of(v, scene);
  const VoxelGrid& grid = v.field->grid;
  const Pyramid pyramid = build_pyramid(grid, o.look_up);
  Volume made = pvol::make_volume(grid, pyramid, v.medium, o);
  VelocityGrid velocity;
  if (v.velocity) {
    velocity = make_velocity(kToldFrom, kToldFrom + kToldSize,
                             [&](Vec3i p) { return v.velocity(Vec3d(p)); });
  }
  const Movement by{velocity, 1, scene.camera.shutter};
  if (v.velocity) made = make_moving(made, pyramid, grid.index_to_world, by, o);
  const Affine place = v.places.front().at(0);
  if (v.albedo) {
    const auto color = [&](Vec3i p) { return Rgb(v.albedo(Vec3d(p))); };
    made.albedo = albedo_of(make_colors(kToldFrom, kToldSize, color), &grid, place);
  }
  if (v.fire) {
    const VoxelGrid& burning = v.fire->field->grid;
    const Pyramid bounds = build_pyramid(burning);
    const Fire fire{.intensity = v.fire->intensity, .color = v.fire->color};
    Emitter emitter = make_emitter(fire, {burning, bounds}, nullptr, place);
    if (v.velocity) emitter = make_moving(std::move(emitter), {burning, bounds}, place, by);
    made.fire = std::make_shared<const Emitter>(std::move(emitter));
  }
  return move_places(made, v.places, scene.camera.shutter);
}

}  // namespace

std::vector<Volume> make_volumes(const ReferenceScene& scene) {
  std::vector<Volume> all;
  for (const ReferenceVolume& v : scene.volumes) all.push_back(make(v, scene.scene));
  return all;
}

}  // namespace pvol::test
