// What pvol-convert shows of shells: surfaces for other programs, and slices to look at.
#pragma once

#include <filesystem>

#include "pvol/math/affine.h"
#include "pvol/shell/shell.h"
#include "pvol/shell/support.h"

namespace pvol::cli {

/// Writes a shell's surface in world space, .ply or .obj by the file's extension, meshed in
/// `resolution` steps along its longest side (8 to 1024).
void write_shell_mesh(const std::filesystem::path& file, const Shell& shell,
                      const Affine& index_to_world, int resolution);

/// Writes a .png of the middle slices across x, y and z side by side, about 1200 pixels wide: cells
/// grey, what else the shell holds blue, its outline dark, all beyond it white. Across x and y the
/// z axis points up, across z the y axis.
void write_shell_slices(const std::filesystem::path& file, const Shell& shell,
                        const Support& support);

}  // namespace pvol::cli
