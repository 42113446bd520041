// The range of a still density over any box, from its pyramid and, where a box cuts a leaf, from
// the leaf's samples.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "bounds/octree_children.h"
#include "pvol/bounds/pyramid.h"
#include "pvol/field/micro_range.h"
#include "pvol/volume/volume.h"
#include "volume/field_samples.h"

namespace pvol::detail {

class StillRanges {
 public:
  /// The field was made with the pyramid.
  StillRanges(const Pyramid& pyramid, const VolumeField& field) : p_(pyramid), f_(field) {}

  /// Of the density over a box in cells from the pyramid's origin that is no thinner than a cell.
  [[nodiscard]] DensityRange over(const Box& box) const {
    const double edge = double(std::int64_t(kLeafEdge) << top());
    const bool inside =
        min(box.lo, Vec3d(0)) == Vec3d(0) && max(box.hi, Vec3d(edge)) == Vec3d(edge);
    DensityRange r{inside ? p_.scale : 0.0f, 0};
    if (meets(box, {}, edge)) {
      add(top(), 0, {}, box, r);
    } else {
      r.lo = 0;
    }
    return r;
  }

  /// Whether there is any density in the box, or may be.
  [[nodiscard]] bool any(const Box& box) const {
    return meets(box, {}, double(std::int64_t(kLeafEdge) << top())) && any(top(), 0, {}, box);
  }

 private:
  const Pyramid& p_;
  const VolumeField& f_;

  [[nodiscard]] std::size_t top() const { return p_.levels.size() - 1; }

  /// Whether a box meets the inside of a cube. Bounds hold for closed cubes, so that faces add
  /// nothing.
  [[nodiscard]] static bool meets(const Box& box, Vec3l low, double edge) {
    const Vec3d lo(low), hi = lo + Vec3d(edge);
    return box.lo.x < hi.x && box.lo.y < hi.y && box.lo.z < hi.z && box.hi.x > lo.x &&
           box.hi.y > lo.y && box.hi.z > lo.z;
  }

  /// visit(index of the child, or none where it is absent; its low corner) for those that meet the
  /// box, until one returns true.
  template <class Visit>
  bool visit_children(std::size_t level, std::size_t i, Vec3l low, const Box& box,
                      const Visit& visit) const {
    const NodeRange range = children(p_, level, i);
    const std::int64_t edge = std::int64_t(kLeafEdge) << (level - 1);
    const std::uint64_t first = p_.levels[level][i].code * 8;
    std::size_t next = range.begin;
    for (std::uint64_t k = 0; k < 8; ++k) {
      const bool present = next < range.end && p_.levels[level - 1][next].code == first + k;
      const std::size_t child = next;
      next += present;
      const Vec3l at =
          low + Vec3l(std::int64_t(k & 1), std::int64_t(k >> 1 & 1), std::int64_t(k >> 2)) * edge;
      if (meets(box, at, double(edge)) && visit(present, child, at)) return true;
    }
    return false;
  }

  void add(std::size_t level, std::size_t i, Vec3l low, const Box& box, DensityRange& r) const {
    const PyramidNode& node = p_.levels[level][i];
    if (r.lo <= node.lo && node.hi <= r.hi) return;
    const Vec3d lo(low), hi = lo + Vec3d(double(std::int64_t(kLeafEdge) << level));
    const bool whole = min(lo, box.lo) == box.lo && max(hi, box.hi) == box.hi;
    if (whole || is_uniform(p_, level, i) || (level == 0 && f_.look_up == LookUp::tricubic)) {
      join(r, node.lo, node.hi);
    } else if (level == 0) {
      add_samples(low, box, r);
    } else {
      visit_children(level, i, low, box, [&](bool present, std::size_t child, Vec3l at) {
        if (present) {
          add(level - 1, child, at, box, r);
        } else {
          r.lo = 0;
        }
        return false;
      });
    }
  }

  /// Of the samples of a leaf that look-ups in the box read, widened by what these round
  /// (THEORY.md, T1.2).
  void add_samples(Vec3l low, const Box& box, DensityRange& r) const {
    constexpr float kSlack = 0x1p-21f;
    const std::uint32_t b = brick_of_leaf(f_.octree, widen(Vec3i(low)), kZeroBrick);
    std::array<float, kFieldSamples> scratch;
    const float* const samples = samples_of(f_, b, scratch.data());
    Vec3i from, to;
    for (int axis = 0; axis < 3; ++axis) {
      const double at = double(low[axis]);
      from[axis] = int(std::clamp(std::floor(box.lo[axis] - at), 0.0, 8.0));
      to[axis] = int(std::clamp(std::ceil(box.hi[axis] - at), 0.0, 8.0));
    }
    DensityRange here{std::numeric_limits<float>::max(), 0};
    for (Vec3i p = from; p.x <= to.x; ++p.x) {
      for (p.y = from.y; p.y <= to.y; ++p.y) {
        for (p.z = from.z; p.z <= to.z; ++p.z) {
          const float v = samples[(p.x * kFieldEdge + p.y) * kFieldEdge + p.z];
          join(here, v, v);
        }
      }
    }
    const float slack = here.lo < here.hi ? here.hi * kSlack : 0;
    join(r, std::max(0.0f, here.lo - slack), here.hi + slack);
  }

  [[nodiscard]] bool any(std::size_t level, std::size_t i, Vec3l low, const Box& box) const {
    if (level == 0 || is_uniform(p_, level, i)) return true;
    return visit_children(level, i, low, box, [&](bool present, std::size_t child, Vec3l at) {
      return present && any(level - 1, child, at, box);
    });
  }

  static void join(DensityRange& r, float lo, float hi) {
    r.lo = std::min(r.lo, lo);
    r.hi = std::max(r.hi, hi);
  }
};

}  // namespace pvol::detail
