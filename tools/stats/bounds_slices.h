// Slices through the middle of a cloud: density, the cubes of its bounds, and its shell.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pvol/bounds/pyramid.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/image.h"
#include "pvol/shell/shell.h"
#include "report/document.h"

namespace pvol::cli {

struct BoundsSlice {
  int across = 0;            ///< the axis that the slice stands on
  std::int64_t edge = 0;     ///< of the cubes drawn, in voxels
  formats::Picture picture;  ///< x or y to the right, z or y up
};

/// The middle slices across x, y and z of the box around the density, about 460 pixels along the
/// longer side. Density is grey, dark where it is high; borders of cubes are coloured by (hi - lo)
/// over the largest density, with ColourMap::sequential; the shell's outline is orange. The cubes
/// are the smallest that can be told apart. Throws Error where bounds do not hold. The pyramid is
/// not empty.
[[nodiscard]] std::vector<BoundsSlice> slice_bounds(const VoxelGrid& grid, const Pyramid& pyramid,
                                                    const Shell* shell);

/// "8³ voxels, the leaves".
[[nodiscard]] std::string cube_name(std::int64_t edge);

/// The slices of a cloud, with its shell where it has one, named by axis and perhaps by cubes.
[[nodiscard]] std::vector<report::Figure> slice_figures(const formats::Cloud& cloud,
                                                        bool name_cubes);

}  // namespace pvol::cli
