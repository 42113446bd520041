// Segments from a list, where a test wants bounds of its own.
#pragma once

#include <optional>
#include <vector>

#include "pvol/bounds/walk.h"

namespace pvol::test {

/// Stands in for a Walk. `point(t)` carries t in the offset along x.
struct SegmentList {
  std::vector<Segment> segments;
  std::size_t at = 0;

  std::optional<Segment> next() {
    return at < segments.size() ? std::optional<Segment>(segments[at++]) : std::nullopt;
  }
  [[nodiscard]] static LatticePoint point(double t) {
    return {Int4{}, widen(Vec3f(float(t), 0, 0))};
  }
};

}  // namespace pvol::test
