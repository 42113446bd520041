// What the C API says of a committed volume.
#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <vector>

#include "capi/committed.h"
#include "capi/rays.h"
#include "pvol/bounds/leaf_index.h"
#include "pvol/embed.h"
#include "pvol/volume/value_field.h"
#include "volume/still_ranges.h"

namespace pvol::detail {
namespace {

template <class T>
[[nodiscard]] std::uint64_t bytes_of(const std::vector<T>& v) {
  return v.capacity() * sizeof(T);
}

[[nodiscard]] std::uint64_t bytes_of(const VolumeField& f) {
  return f.value_bytes() - f.shared_bytes() + f.octree.bytes() + f.squeeze_bytes() +
         (f.leaves ? f.leaves->bytes() : 0);
}

[[nodiscard]] std::uint64_t bytes_of(const Pyramid& p) {
  std::uint64_t sum = 0;
  for (const auto& level : p.levels) sum += bytes_of(level);
  return sum;
}

/// Bounds of mu_t over a box of the world that is not empty.
[[nodiscard]] DensityRange extinction_in(const Committed& c, const Box& world) {
  const VolumeField& f = c.volume->density;
  if (f.octree.empty()) return {0, 0};
  Box cells = transform(f.world_to_cells, world);
  // The map to cells is rounded, and look-ups clamp what lies on faces.
  const double slack = 1e-6 * (1 + std::max(max_component(cells.hi), -min_component(cells.lo)));
  cells.lo = cells.lo - Vec3d(slack), cells.hi = cells.hi + Vec3d(slack);
  const DensityRange r = StillRanges(c.bricks->pyramid, f).over(cells);
  constexpr float kLargest = std::numeric_limits<float>::max();
  return {std::nextafter(f.scale * r.lo, 0.0f), std::nextafter(f.scale * r.hi, kLargest)};
}

}  // namespace
}  // namespace pvol::detail

using namespace pvol;
using namespace pvol::detail;

extern "C" {

int pvol_box(const pvol_volume* volume, double lo[3], double hi[3]) {
  const Committed* const c = committed(volume);
  if (c == nullptr || c->volume->density.octree.empty() || !lo || !hi) return 0;
  const Box box = c->volume->density.world_box;
  for (int axis = 0; axis < 3; ++axis) lo[axis] = box.lo[axis], hi[axis] = box.hi[axis];
  return 1;
}

int pvol_extinction_range(const pvol_volume* volume, const double lo[3], const double hi[3],
                          float range[2]) {
  const Committed* const c = committed(volume);
  if (lo == nullptr || hi == nullptr || range == nullptr) return PVOL_BAD_RAY;
  const Box box{vec(lo), vec(hi)};
  const bool is_box = is_finite(box.lo) && is_finite(box.hi) && min(box.lo, box.hi) == box.lo;
  if (c == nullptr || !is_box) return PVOL_BAD_RAY;
  const DensityRange r = extinction_in(*c, box);
  range[0] = r.lo, range[1] = r.hi;
  return 1;
}

uint64_t pvol_bytes(const pvol_volume* volume) {
  const Committed* const c = committed(volume);
  if (c == nullptr) return 0;
  std::uint64_t sum = sizeof(pvol_volume) + sizeof(Committed) + bytes_of(c->volume->density);
  if (c->batch) sum += c->batch->bytes();
  const BoundedBricks& b = *c->bricks;
  sum += bytes_of(b.pyramid) + bytes_of(b.ranges) + bytes_of(b.spare) + bytes_of(b.changed);
  for (const auto& level : b.bricks.brick_of) sum += bytes_of(level);
  for (const auto& field : c->fields) sum += field ? bytes_of(*field) : 0;
  return sum;
}

float pvol_density(const pvol_volume* volume, const double place[3]) {
  const Committed* const c = committed(volume);
  return c == nullptr || place == nullptr ? 0 : density_at(*c->volume, vec(place));
}

float pvol_extinction(const pvol_volume* volume, const double place[3]) {
  const Committed* const c = committed(volume);
  return c == nullptr || place == nullptr ? 0 : extinction_at(*c->volume, vec(place));
}

float pvol_value(const pvol_volume* volume, int field, const double place[3]) {
  const Committed* const c = committed(volume);
  if (c == nullptr || place == nullptr || field < 0 || field >= PVOL_MOST_FIELDS) return 0;
  if (field == PVOL_DENSITY) return density_at(*c->volume, vec(place));
  const auto& f = c->fields[std::size_t(field)];
  return f == nullptr ? 0 : value_at(*f, vec(place));
}

int pvol_shell_spans(const pvol_volume* volume, const pvol_ray* ray, pvol_span* spans,
                     int capacity) try {
  if (ray == nullptr || (spans == nullptr && capacity > 0)) return PVOL_BAD_RAY;
  const Committed* const c = committed(volume);
  RayWalk walk;
  const auto entry = enter(c, *ray, walk);
  if (entry == Entry::bad) return PVOL_BAD_RAY;
  if (entry == Entry::misses) return 0;
  const Span box = walk.span();
  std::vector<Span> found{box};
  if (c->shell) {
    const Affine& to_cells = c->volume->density.world_to_cells;
    const Vec3d along = to_cells.vector(unit_of(vec(ray->d)));
    c->shell->intersect({to_cells.point(vec(ray->o)), along}, box.t0, box.t1, found);
  }
  for (std::size_t i = 0; i < found.size() && i < std::size_t(std::max(capacity, 0)); ++i) {
    spans[i] = {found[i].t0, found[i].t1};
  }
  return int(found.size());
} catch (const std::bad_alloc&) {
  return PVOL_BAD_RAY;
}

}  // extern "C"
