// The walk of a ray through an octree of bounds: segment after segment of constant majorant and
// minorant. Trackers see segments only; the walk knows nothing of trackers.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "pvol/bounds/octree.h"

namespace pvol {

/// A piece of a ray with bounds on mu_t. Pieces come in order and do not overlap; between them,
/// mu_t is 0.
struct Segment {
  double t0, t1;    ///< world arc length from the walk's start; in double, since steps between
                    ///< tentative collisions may be far below the last digit of a float
  float lo, hi;     ///< lo <= mu_t <= hi on [t0, t1], hi > 0 [1/world length]
  LeafHandle leaf;  ///< for look-ups
};

/// A place in the octree that persists along a path: its position and the nodes above it, so that a
/// new direction starts where the last one ended, without a descent from the root.
struct Cursor {
  LatticePoint at;
  int height = 0;                                ///< of the lowest node that is known to hold `at`
  std::uint32_t nodes[Octree::kMaxHeight] = {};  ///< by height; those from `height` up are valid
};

/// The point that is given in cells from the octree's origin, moved into the support's box where it
/// lies outside.
[[nodiscard]] inline LatticePoint lattice_point(const Octree& tree, Vec3d cells) {
  Vec3i cell;
  Vec3f frac;
  for (int axis = 0; axis < 3; ++axis) {
    const double whole = std::clamp(std::floor(cells[axis]), double(tree.support_lo[axis]),
                                    double(tree.support_hi[axis] - 1));
    cell[axis] = std::int32_t(whole);
    frac[axis] = std::clamp(float(cells[axis] - whole), 0.0f, 1.0f);
  }
  // Not by elements in memory: reading a vector that was just written piece by piece waits for all
  // that came before, cache misses included.
  return {widen(cell), widen(frac)};
}

/// A cursor at that point: a ray starts where it enters the support's box.
[[nodiscard]] inline Cursor make_cursor(const Octree& tree, Vec3d cells) {
  Cursor c;
  c.at = lattice_point(tree, cells);
  c.height = tree.height;
  return c;  // nodes[height] is 0, the root
}

/// Iterator over the segments of a ray from a cursor. `direction` is the change of the position in
/// cells per world length (the spare lane 0); any component may be 0 or -0. The walk ends at the
/// support's box, give or take rounding, or at `length`. Requires a direction other than 0. The
/// walk moves a cursor of its own, refers to the tree, and can be copied and assigned; one that was
/// made of nothing has no segments.
class Walk {
 public:
  Walk() = default;
  Walk(const Octree& tree, const Cursor& cursor, Float4 direction,
       double length = std::numeric_limits<double>::infinity())
      : tree_(&tree), cursor_(cursor), at_(cursor.at), d_(direction) {
    start(length);
  }

  /// The same from make_cursor's at this point, without a copy of it.
  Walk(const Octree& tree, const LatticePoint& from, Float4 direction,
       double length = std::numeric_limits<double>::infinity())
      : tree_(&tree), cursor_{.at = from, .height = tree.height}, at_(from), d_(direction) {
    start(length);
  }

  /// The next segment with hi > 0, or nothing at the end.
  [[nodiscard, gnu::always_inline]] std::optional<Segment> next() {
    return next([] {});
  }

  /// The same; calls on_skip() for each empty cube on the way.
  template <class OnSkip>
  [[nodiscard, gnu::always_inline]] std::optional<Segment> next(const OnSkip& on_skip) {
    if (pending_) leave();
    while (left_ > 0) {
      const Octree::Entry* e = descend();
      measure_exit();
      if (e != nullptr && step_ > 0) {
        pending_ = true;
        const LeafHandle leaf =
            e->grouped ? Octree::kNodeBit | cursor_.nodes[cursor_.height] : e->link;
        return Segment{t_, t_ + double(step_), e->lo, e->hi, leaf};
      }
      on_skip();
      leave();
    }
    return std::nullopt;
  }

  /// The point at t of the current segment, clamped to its cube: rounding never reaches a cell
  /// whose bounds are not the segment's.
  [[nodiscard, gnu::always_inline]] LatticePoint point(double t) const {
    return after(float(t - t_));
  }

  /// A handle of the current segment: of the lowest node that is known to hold it, from which
  /// look-ups may take a step more than from the segment's own.
  [[nodiscard]] LeafHandle handle() const {
    return Octree::kNodeBit | cursor_.nodes[cursor_.height];
  }

