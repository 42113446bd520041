// Rays that a volume's shell turns away.
#pragma once

#include <cstdint>

#include "render/path/volume_setup.h"

namespace pvol::detail {

struct ShellCounts {
  std::uint64_t tests = 0, rejections = 0;
};

/// Whether a ray misses the volume's shell. It would meet no density then; random numbers of camera
/// rays are keyed by sample: the picture of one volume stays the same to the last bit.
[[nodiscard]] inline bool outside_shell(const VolumeSetup& volume, const Ray& cells,
                                        const Span& span, ShellCounts& counts) {
  if (!volume.shell) return false;
  ++counts.tests;
  const bool outside = volume.shell->misses(cells, span.t0, span.t1);
  counts.rejections += outside;
  return outside;
}

}  // namespace pvol::detail
