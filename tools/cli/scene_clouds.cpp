#include "cli/scene_clouds.h"

#include <algorithm>

namespace pvol::cli {
namespace {

bool are_alike(const formats::SceneVolume& a, const formats::SceneVolume& b) {
  return a.file == b.file && a.grid == b.grid && a.fire == b.fire &&
         a.has_intensity == b.has_intensity;
}

}  // namespace

std::shared_ptr<const formats::Cloud> SceneClouds::load(formats::SceneVolume& volume) {
  const formats::SceneVolume given = volume;
  const auto alike = [&](const Kept& k) { return are_alike(k.given, given); };
  if (const auto k = std::ranges::find_if(kept_, alike); k != kept_.end()) {
    volume.grid = k->chosen.grid;
    volume.fire = k->chosen.fire;
    volume.has_intensity = k->chosen.has_intensity;
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
