#include "pvol/volume/albedo_field.h"

#include <algorithm>
#include <array>

#include "density/lattice_index.h"
#include "pvol/error.h"
#include "volume/placement.h"

namespace pvol {
namespace {

/// Whether samples of the block at `origin` are known wherever the density's are above 0.
bool covers(const detail::BlockFinder& known, Vec3i origin, const float* density) {
  const detail::BlockSource block = known.find(origin);
  if (block.values == nullptr) return block.constant > 0;
  for (int i = 0; i < kBrickSamples; ++i) {
    const float d = density != nullptr ? density[i] : 1;
    if (d > 0 && !(block.values[i] > 0)) return false;
  }
  return true;
}

/// Whether every sample of density above 0 has a colour: then so has one around each place where
/// there is density.
bool covers(const VoxelGrid& known, const VoxelGrid& density) {
  constexpr int kLargestTile = 128;  // larger ones are not looked through
  if (!(known.index_to_world == density.index_to_world)) return false;
  const detail::BlockFinder blocks(known);
  for (const Brick& b : density.bricks) {
    if (!covers(blocks, b.origin, b.values)) return false;
  }
  for (const Tile& t : density.tiles) {
    if (t.edge > kLargestTile) return false;
    for (Vec3i p; p.x < t.edge; p.x += kBrickEdge) {
      for (p.y = 0; p.y < t.edge; p.y += kBrickEdge) {
        for (p.z = 0; p.z < t.edge; p.z += kBrickEdge) {
          if (!covers(blocks, t.origin + p, nullptr)) return false;
        }
      }
    }
  }
  return true;
}

float largest_value(const VoxelGrid& grid) {
  float most = 0;
  for (const Brick& b : grid.bricks) {
    most = std::max(most, *std::max_element(b.values, b.values + kBrickSamples));
  }
  for (const Tile& t : grid.tiles) most = std::max(most, t.value);
  return std::min(most, 1.0f);
}

/// A sample as look-ups read it.
Float4 ready(Float4 sample) {
  if (!(sample[3] > 0)) return Float4{};
  const Float4 in_unit = min(max(sample, splat(0.0f)), splat(1.0f));
  return Float4{in_unit[0], in_unit[1], in_unit[2], 1};
}

}  // namespace

AlbedoField make_albedo_field(const AlbedoMap& map, const BoundedGrid& numbers,
                              const Affine& object_to_world) {
  validate(map);
  AlbedoField f{.map = map};
  f.values = make_value_field(numbers, {}, object_to_world, "albedo fields");
  f.world_to_cells = f.values->world_to_cells;
  f.largest = largest_color(map, numbers.pyramid.scale);
  return f;
}

AlbedoField make_albedo_field(const AlbedoMap& map, const ColorGrid& colors,
                              const VoxelGrid* density, const Affine& object_to_world) {
  if (map.is_of_numbers()) {
    throw Error("albedo field: the grid " + colors.name() +
                " has colours, which are not mapped; scale, offset, clamp, power, ramp and colors "
                "apply to grids of numbers: leave them out");
  }
  AlbedoField f{.map = map};
  const auto& c = colors.channels;
  const std::array grids{&c[0], &c[1], &c[2], &colors.known};
  const LeafBox box = leaf_box(grids);
  if (box.empty()) return f;
  if (box.count() > kMostVectorLeaves) {
    throw Error("albedo field: the box of the grid " + colors.name() +
                " has more than 2^24 leaves of 8^3 voxels; resample it to larger voxels");
  }
  const Affine to_world = object_to_world * colors.index_to_world();
  const Vec3i origin = box.lo * kBrickEdge;
  f.world_to_cells = translation(-Vec3d(origin)) * inverse(to_world);
  detail::check_placement(to_world, f.world_to_cells,
                          transform(to_world, {Vec3d(origin), Vec3d(box.hi * kBrickEdge)}));
  f.colors = make_vector_bricks(grids, box, ready);
  if (density != nullptr && covers(colors.known, *density)) {
    f.largest = {largest_value(c[0]), largest_value(c[1]), largest_value(c[2])};
  }
  return f;
}

Rgb color_in(const AlbedoField& f, Vec3d cells) {
  if (f.values) return color_of(f.map, value_in(*f.values, cells));
  const Float4 v = f.colors.at(cells);
  if (!(v[3] > 0)) return Rgb(1.0f);
  return vec3(min(v / splat(v[3]), splat(1.0f)));
}

float largest_albedo(const Volume& volume) {
  const Rgb color = volume.albedo ? volume.albedo->largest : Rgb(1.0f);
  float largest = 0;
  for (const Component& c : volume.medium.components) {
    if (c.share > 0) largest = std::max(largest, max_component(c.albedo * color));
  }
  return largest;
}

}  // namespace pvol
