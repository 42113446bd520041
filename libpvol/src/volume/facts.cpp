#include "pvol/volume/facts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <vector>

#include "density/sample_range.h"
#include "pvol/math/parallel.h"
#include "pvol/volume/emitter.h"
#include "pvol/volume/moving_places.h"
#include "volume/placement.h"

namespace pvol {
namespace {

/// Sums of samples over lattice columns along one axis, 8 x 8 columns of bricks together. Below
/// huge tiles one such block stands for several.
class Columns {
 public:
  static constexpr std::size_t kColumns = kBrickEdge * kBrickEdge;

  explicit Columns(int axis) : axis_(axis) {}

  /// The 8 x 8 sums that a brick adds to: of axes 0, 1 and 2 at (y, z), (x, z) and (x, y).
  std::array<double, kColumns>& sums_at(Vec3i origin) { return block(origin).sums; }

  /// A tile's columns are equal: blocks of them, but no more than a few thousand for a huge one.
  void add(const Tile& tile) {
    const int step = std::max(kBrickEdge, tile.edge / 64);
    for (int i = 0; i < tile.edge; i += step) {
      for (int j = 0; j < tile.edge; j += step) {
        Vec3i at = tile.origin;
        at[(axis_ + 1) % 3] += i;
        at[(axis_ + 2) % 3] += j;
        Block& b = block(at);
        for (double& sum : b.sums) sum += double(tile.value) * tile.edge;
        b.stands_for = std::max(b.stands_for, step / kBrickEdge);
      }
    }
  }

  /// The sums of other bricks.
  void add(const Columns& other) {
    for (const auto& [place, b] : other.blocks_) {
      Block& to = blocks_[place];
      for (std::size_t i = 0; i < kColumns; ++i) to.sums[i] += b.sums[i];
    }
  }

  struct Result {
    double mean = 0, largest = 0;  // of the columns that hold anything
  };
  [[nodiscard]] Result result() const {
    Result r;
    double total = 0, count = 0;
    for (const std::uint64_t place : places_in_order()) {
      const Block& b = blocks_.at(place);
      const double weight = double(b.stands_for) * b.stands_for;
      for (const double sum : b.sums) {
        total += weight * sum;
        count += sum > 0 ? weight : 0;
        r.largest = std::max(r.largest, sum);
      }
    }
    if (count > 0) r.mean = total / count;
    return r;
  }

 private:
  struct Block {
    std::array<double, kColumns> sums{};
    int stands_for = 1;  ///< blocks along an edge
  };

  /// So that sums are the same each time.
  [[nodiscard]] std::vector<std::uint64_t> places_in_order() const {
    std::vector<std::uint64_t> places;
    for (const auto& entry : blocks_) places.push_back(entry.first);
    std::sort(places.begin(), places.end());
    return places;
  }

  Block& block(Vec3i at) {
    const auto place = [&](int shift) {
      return std::uint64_t(std::uint32_t(at[(axis_ + shift) % 3] / kBrickEdge));
    };
    return blocks_[place(1) << 32 | place(2)];
  }

  int axis_;
  std::unordered_map<std::uint64_t, Block> blocks_;
};

/// What facts need of all samples, in one pass: large grids do not fit into caches.
struct GridSums {
  detail::SampleRange range;
  std::array<Columns, 3> columns{Columns(0), Columns(1), Columns(2)};  // by axis

