#include "pvol/render/scene_volume.h"

namespace pvol {

VolumeOptions volume_options(const RenderOptions& o) {
  const double width = o.crop_width > 0 ? o.crop_width : o.width;
  const double height = o.crop_height > 0 ? o.crop_height : o.height;
  return {.object_to_world = {},
          .look_up = o.look_up,
          .micro_bounds = o.micro_bounds,
          .depth = o.depth,
          .tracker = o.tracker,
          .majorant_scale = o.majorant_scale,
          .homogenise = o.homogenise,
          .paths = width * height * expected_samples(o)};
}

}  // namespace pvol
