// Tables of phase functions from text files: one angle and value a line, # begins a comment.
#pragma once

#include "toml/toml_table.h"

namespace pvol::formats {

/// The key that holds points, or names a file of them.
inline constexpr std::string_view kPhaseTable = "phase_table";

/// Wherever that key of a table, or of one within it, names a file, puts the points of the file in
/// the place of the name. Throws Error with file and line for what is not an angle in degrees and a
/// value, in ascending order of angles, and for a file that cannot be read.
void load_phase_files(TomlTable& table);

}  // namespace pvol::formats
