#include "shell/fit/support_lattice.h"

#include <algorithm>

#include "shell/fit/distance_transform.h"
#include "shell/fit/sampling.h"

namespace pvol::detail {
namespace {

constexpr std::int64_t kLongest = 384;     // merged cells along the box's longest side
constexpr std::int64_t kMost = 1ll << 24;  // and in the box: 80 MB while distances are computed

/// Merged cells are those of the support's octree; the dense box of them that holds [lo, hi).
struct MergedBox {
  int log2 = 0;
  Vec3l lo;  ///< cell at the low corner
  Vec3i size;
};

MergedBox merged_box(const Support& support) {
  for (MergedBox box;; ++box.log2) {
    const std::int64_t edge = std::int64_t(1) << box.log2;
    Vec3l steps;
    for (int axis = 0; axis < 3; ++axis) {
      const std::int64_t first = (support.lo[axis] - support.origin[axis]) >> box.log2;
      box.lo[axis] = support.origin[axis] + first * edge;
      steps[axis] = (support.hi[axis] - box.lo[axis] + edge - 1) >> box.log2;
    }
    box.size = Vec3i(steps);
    if (max_component(steps) <= kLongest && steps.x * steps.y * steps.z <= kMost) return box;
  }
}

// A box of few merged cells also gives the middles of their edges and faces: a quadric small enough
// to fit into it rises visibly between vertices.
constexpr std::int32_t kFewSteps = 64;

constexpr std::size_t kInterior = 1 << 14;

enum Occupancy : std::uint8_t { kEmpty, kPartly, kFull };

/// The box of the cells occupied in one merged cell.
struct Occupied {
  Vec3l lo, hi;
};

void extend_by(Occupied& box, const Support& support, const SupportNode& node) {
  const Vec3l hi = node.lo + Vec3l(std::int64_t(1) << node.log2);
  const bool inside = box.lo.x <= node.lo.x && box.lo.y <= node.lo.y && box.lo.z <= node.lo.z &&
                      box.hi.x >= hi.x && box.hi.y >= hi.y && box.hi.z >= hi.z;
  if (inside) return;
  if (node.full) {
    box = {min(box.lo, node.lo), max(box.hi, hi)};
    return;
  }
  const SupportChildren halves = children(support, node);
  for (int i = 0; i < halves.count; ++i) extend_by(box, support, halves.node[std::size_t(i)]);
}

class Builder {
 public:
  explicit Builder(const Support& support)
      : support_(support), box_(merged_box(support)), frame_(frame(support.lo, support.hi)) {
    state_.assign(std::size_t(box_.size.x) * std::size_t(box_.size.y) * std::size_t(box_.size.z),
                  kEmpty);
  }

  SupportLattice build() {
    visit(root(support_));
    SupportLattice lattice;
    lattice.log2 = box_.log2;
    lattice.edge = double(std::int64_t(1) << box_.log2) / frame_.unit;
    lattice.volume = double(support_.cells) / std::pow(frame_.unit, 3);
    add_boundary(lattice);
    add_interior(lattice);
    add_empty(lattice);
    return lattice;
  }

 private:
  [[nodiscard]] std::size_t index(Vec3i c) const {
    return (std::size_t(c.z) * std::size_t(box_.size.y) + std::size_t(c.y)) *
               std::size_t(box_.size.x) +
           std::size_t(c.x);
  }
  [[nodiscard]] Vec3i merged(Vec3l cell) const {
    const Vec3l d = cell - box_.lo;
    return {std::int32_t(d.x >> box_.log2), std::int32_t(d.y >> box_.log2),
            std::int32_t(d.z >> box_.log2)};
  }
  [[nodiscard]] bool is_full(Vec3i c) const {
    if (c.x < 0 || c.y < 0 || c.z < 0) return false;
    if (c.x >= box_.size.x || c.y >= box_.size.y || c.z >= box_.size.z) return false;
    return state_[index(c)] == kFull;
  }

