// A scene and the one cloud in it: what most tests of pictures need.
#pragma once

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "pvol/bounds/pyramid.h"
#include "pvol/field/leaf_micro_bounds.h"
#include "pvol/render/render.h"
#include "pvol/render/scene_volume.h"
#include "pvol/volume/make_volume.h"
#include "support/effort.h"
#include "support/kernel.h"

namespace pvol::test {

/// A medium and where it lies. Most tests have one component, whose properties stand here.
struct Body {
  double extinction = 1;
  Rgb albedo{0.999f};
  double g = 0.5;
  Rgb emission{0.0f};
  std::vector<Component> others{};  ///< their shares are taken from the first component's
  Affine object_to_world{};

  [[nodiscard]] Medium medium() const {
    Medium m{extinction, {Component{1, albedo, HenyeyGreenstein(g), emission}}};
    for (const Component& c : others) {
      m.components.front().share -= c.share;
      m.components.push_back(c);
    }
    return m;
  }
  friend bool operator==(const Body&, const Body&) = default;
};

struct CloudScene {
  Camera camera;
  Environment environment = GradientSky{};
  std::vector<Light> lights;
  Body medium;
  RenderOptions options;
  std::vector<Surface> surfaces{};

  [[nodiscard]] Scene scene() const { return {camera, environment, lights, options, surfaces}; }
  [[nodiscard]] VolumeOptions volume_options() const {
    VolumeOptions o = pvol::volume_options(options);
    o.object_to_world = medium.object_to_world;
    return o;
  }
};

[[nodiscard]] inline Volume make_volume(const VoxelGrid& grid, const Pyramid& pyramid,
                                        const CloudScene& s,
                                        const LeafMicroBounds* stored = nullptr) {
  return pvol::make_volume(grid, pyramid, s.medium.medium(), s.volume_options(), stored);
}
[[nodiscard]] inline Volume make_volume(std::shared_ptr<const Recipe> recipe,
                                        const Pyramid& pyramid, const CloudScene& s) {
  return pvol::make_volume(std::move(recipe), pyramid, s.medium.medium(), s.volume_options());
}

/// Renders volumes with the medium that they were made with; a run with new random numbers shifts
/// the seed.
[[nodiscard]] inline RenderResult render(std::span<const Volume> volumes, const CloudScene& s,
                                         const Progress& progress = {}) {
  Scene scene = s.scene();
  scene.options.kernel = kernel_for(volumes, scene);
  scene.options.seed = proof::seeded(scene.options.seed);
  return pvol::render(volumes, scene, progress);
}

/// Renders the volume with the medium that the scene's body has now.
[[nodiscard]] inline RenderResult render(Volume volume, const CloudScene& s,
                                         const Progress& progress = {}) {
  volume.medium = s.medium.medium();
  return render(std::span<const Volume>(&volume, 1), s, progress);
}

}  // namespace pvol::test
