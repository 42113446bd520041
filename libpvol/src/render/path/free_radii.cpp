#include "render/path/free_radii.h"

#include <algorithm>
#include <cmath>

#include "pvol/volume/facts.h"
#include "render/scene/box_neighbours.h"
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

std::vector<Box> boxes_of(std::span<const VolumeSetup> volumes, const Instances& instances) {
  std::vector<Box> boxes;
  for (const Instance& i : instances.all) {
    boxes.push_back(world_box_of(volumes[i.volume].volume, i.place));
  }
  return boxes;
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

/// The instances of a scene, and what is around each of them.
struct FreeRadii::Around {
  std::span<const VolumeSetup> volumes;
  const Instances& instances;
  const Surfaces* surfaces;
  std::vector<Box> boxes;
  BoxNeighbours neighbours;
  std::vector<float> extinctions;  ///< the largest, or more, by volume

  Around(std::span<const VolumeSetup> volumes_, const Instances& instances_,
         const Surfaces* surfaces_)
      : volumes(volumes_),
        instances(instances_),
        surfaces(surfaces_),
        boxes(boxes_of(volumes, instances)),
        neighbours(boxes) {
    for (const VolumeSetup& v : volumes) extinctions.push_back(largest_extinction(v.volume));
  }

  [[nodiscard]] const VolumeSetup& volume(std::uint32_t i) const {
    return volumes[instances.all[i].volume];
  }
  [[nodiscard]] float extinction(std::uint32_t i) const {
    return extinctions[instances.all[i].volume];
  }
  [[nodiscard]] bool moves(std::uint32_t i) const {
    return instances.moves() && instances.motion[i].place != nullptr;
  }
  /// Whether an instance may have radii.
  [[nodiscard]] bool is_served(std::uint32_t i) const {
    return !moves(i) && !volume(i).one_by_one && !boxes[i].empty() && !neighbours.crowded(i);
  }
  [[nodiscard]] bool has_surface_near(std::uint32_t i) const {
    return surfaces != nullptr && surfaces->may_reach(boxes[i]);
  }
};

void FreeRadii::find_thin(const Around& around, std::uint32_t instance) {
  Grid& g = grids_[instance];
  g.first_thin = std::uint32_t(thin_.size());
  const float most = kThin * around.extinction(instance);
  for (const std::uint32_t other : around.neighbours.of(instance)) {
    const float majorant = around.extinction(other);
    if (around.moves(other) || !(g.majorant + majorant < most)) continue;
    thin_.push_back({other, majorant});
    ++g.thin_ones, g.majorant += majorant;
  }
}

void FreeRadii::find_radii(const Around& around, std::uint32_t instance, int along) {
  Grid grid = grids_[instance];
  const std::span<const Thin> thin(thin_.data() + grid.first_thin, grid.thin_ones);
  std::vector<Box> others;
  for (const std::uint32_t other : around.neighbours.of(instance)) {
    if (std::ranges::find(thin, other, &Thin::instance) == thin.end()) {
      others.push_back(around.boxes[other]);
    }
  }
  lay_grid(around.volume(instance).volume.density.octree.support(), along, grid);
  // Of rays that go less far most would end in the world all the same.
  const double least = 1 / double(around.extinction(instance));
  const std::vector<float> radii =
      radii_of(grid, around.boxes[instance], others, around.surfaces, least);
  if (radii.empty()) return;
  grid.first = std::uint32_t(radii_.size());
  radii_.insert(radii_.end(), radii.begin(), radii.end());
  grids_[instance] = grid;
}

FreeRadii::FreeRadii(std::span<const VolumeSetup> volumes, const Instances& instances,
                     const Surfaces* surfaces, bool may_be_thin) {
  const Around around(volumes, instances, surfaces);
  std::vector<std::uint32_t> reached;  // by something that is not thin
  for (std::uint32_t i = 0; i < instances.all.size(); ++i) {
    Grid& g = grids_.emplace_back(Grid{.to_world = inverse(instances.all[i].world_to_cells)});
    if (!around.is_served(i)) continue;
    if (may_be_thin) find_thin(around, i);
    if (g.thin_ones < around.neighbours.of(i).size() || around.has_surface_near(i)) {
      reached.push_back(i);
    } else {
      g.size = Vec3i(1), g.first = std::uint32_t(radii_.size());
      radii_.push_back(kEndlessRadius);
    }
  }
  const int along = cells_along(reached.size());
  for (const std::uint32_t i : reached) {
    if (along > 0) find_radii(around, i, along);
  }
  if (radii_.empty()) *this = {};
}

}  // namespace pvol::detail
