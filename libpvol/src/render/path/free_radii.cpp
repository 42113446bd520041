#include "render/path/free_radii.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "pvol/volume/facts.h"
#include "render/scene/boxes.h"
#include "volume/dense_bounds.h"

namespace pvol::detail {
namespace {

constexpr float kEndlessRadius = 0x1p100f;
// Of an instance's extinction, that of all thin ones around it: rays stop for them.
constexpr float kThin = 0.1f;
constexpr double kRim = 1e-3;  // of a box's extent: the rounding of places in cells is lost in it

Box world_box_of(const Volume& v, std::size_t place) {
  const Box box = world_box(v.density, v, place);
  const Vec3d rim = box.extent() * kRim;
  return {box.lo - rim, box.hi + rim};
}

/// The box around the middles of boxes.
Box around_middles(std::span<const Box> boxes) {
  Box middles;
  for (const Box& b : boxes) {
    if (!b.empty()) middles = extend(middles, b.centre());
  }
  return middles;
}

/// Of each of some boxes, which others it meets.
class Neighbours {
 public:
  explicit Neighbours(std::span<const Box> boxes) : of_(boxes.size()), crowded_(boxes.size()) {
    const int axis = longest_axis(around_middles(boxes));
    std::vector<std::uint32_t> order(boxes.size());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::sort(order, {}, [&](std::uint32_t i) { return boxes[i].lo[axis]; });
    const auto tested_each = std::max<std::size_t>(1000, kMostTests / (boxes.size() + 1));
    // Boxes that were compared with too many, and the first of the order that they were not.
    std::vector<std::pair<std::uint32_t, std::size_t>> wide;
    double crowded_to = -std::numeric_limits<double>::infinity();  // once these are too many
    for (std::size_t a = 0; a < order.size(); ++a) {
      const std::uint32_t i = order[a];
      if (boxes[i].lo[axis] <= crowded_to) crowded_[i] = 1;
      for (const auto& [other, rest] : wide) {
        if (a >= rest && meet(boxes[i], boxes[other])) add(i, other);
      }
      const auto reaches = [&](std::size_t b) {
        return b < order.size() && boxes[order[b]].lo[axis] <= boxes[i].hi[axis];
      };
      std::size_t b = a + 1;
      for (; reaches(b) && b - a <= tested_each && of_[i].size() <= kMost; ++b) {
        if (meet(boxes[i], boxes[order[b]])) add(i, order[b]), add(order[b], i);
      }
      if (!reaches(b)) continue;
      crowded_[i] = 1;
      if (wide.size() < kMost) {
        wide.emplace_back(i, b);
      } else {
        crowded_to = std::max(crowded_to, boxes[i].hi[axis]);
      }
    }
    for (std::size_t i = 0; i < boxes.size(); ++i) crowded_[i] |= of_[i].size() > kMost;
  }

  [[nodiscard]] std::span<const std::uint32_t> of(std::size_t box) const { return of_[box]; }
  /// Whether a box has too many to go through, or not all of them are known.
  [[nodiscard]] bool crowded(std::size_t box) const { return crowded_[box] != 0; }

 private:
  static constexpr std::size_t kMostTests = 400'000'000, kMost = 64;

  void add(std::uint32_t i, std::uint32_t other) {
    if (of_[i].size() <= kMost) of_[i].push_back(other);
  }

  std::vector<std::vector<std::uint32_t>> of_;
  std::vector<std::uint8_t> crowded_;
};

/// How many cells along its longest axis each of so many grids has; 0: they are too many.
int cells_along(std::size_t grids) {
  constexpr int kMost = 16, kLeast = 4;
  constexpr double kAll = 1 << 17;  // cells of all grids
  const int along = std::min(kMost, int(std::cbrt(kAll / double(std::max<std::size_t>(grids, 1)))));
  return along < kLeast ? 0 : along;
}

/// Lays a grid over a box of cells, with cubes of about one size in the world.
void lay_grid(const Box& cells, int along, FreeRadii::Grid& g) {
  Vec3d lengths;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3d edge;
    edge[axis] = cells.extent()[axis];
    lengths[axis] = length(g.to_world.vector(edge));
  }
  const double longest = max_component(lengths);
  for (int axis = 0; axis < 3; ++axis) {
    const int n = std::clamp(int(std::ceil(along * lengths[axis] / longest)), 1, along);
    g.size[axis] = n;
    g.scale[axis] = float(n / cells.extent()[axis]);
  }
  g.low = Vec3f(cells.lo + Vec3d(DenseBounds::kBorder));
}

/// Half of the longest diagonal of a grid's cells, in the world.
double half_diagonal(const FreeRadii::Grid& g) {
  double longest = 0;
  for (const Vec3d sides : {Vec3d(1, 1, 1), Vec3d(-1, 1, 1), Vec3d(1, -1, 1), Vec3d(1, 1, -1)}) {
    const Vec3d s = Vec3d(g.scale);
    const Vec3d diagonal(sides.x / s.x, sides.y / s.y, sides.z / s.z);
    longest = std::max(longest, length(g.to_world.vector(diagonal)));
  }
  return longest / 2;
}

/// Or more, per world length.
float largest_extinction(const Volume& v) {
  float largest = 0;
  for (const Octree::Entry& e : v.density.octree.entries) largest = std::max(largest, e.hi);
  return largest;
}

/// The radii of a grid's cells, in a box of the world with these others near it; 0 where they would
/// be below `least`. Empty where all are 0.
std::vector<float> radii_of(const FreeRadii::Grid& g, const Box& box, std::span<const Box> others,
                            const Surfaces* surfaces, double least) {
  const double farthest = length(box.extent());  // from one place in the box to another
  const double lost = half_diagonal(g) + kRim * farthest;
  const auto middle_of = [&](int cell, int axis) {
    return (cell + 0.5) / double(g.scale[axis]) + double(g.low[axis]);
  };
  std::vector<float> radii;
  float largest = 0;
  for (int x = 0; x < g.size.x; ++x) {
    for (int y = 0; y < g.size.y; ++y) {
      for (int z = 0; z < g.size.z; ++z) {
        const Vec3d middle(middle_of(x, 0), middle_of(y, 1), middle_of(z, 2));
        const Vec3d place = g.to_world.point(middle - Vec3d(DenseBounds::kBorder));
        double nearest = farthest;
        for (const Box& b : others) nearest = std::min(nearest, distance(b, place));
        if (surfaces != nullptr && nearest > lost) nearest = surfaces->distance(place, nearest);
        radii.push_back(nearest - lost < least ? 0.0f : float(nearest - lost));
        largest = std::max(largest, radii.back());
      }
    }
  }
  if (!(largest > 0)) radii.clear();
  return radii;
}

}  // namespace

