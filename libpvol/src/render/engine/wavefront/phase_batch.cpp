#include "render/engine/wavefront/phase_batch.h"

namespace pvol::detail {
namespace {

Vec3f vector_of(const float (&v)[3][kMostLanes], std::size_t lane) {
  return {v[0][lane], v[1][lane], v[2][lane]};
}

}  // namespace

void find_densities(std::span<const MediumComponent> all, std::size_t count, PhaseBatch& lanes) {
  for (std::size_t k = 0; k < count; ++k) {
    lanes.pdf[k] =
        pdf_phase(all[lanes.component[k]].phase, vector_of(lanes.from, k), vector_of(lanes.to, k));
  }
}

void sample_directions(std::span<const MediumComponent> all, std::size_t count, PhaseBatch& lanes) {
  for (std::size_t k = 0; k < count; ++k) {
    const PhaseSample s = sample_phase(all[lanes.component[k]].phase, vector_of(lanes.from, k),
                                       lanes.u[k], lanes.azimuth[k]);
    for (int axis = 0; axis < 3; ++axis) lanes.to[axis][k] = s.direction[axis];
    lanes.pdf[k] = s.pdf;
  }
}

}  // namespace pvol::detail
