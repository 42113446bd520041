// Colours as files have them.
#pragma once

#include <array>
#include <functional>
#include <span>

#include "pvol/density/voxel_grid.h"
#include "pvol/math/float4.h"

namespace pvol {

/// Red, green and blue, linear, each a grid of values in [0, 1] whose name is the colour's
/// own. A sample may say no colour: black ones do, so a fourth grid tells. All four lie on one
/// lattice: they have the same index_to_world.
struct ColorGrid {
  std::array<VoxelGrid, 3> channels;
  VoxelGrid known;  ///< 1 where a sample says a colour, and in no other place above 0

  [[nodiscard]] const std::string& name() const { return channels[0].name; }
  [[nodiscard]] const Affine& index_to_world() const { return channels[0].index_to_world; }
};

/// visit(origin, edge, samples) for each brick and tile of `known`: red, green, blue and known of
/// its 8^3 samples, in their order, or of all samples of a tile, once.
void visit_colors(
    const ColorGrid& colors,
    const std::function<void(Vec3i origin, int edge, std::span<const Float4> samples)>& visit);

/// 1 where a channel is above 0, or `black` is, which may be null: what `known` is to be where the
/// samples that say a colour are not otherwise told.
[[nodiscard]] VoxelGrid known_of(const std::array<VoxelGrid, 3>& channels, const VoxelGrid* black);

/// 1 where a colour is known and black: known_of would miss it without. Empty where none is.
[[nodiscard]] VoxelGrid black_of(const ColorGrid& colors);

}  // namespace pvol