float FreeRadii::at(std::uint32_t instance, Vec3f place) const {
  if (!known(instance)) return 0;
  const Grid& g = grids_[instance];
  const auto along = [&](int axis) {
    const int cell = int((place[axis] - g.low[axis]) * g.scale[axis]);
    return std::size_t(std::clamp(cell, 0, g.size[axis] - 1));
  };
  const std::size_t cell =
      (along(0) * std::size_t(g.size.y) + along(1)) * std::size_t(g.size.z) + along(2);
  return radii(g)[cell];
}

const FreeRadii::Thin& FreeRadii::draw_thin(const Grid& grid, float u) const {
  std::uint32_t chosen = 0;
  float left = u * grid.majorant - thin_[grid.first_thin].majorant;
  while (left >= 0 && chosen + 1 < grid.thin_ones) {
    left -= thin_[grid.first_thin + ++chosen].majorant;
  }
  return thin_[grid.first_thin + chosen];
}

FreeRadii::FreeRadii(std::span<const VolumeSetup> volumes, const Instances& instances,
                     const Surfaces* surfaces, bool may_be_thin) {
  std::vector<Box> boxes;
  for (const Instance& i : instances.all) {
    boxes.push_back(world_box_of(volumes[i.volume].volume, i.place));
  }
  std::vector<float> extinctions;  // by volume
  for (const VolumeSetup& v : volumes) extinctions.push_back(largest_extinction(v.volume));
  const auto extinction_of = [&](std::uint32_t i) { return extinctions[instances.all[i].volume]; };
  const auto moves = [&](std::uint32_t i) {
    return instances.moves() && instances.motion[i].place != nullptr;
  };
  const Neighbours neighbours(boxes);
  std::vector<std::uint32_t> reached;  // by something that is not thin
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    grids_.push_back({.to_world = inverse(instances.all[i].world_to_cells)});
    const bool in_lanes = !volumes[instances.all[i].volume].one_by_one;
    if (moves(i) || !in_lanes || boxes[i].empty() || neighbours.crowded(i)) continue;
    Grid& g = grids_[i];
    g.first_thin = std::uint32_t(thin_.size());
    for (const std::uint32_t other : neighbours.of(i)) {
      const float majorant = extinction_of(other);
      if (!may_be_thin || moves(other)) continue;
      if (!(g.majorant + majorant < kThin * extinction_of(i))) continue;
      thin_.push_back({other, majorant});
      ++g.thin_ones, g.majorant += majorant;
    }
    if (g.thin_ones < neighbours.of(i).size() ||
        (surfaces != nullptr && surfaces->may_reach(boxes[i]))) {
      reached.push_back(i);
    } else {
      g.size = Vec3i(1), g.first = std::uint32_t(radii_.size());
      radii_.push_back(kEndlessRadius);
    }
  }
  const int along = cells_along(reached.size());
  if (along == 0) reached.clear();
  for (const std::uint32_t i : reached) {
    Grid grid = grids_[i];
    const std::span<const Thin> thin(thin_.data() + grid.first_thin, grid.thin_ones);
    std::vector<Box> others;
    for (const std::uint32_t other : neighbours.of(i)) {
      if (std::ranges::find(thin, other, &Thin::instance) == thin.end()) {
        others.push_back(boxes[other]);
      }
    }
    lay_grid(volumes[instances.all[i].volume].volume.density.octree.support(), along, grid);
    // Of rays that go less far most would end in the world all the same.
    const double least = 1 / double(extinction_of(i));
    const std::vector<float> radii = radii_of(grid, boxes[i], others, surfaces, least);
    if (radii.empty()) continue;
    grids_[i] = grid;
    grids_[i].first = std::uint32_t(radii_.size());
    radii_.insert(radii_.end(), radii.begin(), radii.end());
  }
  if (radii_.empty()) *this = {};
}

}  // namespace pvol::detail
