#include "capi/brick_update.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#include "bounds/pyramid_parts.h"
#include "density/lattice_index.h"
#include "density/sample_range.h"
#include "field/gather.h"
#include "pvol/math/parallel.h"

namespace pvol::detail {
namespace {

/// A leaf by its low corner, a multiple of 8.
struct LeafBrick {
  Vec3l at;
  std::uint32_t brick;
};

[[nodiscard]] DensityRange range_of(const float* samples) {
  const SampleRange range(samples, kFieldSamples);
  return {range.lo(), range.hi()};
}

[[nodiscard]] std::vector<DensityRange> ranges_of(const BrickField& field) {
  std::vector<DensityRange> ranges(field.bricks());
  parallel_parts(0, ranges.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b != end; ++b) ranges[b] = range_of(field.brick(std::uint32_t(b)));
  });
  return ranges;
}

/// The leaf that a cell is in.
[[nodiscard]] Vec3l leaf_of(Vec3l cell) {
  return {cell.x & ~std::int64_t(7), cell.y & ~std::int64_t(7), cell.z & ~std::int64_t(7)};
}

/// Low corners of the first and the last leaf that read samples of a box: leaves read 9 along each
/// axis.
[[nodiscard]] LatticeBox leaves_of(const LatticeBox& box) {
  return {leaf_of(box.lo - Vec3l(1)), leaf_of(box.hi - Vec3l(1))};
}

[[nodiscard]] bool holds(const LatticeBox& leaves, Vec3l at) {
  return min(leaves.lo, at) == leaves.lo && max(leaves.hi, at) == leaves.hi;
}

