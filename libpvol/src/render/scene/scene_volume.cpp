#include "pvol/render/scene_volume.h"

namespace pvol {

VolumeOptions volume_options(const RenderOptions& o) {
  return {.object_to_world = {},
          .look_up = o.look_up,
          .micro_bounds = o.micro_bounds,
          .depth = o.depth,
          .tracker = o.tracker,
          .majorant_scale = o.majorant_scale,
          .homogenise = o.homogenise,
          .paths = double(o.width) * o.height * expected_samples(o)};
}

}  // namespace pvol
