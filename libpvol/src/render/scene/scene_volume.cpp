#include "pvol/render/scene_volume.h"

namespace pvol {

namespace {

/// Shadow rays by ratio and the like look up every density that they meet, which is fastest in
/// copies.
SampleStorage storage_for(Transmittance estimator) {
  using enum Transmittance;
  return estimator == analog || estimator == automatic ? SampleStorage::automatic
                                                       : SampleStorage::copied;
}

}  // namespace

VolumeOptions volume_options(const RenderOptions& o) {
  return {.object_to_world = {},
          .look_up = o.look_up,
          .micro_bounds = o.micro_bounds,
          .depth = o.depth,
          .tracker = o.tracker,
          .majorant_scale = o.majorant_scale,
          .homogenise = o.homogenise,
          .paths = double(o.width) * o.height * expected_samples(o),
          .samples = storage_for(o.transmittance)};
}

}  // namespace pvol
