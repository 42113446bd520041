// Rendered pictures filtered afterwards: one, or the frames of a sequence with light from those
// before and after.
#pragma once

#include <filesystem>
#include <optional>

#include "cli/cli.h"
#include "cli/picture_output.h"
#include "cli/sequence.h"

namespace pvol::cli {

/// What the user gave of `pvol-convert denoise`.
struct FilterGiven {
  Common common;
  FramesGiven frames;
  std::filesystem::path input;
  PictureOutput output;
  int around = 2;   ///< frames before and after that light is taken from
  int threads = 0;  ///< 0: one for each hardware thread
};

/// Nothing where the tool goes on, else its exit code.
[[nodiscard]] std::optional<int> read_filter_line(int argc, char** argv, FilterGiven& o);

/// Filters the picture, or frame by frame those of the sequence. Throws Error for pictures that
/// lack what the filter needs, or are filtered already. Returns the exit code.
[[nodiscard]] int filter_frames(const FilterGiven& o);

}  // namespace pvol::cli