/// One update.
class Update {
 public:
  explicit Update(const BoundedBricks& before) : before_(before) {
    out_.ranges = before.ranges.empty() ? ranges_of(copies_of(before.bricks)) : before.ranges;
    out_.spare = before.spare;
    // Those that a cancelled update left behind.
    for (std::size_t b = out_.ranges.size(); b < copies_of(before.bricks).bricks(); ++b) {
      out_.spare.push_back(std::uint32_t(b));
    }
    out_.ranges.resize(copies_of(before.bricks).bricks());
    if (before.pyramid.empty()) return;
    const std::vector<PyramidNode>& nodes = before.pyramid.levels[0];
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const Vec3l at = before.pyramid.origin + Vec3l(morton_decode(nodes[i].code)) * kLeafEdge;
      leaves_.push_back({at, before.bricks.brick_of[0][i]});
    }
  }

  BoundedBricks run(std::span<const LatticeBox> boxes, const ReadBox& read) {
    find_changed(boxes);
    Batch batch{read};
    for (const LatticeBox& box : boxes) batch.add(box);
    take_room(batch.made.size());
    for (std::size_t i = 0; i < batch.made.size(); ++i) {
      const std::uint32_t brick = out_.changed[i];
      std::memcpy(field_->samples.data() + std::size_t(brick) * kFieldSamples,
                  batch.samples.data() + i * kFieldSamples, kFieldSamples * sizeof(float));
      out_.ranges[brick] = range_of(batch.samples.data() + i * kFieldSamples);
      leaves_.push_back({batch.made[i], brick});
    }
    // Bounds of files may be loose: leaves without density are not among those that are made.
    std::erase_if(leaves_, [&](const LeafBrick& l) { return out_.ranges[l.brick].hi == 0; });
    // What the old leaves had is free once nobody sees what was before.
    out_.spare.insert(out_.spare.end(), freed_.begin(), freed_.end());
    bound();
    return std::move(out_);
  }

 private:
  const BoundedBricks& before_;
  BoundedBricks out_;
  std::vector<LeafBrick> leaves_;
  std::vector<std::uint32_t> freed_;
  std::shared_ptr<BrickField> field_;

  /// Leaves to come, box by box: none twice.
  struct Batch {
    const ReadBox& read;
    std::vector<LatticeBox> done{};
    std::vector<Vec3l> made{};
    std::vector<float> samples{};

    void add(const LatticeBox& box) {
      const LatticeBox leaves = leaves_of(box);
      const VoxelGrid grid = read({leaves.lo, leaves.hi + Vec3l(2 * kLeafEdge)});
      const BlockFinder blocks(grid);
      std::array<float, kFieldSamples> own;
      // Each leaf that reads a block of the grid; all others would hold nothing.
      std::vector<Vec3l> candidates;
      for (const Brick& b : grid.bricks) {
        for (int k = 0; k < 8; ++k) {
          const Vec3l at = Vec3l(b.origin) - Vec3l(k >> 2, k >> 1 & 1, k & 1) * kLeafEdge;
          const auto was_done = [&](const LatticeBox& d) { return holds(d, at); };
          if (holds(leaves, at) && std::none_of(done.begin(), done.end(), was_done)) {
            candidates.push_back(at);
          }
        }
      }
      const auto before = [](Vec3l a, Vec3l b) {
        return std::array{a.x, a.y, a.z} < std::array{b.x, b.y, b.z};
      };
      std::sort(candidates.begin(), candidates.end(), before);
      candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
      for (const Vec3l at : candidates) {
        gather(blocks, Vec3i(at), LookUp::trilinear, own.data());
        if (std::all_of(own.begin(), own.end(), [](float v) { return v == 0; })) continue;
        made.push_back(at);
        samples.insert(samples.end(), own.begin(), own.end());
      }
      done.push_back(leaves);
    }
  };

  /// Takes the leaves that read a box out of the list; those whose brick no other leaf has become
  /// free.
  void find_changed(std::span<const LatticeBox> boxes) {
    std::vector<std::uint32_t> uses(out_.ranges.size());
    for (const LeafBrick& l : leaves_) ++uses[l.brick];
    std::erase_if(leaves_, [&](const LeafBrick& l) {
      const auto reads = [&](const LatticeBox& box) { return holds(leaves_of(box), l.at); };
      if (std::none_of(boxes.begin(), boxes.end(), reads)) return false;
      if (l.brick != kZeroBrick && --uses[l.brick] == 0) freed_.push_back(l.brick);
      return true;
    });
  }

  /// Bricks to write: spare ones, then new ones behind the others, in a larger field where these
  /// find no room in this.
  void take_room(std::size_t count) {
    const auto& old = std::get<std::shared_ptr<const BrickField>>(before_.bricks.values);
    const std::size_t reused = std::min(count, out_.spare.size()), bricks = old->bricks();
    out_.changed.assign(out_.spare.end() - std::ptrdiff_t(reused), out_.spare.end());
    out_.spare.resize(out_.spare.size() - reused);
    for (std::size_t i = reused; i < count; ++i) {
      out_.changed.push_back(std::uint32_t(bricks + i - reused));
    }
    const std::size_t samples = (bricks + count - reused) * std::size_t(kFieldSamples);
    if (samples <= old->samples.capacity()) {
      // Nobody else writes, and nobody reads what is written.
      field_ = std::const_pointer_cast<BrickField>(old);
    } else {
      field_ = std::make_shared<BrickField>();
      field_->look_up = old->look_up;
      field_->samples.reserve(samples + samples / 8);
      field_->samples = old->samples;
    }
    field_->samples.resize(samples);
    out_.ranges.resize(field_->bricks());
    out_.bricks.values = field_;
  }

  /// Extremes of the lattice points with a sample above 0 along an axis. Samples beyond a leaf's
  /// own are the first of another one, which is there then.
  void add_points(const LeafBrick& leaf, LatticeBox& box) const {
    const float* const s = field_->brick(leaf.brick);
    for (int i = 0; i < kFieldEdge; ++i) {
      for (int j = 0; j < kFieldEdge; ++j) {
        for (int k = 0; k < kFieldEdge; ++k) {
          if (s[(i * kFieldEdge + j) * kFieldEdge + k] == 0) continue;
          const Vec3l at = leaf.at + Vec3l(i, j, k);
          box.lo = min(box.lo, at), box.hi = max(box.hi, at);
        }
      }
    }
  }

  /// The pyramid of all leaves, from the ranges of their bricks.
  void bound() {
    float largest = 0;
    constexpr std::int64_t kFar = std::numeric_limits<std::int64_t>::max();
    LatticeBox leaves{Vec3l(kFar), Vec3l(-kFar)};
    for (const LeafBrick& l : leaves_) {
      largest = std::max(largest, out_.ranges[l.brick].hi);
      leaves.lo = min(leaves.lo, l.at), leaves.hi = max(leaves.hi, l.at);
    }
    out_.bricks.brick_of = {{}};
    if (leaves_.empty()) {
      out_.bricks.brick_of.clear();
      return;
    }
    // Leaves below the first samples and above the last ones have them in what they read of others.
    LatticeBox points{Vec3l(kFar), Vec3l(-kFar)};
    const Vec3l one(kLeafEdge);
    for (const LeafBrick& l : leaves_) {
      const bool inner =
          min_component(l.at - leaves.lo - one) > 0 && min_component(leaves.hi - one - l.at) > 0;
      if (!inner) add_points(l, points);
    }
    Pyramid& p = out_.pyramid;
    place_root(p, points.lo, points.hi, largest);

    struct Coded {
      std::uint64_t code;
      std::uint32_t brick;
    };
    std::vector<Coded> coded(leaves_.size());
    parallel_parts(0, coded.size(), 1024, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i != end; ++i) {
        const Vec3l from = leaves_[i].at - p.origin;
        const Vec3<std::uint32_t> c(
            Vec3l(from.x / kLeafEdge, from.y / kLeafEdge, from.z / kLeafEdge));
        coded[i] = {morton_encode(c), leaves_[i].brick};
      }
    });
    std::sort(coded.begin(), coded.end(),
              [](const Coded& a, const Coded& b) { return a.code < b.code; });
    p.levels[0].resize(coded.size());
    out_.bricks.brick_of[0].resize(coded.size());
    parallel_parts(0, coded.size(), 256, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i != end; ++i) {
        const DensityRange r = out_.ranges[coded[i].brick];
        p.levels[0][i] = quantize({coded[i].code, r.lo, r.hi}, p.scale);
        out_.bricks.brick_of[0][i] = coded[i].brick;
      }
    });
    complete_levels(p);
    out_.bricks.brick_of.resize(p.levels.size());
    for (std::size_t level = 1; level < p.levels.size(); ++level) {
      out_.bricks.brick_of[level].resize(p.levels[level].size(), kZeroBrick);
    }
  }
};

}  // namespace

bool can_update(const BoundedBricks& before) {
  const Pyramid& p = before.pyramid;
  const auto* const copies = std::get_if<std::shared_ptr<const BrickField>>(&before.bricks.values);
  if (p.look_up != LookUp::trilinear || copies == nullptr ||
      (*copies)->look_up != LookUp::trilinear) {
    return false;
  }
  for (std::size_t level = 1; level < p.levels.size(); ++level) {
    for (std::size_t i = 0; i < p.levels[level].size(); ++i) {
      if (is_uniform(p, level, i)) return false;
    }
  }
  return true;
}

BoundedBricks update_bricks(const BoundedBricks& before, std::span<const LatticeBox> boxes,
                            const ReadBox& read) {
  return Update(before).run(boxes, read);
}

}  // namespace pvol::detail