  void visit(const SupportNode& node) {
    const Vec3i c = merged(node.lo);
    if (node.full && node.log2 >= box_.log2) {
      const int n = 1 << (node.log2 - box_.log2);
      for (int z = 0; z < n; ++z) {
        for (int y = 0; y < n; ++y) {
          std::fill_n(state_.begin() + std::ptrdiff_t(index({c.x, c.y + y, c.z + z})), n, kFull);
        }
      }
    } else if (node.log2 == box_.log2) {
      state_[index(c)] = kPartly;
      Occupied box{node.lo + Vec3l(std::int64_t(1) << node.log2), node.lo};
      extend_by(box, support_, node);
      partly_.push_back(box);
    } else {
      const SupportChildren halves = children(support_, node);
      for (int i = 0; i < halves.count; ++i) visit(halves.node[std::size_t(i)]);
    }
  }

  void add_boundary(SupportLattice& lattice) const {
    // Points, in halves of a merged cell, between merged cells of which some but not all are full.
    const double half = 0.5 * double(std::int64_t(1) << box_.log2);
    const int step = max_component(box_.size) <= kFewSteps ? 1 : 2;
    const Vec3i last = box_.size * 2;
    Vec3i v;
    for (v.z = 0; v.z <= last.z; v.z += step) {
      for (v.y = 0; v.y <= last.y; v.y += step) {
        for (v.x = 0; v.x <= last.x; v.x += step) {
          int full = 0;
          for (int c = 0; c < 8; ++c) {
            full +=
                is_full({(v.x - (c & 1)) >> 1, (v.y - (c >> 1 & 1)) >> 1, (v.z - (c >> 2)) >> 1});
          }
          if (full == 0 || full == 8) continue;
          lattice.boundary.add(Vec3f(frame_.to_shell(Vec3d(box_.lo) + Vec3d(v) * half)));
        }
      }
    }
    for (const Occupied& box : partly_) {
      for (int corner = 0; corner < 8; ++corner) {
        const Vec3l p{(corner & 1 ? box.hi : box.lo).x, (corner & 2 ? box.hi : box.lo).y,
                      (corner & 4 ? box.hi : box.lo).z};
        lattice.boundary.add(Vec3f(frame_.to_shell(Vec3d(p))));
      }
    }
  }

  /// Some centres of full merged cells: a body may poke through the support's inside and touch its
  /// boundary nowhere.
  void add_interior(SupportLattice& lattice) const {
    const double edge = double(std::int64_t(1) << box_.log2);
    std::vector<std::size_t> full;
    for (std::size_t i = 0; i < state_.size(); ++i) {
      if (state_[i] == kFull) full.push_back(i);
    }
    for (const std::uint32_t k : spread(full.size(), kInterior, 0)) {
      const auto nx = std::size_t(box_.size.x), ny = std::size_t(box_.size.y);
      const Vec3<std::size_t> place(full[k] % nx, full[k] / nx % ny, full[k] / nx / ny);
      const Vec3d c(place);
      lattice.boundary.add(Vec3f(frame_.to_shell(Vec3d(box_.lo) + (c + Vec3d(0.5)) * edge)));
    }
  }

  void add_empty(SupportLattice& lattice) const {
    if (std::none_of(state_.begin(), state_.end(), [](auto s) { return s == kEmpty; })) return;
    const std::vector<float> squared = squared_distances(state_, box_.size);
    const double edge = double(std::int64_t(1) << box_.log2);
    const Box in_support_box{Vec3d(support_.lo), Vec3d(support_.hi)};
    for (Vec3i c; c.z < box_.size.z; ++c.z) {
      for (c.y = 0; c.y < box_.size.y; ++c.y) {
        for (c.x = 0; c.x < box_.size.x; ++c.x) {
          const std::size_t i = index(c);
          if (state_[i] != kEmpty) continue;
          const Vec3d centre = Vec3d(box_.lo) + (Vec3d(c) + Vec3d(0.5)) * edge;
          if (!in_support_box.contains(centre)) continue;
          lattice.empty.add(Vec3f(frame_.to_shell(centre)));
          lattice.gap.push_back(float(lattice.edge * double(std::sqrt(squared[i]))));
        }
      }
    }
  }

  const Support& support_;
  MergedBox box_;
  ShellFrame frame_;
  std::vector<std::uint8_t> state_;
  std::vector<Occupied> partly_;
};

}  // namespace

SupportLattice make_lattice(const Support& support) { return Builder(support).build(); }

}  // namespace pvol::detail
