#include "pvol/render/scene_volume.h"

#include <utility>

namespace pvol {

VolumeOptions volume_options(const RenderOptions& o) {
  const double width = o.crop_width > 0 ? o.crop_width : o.width;
  const double height = o.crop_height > 0 ? o.crop_height : o.height;
  return {.interpolation = o.interpolation,
          .micro_bounds = o.micro_bounds,
          .depth = o.depth,
          .tracker = o.tracker,
          .majorant_scale = o.majorant_scale,
          .homogenise = o.homogenise,
          .paths = width * height * o.samples};
}

Volume make_volume(const VoxelGrid& grid, const Pyramid& pyramid, const Scene& scene,
                   const LeafMicroBounds* stored) {
  return make_volume(grid, pyramid, scene.medium, volume_options(scene.options), stored);
}

Volume make_volume(std::shared_ptr<const Recipe> recipe, const Pyramid& pyramid,
                   const Scene& scene) {
  return make_volume(std::move(recipe), pyramid, scene.medium, volume_options(scene.options));
}

}  // namespace pvol
