// The clouds of a scene's volumes, those that several volumes name alike read once.
#pragma once

#include <memory>
#include <vector>

#include "cli/load_scene.h"

namespace pvol::cli {

/// Loads the clouds of a scene, volume by volume, as load_cloud does. Keeps those that a further
/// volume may ask for: of the same file, grid, fire and velocities. A fire whose intensity is left
/// open is one of its place, which is no other's.
class SceneClouds {
 public:
  SceneClouds(Loader by, bool strict, const formats::SceneFile& scene)
      : by_(std::move(by)), strict_(strict), scene_(scene), given_(scene.volumes) {}

  /// `volume` is one of the scene's; what it leaves open is chosen.
  [[nodiscard]] std::shared_ptr<const formats::Cloud> load(formats::SceneVolume& volume);

 private:
  struct Kept {
    formats::SceneVolume given, chosen;
    std::shared_ptr<const formats::Cloud> cloud;
  };
  Loader by_;
  bool strict_;
  const formats::SceneFile& scene_;
  std::vector<formats::SceneVolume> given_;  ///< before anything was chosen
  std::vector<Kept> kept_;
};

}  // namespace pvol::cli
