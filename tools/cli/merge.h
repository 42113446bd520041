// Pictures from their parts.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "cli/cli.h"
#include "cli/keep_sums.h"
#include "cli/picture_output.h"

namespace pvol::cli {

/// What the user gave of `pvol-convert merge`.
struct MergeGiven {
  Common common;
  std::vector<std::filesystem::path> parts;
  PictureOutput output;
  bool partial = false;
  std::vector<int> crop;  ///< x, y, width, height; empty: all of the image
  KeepSums sums = KeepSums::automatic;
};

/// Nothing where the tool goes on, else its exit code.
[[nodiscard]] std::optional<int> read_merge_line(int argc, char** argv, MergeGiven& o);

/// Merges parts into the picture that one render makes, to the byte: in any order, and in any
/// grouping by merges in between. In memory is one picture and some rows. Throws Error for parts of
/// other pictures, and for samples that are missing or there twice. Returns the exit code.
[[nodiscard]] int merge(const MergeGiven& o);

}  // namespace pvol::cli
