// Making a volume of a density and bounds that are at hand, as files have them.
#pragma once

#include <memory>

#include "pvol/bounds/pyramid.h"
#include "pvol/density/density.h"
#include "pvol/volume/volume.h"

namespace pvol {

struct LeafMicroBounds;  // field/leaf_micro_bounds.h

/// Makes a cloud ready for a medium, a way of look-up and a tracker: the walk stops where the cost
/// model says (THEORY.md, T2.1), and not below options.depth; at the root for the tracker
/// delta_global. Micro-bounds are made where options.micro_bounds asks for them: of those
/// `stored`, where they are there and of the size that is wanted, else built.
/// Trackers with weights take bounds up to kMostBoundsExcess too low, options.majorant_scale
/// included. Throws Error where bounds or stored micro-bounds do not hold for the density otherwise
/// or were not made for the way of look-up, the map is singular, the medium is out of range or its
/// extinction too large for a float, or the placement is so far from the origin that positions lose
/// more than 1/1000 of a voxel.
[[nodiscard]] Volume make_volume(const VoxelGrid& grid, const Pyramid& pyramid,
                                 const Medium& medium, const VolumeOptions& options,
                                 const LeafMicroBounds* stored = nullptr);

/// Throws Error for a map under which no volume can be made: singular, out of range, or so far from
/// the origin that positions lose more than 1/1000 of a voxel.
void validate_placement(const Affine& index_to_world, const Pyramid& pyramid);

/// The same for a recipe, which is not null. The pyramid is that of build_pyramid(*recipe, ...);
/// cells are the recipe's voxels. Throws Error for options.homogenise, too.
[[nodiscard]] Volume make_volume(std::shared_ptr<const Recipe> recipe, const Pyramid& pyramid,
                                 const Medium& medium, const VolumeOptions& options);

/// The same for either.
[[nodiscard]] Volume make_volume(const Density& density, const Pyramid& pyramid,
                                 const Medium& medium, const VolumeOptions& options,
                                 const LeafMicroBounds* stored = nullptr);

}  // namespace pvol
