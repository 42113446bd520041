// Bounds of a density that moves: leaf by leaf, from the box that its density came from.
#include <algorithm>
#include <cmath>
#include <vector>

#include "pvol/error.h"
#include "pvol/math/parallel.h"
#include "pvol/volume/motion.h"
#include "volume/still_ranges.h"

namespace pvol {
namespace {

using detail::StillRanges;
using Codes = std::vector<std::uint64_t>;

constexpr std::uint64_t kMostLeaves = std::uint64_t(1) << 26;

[[nodiscard]] Vec3d floor(Vec3d v) { return {std::floor(v.x), std::floor(v.y), std::floor(v.z)}; }
[[nodiscard]] Vec3d ceil(Vec3d v) { return -floor(-v); }

/// Descends from a cube around all that the density can reach to the leaves that it does reach.
class Sweep {
 public:
  Sweep(const Pyramid& pyramid, const VolumeField& still, const Displacements& d, const Shutter& s)
      : d_(d),
        from_(std::min(s.open, 0.0)),
        to_(std::max(s.close, 0.0)),
        ranges_(pyramid, still),
        still_origin_(pyramid.origin) {
    // Where the density may get to: the largest displacement on all sides.
    const Vec3d reach(double(d.largest) * s.farthest() + kRounding * (1 + double(d.largest)));
    result_.look_up = pyramid.look_up;
    result_.support_lo = Vec3l(floor(Vec3d(pyramid.support_lo) - reach));
    result_.support_hi = Vec3l(ceil(Vec3d(pyramid.support_hi) + reach));
    std::int64_t edge = kLeafEdge;
    for (int axis = 0; axis < 3; ++axis) {
      result_.origin[axis] = result_.support_lo[axis] & -std::int64_t(kLeafEdge);
      edge = std::max(edge, result_.support_hi[axis] - result_.origin[axis]);
    }
    while (std::int64_t(kLeafEdge) << levels_ < edge) ++levels_;
    ++levels_;
    if (levels_ + 2 > kMaxRootLog2 || min_component(Vec3d(result_.origin)) < double(kMinOrigin) ||
        max_component(Vec3d(result_.support_hi)) > double(kMaxOrigin) - 2 * kLeafEdge) {
      throw Error(
          "the medium moves over more than 2^24 voxels along an axis, the most that a cloud may "
          "span; check the scale of its velocities, and the camera's fps");
    }
  }

  [[nodiscard]] Pyramid run() {
    Codes cubes{0};
    for (int level = levels_ - 1; level > 0; --level) cubes = children_of(occupied(level, cubes));
    result_.levels.resize(std::size_t(levels_));
    add_leaves(cubes);
    complete_levels(result_);
    if (result_.levels.back().empty()) {
      Pyramid nothing;
      nothing.look_up = result_.look_up;
      return nothing;
    }
    result_.scale = result_.levels.back().front().hi;
    shrink_support();
    return std::move(result_);
  }

 private:
  static constexpr double kRounding = 1e-6;

  const Displacements& d_;
  double from_, to_;  // times
  StillRanges ranges_;
  Vec3l still_origin_;
  Pyramid result_;
  int levels_ = 0;

  /// The box that the density of a cube was in at the files' time, in cells of the still pyramid.
  [[nodiscard]] Box source_of(int level, std::uint64_t code) const {
    const std::int64_t edge = std::int64_t(kLeafEdge) << level;
    const Vec3l low = result_.origin + Vec3l(morton_decode(code)) * edge;
    Box box{Vec3d(low), Vec3d(low + Vec3l(edge))};
    const Displacements::Range move = range_over(d_, box);
    for (int axis = 0; axis < 3; ++axis) {
      const double lo = double(move.lo[axis]), hi = double(move.hi[axis]);
      const double way[4] = {-from_ * lo, -from_ * hi, -to_ * lo, -to_ * hi};
      const double least = *std::min_element(way, way + 4), most = *std::max_element(way, way + 4);
      // Displacements and times are floats, of which look-ups make places.
      const double rounding = lo == 0 && hi == 0 ? 0 : kRounding * (1 + most - least);
      box.lo[axis] += least - rounding;
      box.hi[axis] += most + rounding;
    }
    const Vec3d origin(still_origin_);
    return {box.lo - origin, box.hi - origin};
  }

  [[nodiscard]] Codes occupied(int level, const Codes& cubes) const {
    std::vector<char> keep(cubes.size());
    parallel_parts(0, cubes.size(), 16, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i != end; ++i) {
        keep[i] = ranges_.any(source_of(level, cubes[i]));
      }
    });
    Codes kept;
    for (std::size_t i = 0; i < cubes.size(); ++i) {
      if (keep[i]) kept.push_back(cubes[i]);
    }
    return kept;
  }

  [[nodiscard]] static Codes children_of(const Codes& cubes) {
    if (cubes.size() > kMostLeaves / 8) {
      throw Error(
          "while the shutter is open, the cloud covers more than 2^26 leaves of 8^3 voxels; "
          "shorten the shutter, or render a preview");
    }
    Codes all;
    all.reserve(8 * cubes.size());
    for (const std::uint64_t code : cubes) {
      for (std::uint64_t k = 0; k < 8; ++k) all.push_back(code * 8 + k);
    }
    return all;
  }

  void add_leaves(const Codes& cubes) {
    std::vector<PyramidNode> leaves(cubes.size());
    parallel_parts(0, cubes.size(), 16, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i != end; ++i) {
        const DensityRange r = ranges_.over(source_of(0, cubes[i]));
        leaves[i] = {cubes[i], r.lo, r.hi};
      }
    });
    std::erase_if(leaves, [](const PyramidNode& n) { return !(n.hi > 0); });
    result_.levels[0] = std::move(leaves);
  }

  /// To the leaves that are left.
  void shrink_support() {
    Vec3l lo = result_.support_hi, hi = result_.support_lo;
    for (const PyramidNode& n : result_.levels[0]) {
      const Vec3l at = result_.origin + Vec3l(morton_decode(n.code)) * std::int64_t(kLeafEdge);
      lo = min(lo, at);
      hi = max(hi, at + Vec3l(kLeafEdge));
    }
    result_.support_lo = max(result_.support_lo, lo);
    result_.support_hi = min(result_.support_hi, hi);
  }
};

}  // namespace

Pyramid sweep_bounds(const Pyramid& pyramid, const VolumeField& still,
                     const Displacements& displacements, const Shutter& shutter) {
  if (pyramid.empty()) return pyramid;
  return Sweep(pyramid, still, displacements, shutter).run();
}

}  // namespace pvol
