// What records of paths hold besides their rays.
#pragma once

#include "volume/simd/records.h"

namespace pvol::detail {

/// Behind kW0, which grey weights have alone. Not every queue has a use for all of them.
enum PathField : std::size_t {
  kW1 = kRayFields,
  kW2,         ///< weight by channel
  kPdf,        ///< density of the phase function for the direction, where lights ask for it
  kAux,        ///< of the stage
  kComponent,  ///< number of the component that the path collided with
  kFromX,
  kFromY,
  kFromZ,  ///< where the flight began, in scenes of WavefrontScene::lines
  // Through many volumes:
  kStepX,
  kStepY,
  kStepZ,  ///< of the ray, in cells of where it flies, per world length
  kRay,    ///< what it is in the world (world_rays.h)
  kTime,   ///< of its path, in frames, in scenes of WavefrontScene::times
  kPathFields,
};
static_assert(kPathFields <= kMostFields);

}  // namespace pvol::detail