  /// A cursor at a point of the current segment, for a path that turns there.
  [[nodiscard]] Cursor stop_at(const LatticePoint& p) const {
    Cursor c = cursor_;
    c.at = p;
    return c;
  }

 private:
  [[gnu::always_inline]] void start(double length) {
    // The reciprocal of 0 is large, not infinite: its product with a distance of 0 is 0.
    constexpr float kTiny = std::numeric_limits<float>::min();
    up_ = d_ >= 0;
    inv_ = 1.0f / select(up_, max(d_, splat(kTiny)), min(d_, splat(-kTiny)));
    const Int4 end = select(up_, tree_->support_hi, tree_->support_lo);
    // A little beyond the support, where there is nothing: rounding must not end the walk before
    // it.
    constexpr double kBeyond = 1 + 0x1p-20;
    left_ = std::min(length, kBeyond * double(least((to_float(end - at_.cell) - at_.frac) * inv_)));
  }

  /// Finds the terminal or empty cube (null) that holds the current cell, and its size.
  [[gnu::always_inline]] const Octree::Entry* descend() {
    int h = cursor_.height;
    std::uint32_t node = cursor_.nodes[h];
    for (;;) {
      const int shift = Octree::child_log2(h);
      const Octree::Entry* e = tree_->child(tree_->nodes[node], Octree::child_bit(at_.cell, shift));
      if (e == nullptr || e->log2 != 0) {
        cursor_.height = h;
        size_ = 1 << (e == nullptr ? shift : int(e->log2));
        return e;
      }
      node = e->link & ~Octree::kNodeBit;
      cursor_.nodes[--h] = node;
    }
  }

  /// The point a distance into the current cube, clamped to it.
  [[nodiscard, gnu::always_inline]] LatticePoint after(float distance) const {
    const Float4 x = at_.frac + d_ * splat(distance);
    const Int4 low = at_.cell & -size_;
    const Int4 cell = min(max(at_.cell + floor_to_int(x), low), low + (size_ - 1));
    const Float4 frac = x - to_float(cell - at_.cell);
    return {cell, min(max(frac, splat(0.0f)), splat(1.0f))};
  }

  /// Distance to the faces through which the ray leaves the cube.
  [[gnu::always_inline]] void measure_exit() {
    const Int4 low = at_.cell & -size_;
    const Int4 face = low + (up_ & size_);
    exit_ = (to_float(face - at_.cell) - at_.frac) * inv_;
    step_ = std::max(0.0f, std::min(float(left_), least(exit_)));
  }

  /// Moves to the nearest face, into the next cube, and up to the node that holds both. The axes
  /// that pass no face stay in the cube: were rounding to take one back across a face that it has
  /// passed, axes could undo each other's steps for ever.
  [[gnu::always_inline]] void leave() {
    pending_ = false;
    t_ += double(step_);
    if (!(step_ < float(left_))) {
      left_ = 0;
      return;
    }
    left_ -= double(step_);
    const Int4 through = exit_ <= step_;
    const LatticePoint stay = after(step_);
    const Int4 low = at_.cell & -size_;
    const Int4 cell = select(through, select(up_, low + size_, low - 1), stay.cell);
    at_.frac = select(through, select(up_, splat(0.0f), splat(1.0f)), stay.frac);
    const std::int32_t moved = any_bits(cell ^ at_.cell);
    at_.cell = cell;
    const int top = 31 - std::countl_zero(std::uint32_t(moved) | 1);
    cursor_.height = std::max(cursor_.height, (top - 1) >> 1);
    if (cursor_.height > tree_->height) left_ = 0;  // left the root
  }

  const Octree* tree_ = nullptr;
  Cursor cursor_;
  LatticePoint at_;  // start of the current cube's stretch
  Float4 d_{}, inv_{};
  Int4 up_{};              // -1 where the direction is not negative, else 0
  Float4 exit_{};          // world length to the faces ahead
  double t_ = 0;           // world length walked to `at_`
  double left_ = 0;        // world length left from there; a float would drift over many steps
  float step_ = 0;         // world length within the current cube
  std::int32_t size_ = 8;  // edge of the current cube in cells
  bool pending_ = false;   // a segment was handed out and not yet left
};

}  // namespace pvol
