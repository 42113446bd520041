#include "render/light/emission/power_boxes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <queue>

#include "bounds/octree_children.h"
#include "pvol/bounds/pyramid.h"
#include "pvol/math/parallel.h"
#include "pvol/volume/extinction_source.h"

namespace pvol::detail {

/// A leaf, or a uniform cube, of the octree.
struct LitCube {
  Vec3i lo;
  int edge = 0;
  float most = 0;          ///< a bound on the field
  float power = 0;         ///< in cells
  std::uint64_t code = 0;  ///< Morton's, by which cubes are in order
};

namespace {

/// Luminance emitted per world unit in a cube, by a few points of it.
template <class Value>
float mean_luminance(const EmissionSource& source, const Value& value, const Affine& to_world,
                     const LitCube& cube) {
  constexpr int kAlong = 4;  // each edge
  const Segment anywhere{.t0 = 0, .t1 = 0, .lo = 0, .hi = 0, .leaf = Octree::kNodeBit};
  const double step = double(cube.edge) / kAlong;
  float sum = 0;
  for (int i = 0; i < kAlong * kAlong * kAlong; ++i) {
    const Vec3i at(i / (kAlong * kAlong), i / kAlong % kAlong, i % kAlong);
    const Vec3d cells = Vec3d(cube.lo) + (Vec3d(at) + Vec3d(0.5)) * step;
    const LatticePoint p = lattice_point(source.field->octree, cells);
    sum += luminance(source.at(value, anywhere, p, to_world.point(cells)));
  }
  return sum / (kAlong * kAlong * kAlong);
}

/// What a cube may emit by its bounds.
float bound_of(const EmissionSource& source, const LitCube& cube) {
  const Rgb of_bound = source.fire != nullptr
                           ? source.fire->fire.color * float(source.fire->fire.intensity)
                           : source.of_depth;
  return cube.most * luminance(of_bound);
}

/// Those that shine, in the order of their codes.
std::vector<LitCube> find_cubes(const EmissionSource& source) {
  const VolumeField& f = *source.field;
  std::vector<LitCube> cubes;
  for_leaves(f.octree, f.octree.nodes[0], Vec3i(0),
             [&](Vec3i low, int edge, const Octree::Entry& e) {
               cubes.push_back({.lo = low, .edge = edge, .most = e.hi});
             });
  // Points may miss what is small: a little of the power is that of the bounds.
  constexpr float kMissed = 1e-4f;
  const Affine to_world = inverse(f.world_to_cells);
  visit_source(f, [&](const auto& value) {
    parallel_for(0, cubes.size(), [&](std::size_t i) {
      LitCube& cube = cubes[i];
      const auto edge = float(cube.edge);
      cube.power =
          (mean_luminance(source, value, to_world, cube) + kMissed * bound_of(source, cube)) *
          edge * edge * edge;
      cube.code = morton_encode(Vec3<std::uint32_t>(cube.lo));
    });
  });
  std::erase_if(cubes, [](const LitCube& cube) { return !(cube.power > 0); });
  std::ranges::sort(cubes, {}, &LitCube::code);
  return cubes;
}

/// Neighbouring cubes in one box.
struct CubeGroup {
  std::span<const LitCube> cubes;
  Box box{};
  float power = 0;

