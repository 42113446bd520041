// From what C programs have in memory to grids.
#include "capi/samples.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <string>

#include "capi/guard.h"
#include "density/array_rows.h"
#include "density/check_grid.h"
#include "pvol/density/quantise.h"
#include "pvol/error.h"

namespace pvol::detail {
namespace {

[[nodiscard]] Vec3i vec(const std::int32_t v[3]) { return {v[0], v[1], v[2]}; }

[[nodiscard]] std::string text(Vec3i v) {
  return "(" + std::to_string(v.x) + ", " + std::to_string(v.y) + ", " + std::to_string(v.z) + ")";
}

[[nodiscard]] std::int64_t size_of(pvol_type type) {
  switch (type) {
    case PVOL_FLOAT:
      return 4;
    case PVOL_DOUBLE:
      return 8;
    case PVOL_HALF:
      return 2;
  }
  throw Error("there is no type of samples " + std::to_string(int(type)) +
              "; expected PVOL_FLOAT, PVOL_DOUBLE or PVOL_HALF");
}

/// In bytes.
[[nodiscard]] Vec3l stride_of(const pvol_array& a) {
  const Vec3l given(a.stride[0], a.stride[1], a.stride[2]);
  if (given != Vec3l(0)) return given;
  return Vec3l(std::int64_t(a.size[1]) * a.size[2], a.size[2], 1) * size_of(a.type);
}

/// A half of any value, also those that are no density.
[[nodiscard]] float from_half(std::uint16_t bits) {
  const bool finite = (bits & 0x7c00) != 0x7c00;
  if (!finite) return std::nanf("");
  const float size = decode_half(bits & 0x7fff, 0);
  return bits & 0x8000 ? -size : size;
}

[[nodiscard]] float load(const char* at, pvol_type type) {
  if (type == PVOL_DOUBLE) {
    double v;
    std::memcpy(&v, at, sizeof v);
    return float(v);
  }
  if (type == PVOL_HALF) {
    std::uint16_t v;
    std::memcpy(&v, at, sizeof v);
    return from_half(v);
  }
  float v;
  std::memcpy(&v, at, sizeof v);
  return v;
}

/// Tells how much of a box bricks have been read of, as they are: in the order of their z, but from
/// several threads at once.
class ReadProgress {
 public:
  ReadProgress(const LatticeBox& box, const Progress& progress)
      : first_z_(box.lo.z & -kBrickEdge), progress_(progress) {
    const Vec3l bricks = count_bricks(box.lo, box.hi);
    runs_ = double(bricks.x) * double(bricks.y) *
            double(((box.hi.z - 1) & -kRun) - (box.lo.z & -kRun) + kRun) / kRun;
    step_ = std::uint64_t(std::clamp(runs_ / 64, 1.0, 2048.0));
  }

  /// Before a brick is read.
  void begin(Vec3i origin) {
    if ((origin.z & (kRun - 1)) != 0 && origin.z != first_z_) return;
    if ((begun_.fetch_add(1, std::memory_order_relaxed) + 1) % step_ != 0) return;
    if (telling_.exchange(true, std::memory_order_acquire)) return;  // then another thread does
    progress_(std::min(double(begun_.load(std::memory_order_relaxed)) / runs_, 1.0));
    telling_.store(false, std::memory_order_release);
  }

 private:
  /// Lattice points along z whose bricks are counted at once.
  static constexpr std::int64_t kRun = 128;

