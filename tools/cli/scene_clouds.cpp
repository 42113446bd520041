#include "cli/scene_clouds.h"

#include <algorithm>

namespace pvol::cli {
namespace {

/// Whether they differ at most by what is made of a cloud, not by what is read.
bool are_alike(const formats::SceneVolume& a, formats::SceneVolume b) {
  b.medium = a.medium;
  b.has_extinction = a.has_extinction;
  b.object_to_world = a.object_to_world;
  b.instances = a.instances;
  b.moving = a.moving;
  b.moving_instances = a.moving_instances;
  b.density_map = a.density_map;
  return a == b;
}

}  // namespace

std::shared_ptr<const formats::Cloud> SceneClouds::load(formats::SceneVolume& volume) {
  const formats::SceneVolume given = volume;
  const auto alike = [&](const Kept& k) { return are_alike(k.given, given); };
  if (const auto k = std::ranges::find_if(kept_, alike); k != kept_.end()) {
    volume.grid = k->chosen.grid;
    volume.fire = k->chosen.fire;
    volume.has_intensity = k->chosen.has_intensity;
    volume.albedo_field = k->chosen.albedo_field;
    return k->cloud;
  }
  auto cloud = std::make_shared<const formats::Cloud>(load_cloud(by_, volume, strict_, scene_));
  const auto others = std::ranges::count_if(
      given_, [&](const formats::SceneVolume& v) { return are_alike(v, given); });
  if (others > 1 && (!volume.fire || given.has_intensity)) {
    kept_.push_back({given, volume, cloud});
  }
  return cloud;
}

}  // namespace pvol::cli