  void add(const Brick& brick) {
    range.add(brick.values, kBrickSamples);
    constexpr std::size_t kEdge = kBrickEdge;
    auto& along_x = columns[0].sums_at(brick.origin);
    auto& along_y = columns[1].sums_at(brick.origin);
    auto& along_z = columns[2].sums_at(brick.origin);
    const float* row = brick.values;
    for (std::size_t x = 0; x < kEdge; ++x) {
      for (std::size_t y = 0; y < kEdge; ++y, row += kEdge) {
        std::array<double, kEdge> values;
        for (std::size_t z = 0; z < kEdge; ++z) values[z] = double(row[z]);
        for (std::size_t z = 0; z < kEdge; ++z) along_x[y * kEdge + z] += values[z];
        for (std::size_t z = 0; z < kEdge; ++z) along_y[x * kEdge + z] += values[z];
        for (const double value : values) along_z[x * kEdge + y] += value;
      }
    }
  }
  void add(const Tile& tile) {
    range.add(&tile.value, 1);
    for (Columns& c : columns) c.add(tile);
  }
  void add(const GridSums& other) {
    range.add(other.range);
    for (std::size_t axis = 0; axis < 3; ++axis) columns[axis].add(other.columns[axis]);
  }
};

/// In parts that are added in order, so that the sums do not depend on threads.
GridSums sums_of(const VoxelGrid& grid) {
  constexpr std::size_t kParts = 8;
  std::array<GridSums, kParts> parts;
  parallel_for(0, kParts, [&](std::size_t part) {
    const std::size_t bricks = grid.bricks.size(), end = bricks * (part + 1) / kParts;
    for (std::size_t b = bricks * part / kParts; b != end; ++b) parts[part].add(grid.bricks[b]);
  });
  GridSums all;
  for (const GridSums& part : parts) all.add(part);
  for (const Tile& t : grid.tiles) all.add(t);
  return all;
}

/// Around a field at a place at the time of the files.
Box still_box(const VolumeField& field, const Volume& volume, std::size_t place) {
  if (place == 0 || field.octree.empty()) return field.world_box;
  const Affine to_first = inverse(field.world_to_cells);
  return transform(volume.further_places[place - 1] * to_first, field.octree.support());
}

template <class BoxOf>
Box box_around(std::span<const Volume> volumes, const BoxOf& box_of) {
  Box all;
  for (const Volume& v : volumes) {
    for (std::size_t place = 0; place < count_places(v); ++place) {
      all = join(all, box_of(v.density, v, place));
      if (v.fire != nullptr) all = join(all, box_of(v.fire->field, v, place));
    }
  }
  return all;
}

}  // namespace

Box world_box(std::span<const Volume> volumes) {
  return box_around(volumes, [](const VolumeField& f, const Volume& v, std::size_t place) {
    return world_box(f, v, place);
  });
}
Box still_world_box(std::span<const Volume> volumes) { return box_around(volumes, still_box); }

Box world_box(const VolumeField& field, const Volume& volume, std::size_t place) {
  if (field.octree.empty() || !place_moves(volume, place)) {
    return still_box(field, volume, place);
  }
  // Times of samples are floats.
  constexpr double kRounding = 1e-6;
  const MovingPlaces& m = *volume.moving_places;
  const double more = kRounding * m.shutter.farthest();
  return swept_box(m.all[place], cells_to_object(field, volume), field.octree.support(),
                   m.shutter.open - more, m.shutter.close + more);
}

namespace {

/// The largest length_of(map from cells to the world) at any place and time.
template <class LengthOf>
double largest_cell(const Volume& volume, const LengthOf& length_of) {
  double most = 0;
  for (std::size_t place = 0; place < count_places(volume); ++place) {
    const Affine to_cells = volume.density.world_to_cells * to_first_place(volume, place);
    most = std::max(most, length_of(inverse(to_cells)));
    if (!place_moves(volume, place)) continue;
    const MovingPlaces& m = *volume.moving_places;
    for (const double u : {0.0, 0.5, 1.0}) {
      const Affine map = m.all[place].at(m.shutter.at(u)) * cells_to_object(volume.density, volume);
      most = std::max(most, length_of(map));
    }
  }
  return most;
}

}  // namespace

double thickest_cell(const Volume& volume) {
  float most = 0;
  for (const Octree::Entry& e : volume.density.octree.entries) {
    if (e.log2 > 0) most = std::max(most, e.hi);
  }
  return double(most) * largest_cell(volume, [](const Affine& to_world) {
           double longest = 0;
           for (int axis = 0; axis < 3; ++axis)
             longest = std::max(longest, detail::column_length(to_world, axis));
           return longest;
         });
}

double worst_null_collisions(const Volume& volume) {
  const double cell_length = largest_cell(
      volume, [](const Affine& to_world) { return std::cbrt(std::abs(determinant(to_world))); });
  double most = 0;
  for (const Octree::Entry& e : volume.density.octree.entries) {
    if (e.log2 > 0) most = std::max(most, double(e.hi - e.lo) * std::ldexp(cell_length, e.log2));
  }
  return most;
}

DensityFacts look_through(const VoxelGrid& grid) {
  const GridSums sums = sums_of(grid);
  DensityFacts f{.largest = double(sums.range.hi()), .index_to_world = grid.index_to_world};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Columns::Result r = sums.columns[axis].result();
    f.mean_column[axis] = r.mean, f.largest_column[axis] = r.largest;
  }
  return f;
}

DensityFacts look_through(const Recipe& recipe) {
  Recipe coarse = recipe;
  coarse.voxel = voxel_for(recipe, kCoarseResolution);
  return look_through(make_grid(coarse));
}

DensityFacts look_through(const Density& density) {
  if (const auto* grid = std::get_if<VoxelGrid>(&density)) return look_through(*grid);
  return look_through(*std::get<std::shared_ptr<const Recipe>>(density));
}

VolumeFacts describe(const DensityFacts& density, double extinction,
                     const Affine& object_to_world) {
  VolumeFacts f;
  const Affine to_world = object_to_world * density.index_to_world;
  f.largest_extinction = extinction * density.largest;
  f.shortest_free_path = 1 / f.largest_extinction;
  for (int axis = 0; axis < 3; ++axis) {
    const double step = detail::column_length(to_world, axis) * extinction;
    f.mean_optical_thickness[axis] = density.mean_column[std::size_t(axis)] * step;
    f.largest_optical_thickness =
        std::max(f.largest_optical_thickness, density.largest_column[std::size_t(axis)] * step);
  }
  return f;
}

VolumeFacts describe(const Volume& volume, VolumeFacts f) {
  const Octree& octree = volume.density.octree;
  f.depth = octree.depth;
  f.nodes = octree.nodes.size();
  f.terminals = octree.terminals;
  f.octree_bytes = octree.bytes();
  f.field_bytes = volume.density.value_bytes();
  return f;
}

}  // namespace pvol