  std::int64_t first_z_;
  const Progress& progress_;
  double runs_ = 0;         ///< in the box
  std::uint64_t step_ = 1;  ///< runs from one call to the next
  std::atomic<std::uint64_t> begun_ = 0;
  std::atomic<bool> telling_ = false;  ///< for good, where the work is to end
};

/// The lattice points lo <= p < hi by `fill`, brick by brick.
[[nodiscard]] VoxelGrid read_bricks(Vec3i lo, Vec3i hi, const Progress& progress,
                                    const FillBrick& fill) {
  ReadProgress read({Vec3l(lo), Vec3l(hi)}, progress);
  return make_grid(lo, hi, [&](Vec3i origin, float* values) {
    read.begin(origin);
    fill(origin, values);
  });
}

}  // namespace

void require_samples(const pvol_array& a) {
  require_not_null(a.values, "the address of the array of samples");
}

void require_samples(const pvol_bricks& b) {
  if (b.fill == nullptr) throw Error("the function that fills bricks is null");
}

void require_samples(const pvol_leaves& l) {
  if (l.leaf_count > 0) require_not_null(l.leaves, "the address of the array of leaves");
  if (l.tile_count > 0) require_not_null(l.tiles, "the address of the array of tiles");
}

VoxelGrid read_samples(const pvol_array& a, const LatticeBox& box, const Progress& progress) {
  const Vec3i size = vec(a.size), begin = vec(a.origin);
  const Vec3l stride = stride_of(a);
  const Vec3l end = Vec3l(begin) + Vec3l(size);
  if (min_component(size) < 1 || max_component(end) > std::numeric_limits<std::int32_t>::max()) {
    throw Error("an array of " + text(size) + " samples at " + text(begin) +
                "; expected at least one along each axis, and an end below 2^31");
  }
  const Vec3l from = max(Vec3l(begin), box.lo), to_end = min(end, box.hi);
  if (min_component(to_end - from) < 1) return {};
  const auto* const values = static_cast<const char*>(a.values);
  const auto copy = [&](Vec3l at, float* to, std::int64_t count) {
    const char* const source = values + dot(at - Vec3l(begin), stride);
    for (std::int64_t k = 0; k < count; ++k) to[k] = load(source + k * stride.z, a.type);
  };
  const FillBrick fill = fill_by_rows(from, to_end, copy);
  require_grid_memory(from, to_end, fill);
  return read_bricks(Vec3i(from), Vec3i(to_end), progress, fill);
}

VoxelGrid read_samples(const pvol_bricks& b, const LatticeBox& box, const Progress& progress) {
  const Vec3l lo = max(Vec3l(vec(b.lo)), box.lo), hi = min(Vec3l(vec(b.hi)), box.hi);
  const bool is_box = min_component(Vec3l(vec(b.hi)) - Vec3l(vec(b.lo))) > 0;
  if (is_box && min_component(hi - lo) < 1) return {};
  return read_bricks(is_box ? Vec3i(lo) : vec(b.lo), is_box ? Vec3i(hi) : vec(b.hi), progress,
                     [&](Vec3i origin, float* values) {
                       const std::int32_t at[3] = {origin.x, origin.y, origin.z};
                       if (b.fill(b.user, at, values) != 0) throw Cancelled{};
                     });
}

VoxelGrid read_samples(const pvol_leaves& l, const LatticeBox& box, const Progress&) {
  VoxelGrid grid;
  for (std::size_t i = 0; i < l.leaf_count; ++i) {
    const Vec3i origin = vec(l.leaves[i].origin);
    const Vec3l lo(origin), hi = lo + Vec3l(kBrickEdge);
    if (min_component(min(hi, box.hi) - max(lo, box.lo)) < 1) continue;
    grid.bricks.push_back({origin, l.leaves[i].values});
  }
  for (std::size_t i = 0; i < l.tile_count; ++i) {
    grid.tiles.push_back({vec(l.tiles[i].origin), l.tiles[i].edge, l.tiles[i].value});
  }
  check_cubes(grid);
  grid = occupied(grid);
  check_disjoint(grid);
  return grid;
}

DenseArray shared_array(const pvol_array& a) {
  if (a.type != PVOL_FLOAT) {
    throw Error("only arrays of floats (PVOL_FLOAT) can be shared; set this one, which copies it");
  }
  const Vec3l stride = stride_of(a);
  const auto bits = std::uint64_t(stride.x | stride.y | stride.z) |
                    std::uint64_t(reinterpret_cast<std::uintptr_t>(a.values));
  if (bits % sizeof(float) != 0) {
    throw Error(
        "only arrays whose address and strides are multiples of 4 bytes can be shared; set this "
        "one, which copies it");
  }
  constexpr std::int64_t kBytes = sizeof(float);
  return {static_cast<const float*>(a.values), vec(a.size), vec(a.origin),
          Vec3l(stride.x / kBytes, stride.y / kBytes, stride.z / kBytes)};
}

}  // namespace pvol::detail