  explicit CubeGroup(std::span<const LitCube> its) : cubes(its) {
    for (const LitCube& cube : its) {
      box = extend(extend(box, Vec3d(cube.lo)), Vec3d(cube.lo + Vec3i(cube.edge)));
      power += cube.power;
    }
  }
  /// What it may lose by being one box: all its power, seen in a wrong direction by up to its size.
  [[nodiscard]] double loss() const {
    return cubes.size() > 1 ? double(power) * length(box.hi - box.lo) : 0;
  }
  friend bool operator<(const CubeGroup& a, const CubeGroup& b) {
    return a.loss() != b.loss() ? a.loss() < b.loss() : a.cubes.data() < b.cubes.data();
  }
};

/// Where the highest bit in which its codes differ changes: the group's halves are those of a cube.
std::size_t middle_of(std::span<const LitCube> cubes) {
  const std::uint64_t differ = cubes.front().code ^ cubes.back().code;
  const std::uint64_t bit = std::bit_floor(differ);
  const auto upper =
      std::ranges::partition_point(cubes, [&](const LitCube& l) { return (l.code & bit) == 0; });
  return std::size_t(upper - cubes.begin());
}

}  // namespace

PowerBoxes::PowerBoxes(const EmissionSource& source) { fill(find_cubes(source)); }

void PowerBoxes::fill(std::span<const LitCube> cubes) {
  if (cubes.empty()) return;
  std::priority_queue<CubeGroup> groups;
  groups.emplace(cubes);
  bounds_ = groups.top().box;
  while (groups.size() < kMost && groups.top().loss() > 0) {
    const std::span<const LitCube> all = groups.top().cubes;
    groups.pop();
    const std::size_t middle = middle_of(all);
    groups.emplace(all.first(middle));
    groups.emplace(all.subspan(middle));
  }
  const Vec3d middle = bounds_.centre();
  for (; !groups.empty(); groups.pop()) {
    const CubeGroup& g = groups.top();
    boxes_.add(Vec3f(g.box.lo - middle), Vec3f(g.box.hi - middle), g.power);
    power_ += double(g.power);
  }
  boxes_.fill_register();
}

/// A point evenly in a box that is chosen by these weights.
Vec3d PowerBoxes::point_in(std::span<const float> weights, Rng& rng) const {
  constexpr std::size_t kBlock = SeenBoxes::kRegister;
  std::array<float, kMost / kBlock> of_block{};
  float sum = 0;
  for (std::size_t b = 0; b < weights.size() / kBlock; ++b) {
    for (std::size_t i = 0; i < kBlock; ++i) of_block[b] += weights[b * kBlock + i];
    sum += of_block[b];
  }
  float left = rng.uniform() * sum;
  std::size_t block = 0;
  while ((block + 1) * kBlock < weights.size() && !(left < of_block[block]))
    left -= of_block[block++];
  std::size_t i = block * kBlock;
  for (const std::size_t last = i + kBlock - 1; i < last && !(left < weights[i]); ++i)
    left -= weights[i];
  while (i > 0 && !(weights[i] > 0)) --i;  // rounding led beyond the last that has power
  const auto [x, y, z, spare] = rng.uniform4();
  const Vec3f lo(boxes_.lo[0][i], boxes_.lo[1][i], boxes_.lo[2][i]),
      hi(boxes_.hi[0][i], boxes_.hi[1][i], boxes_.hi[2][i]);
  return bounds_.centre() + Vec3d(lo + (hi - lo) * Vec3f(x, y, z));
}

Vec3d PowerBoxes::sample(Vec3d place, Rng& rng) const {
  std::array<float, kMost> weights;
  box_kernel().find_weights(boxes_, Vec3f(place - bounds_.centre()), weights.data());
  return point_in(std::span(weights.data(), boxes_.size()), rng);
}

Vec3d PowerBoxes::sample(Rng& rng) const { return point_in(boxes_.power, rng); }

double PowerBoxes::pdf(const Ray& cells, double cell_volume) const {
  if (!intersect(bounds_, cells, 0, std::numeric_limits<double>::infinity())) return 0;
  const double scale = length(cells.d);
  const Vec3d from = cells.o - bounds_.centre(), direction = cells.d / scale;
  // Lengths near the boxes keep their digits, wherever the ray begins.
  const double before = std::max(-dot(from, direction), 0.0);
  const BoxLine line{Vec3f(from + direction * before), Vec3f(direction), float(before)};
  const BoxDensities found = box_kernel().find_densities(boxes_, Vec3f(from), line);
  if (!(found.weights > 0)) return 0;  // so far away that floats do not hold it
  return double(found.along_line) / double(found.weights) / (scale * scale * scale * cell_volume);
}

}  // namespace pvol::detail
