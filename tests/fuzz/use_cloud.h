// What a renderer does with a cloud once it is loaded.
#pragma once

#include "pvol/bounds/pyramid.h"
#include "pvol/density/density.h"
#include "pvol/field/leaf_micro_bounds.h"
#include "pvol/shell/shell.h"

namespace pvol::fuzz {

/// Makes a volume of the cloud and sends a few rays through it. A cloud of more than a few thousand
/// leaves is left alone. Throws Error for what make_volume refuses.
void use_cloud(const Density& density, const Pyramid& pyramid,
               const LeafMicroBounds* micro = nullptr);

/// Sends a few rays through a valid shell.
void use_shell(const Shell& shell);

/// As use_cloud with bounds built here, for a grid of few samples; tiles are counted by their
/// volume.
void use_grid(const VoxelGrid& grid);

}  // namespace pvol::fuzz
