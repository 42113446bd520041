// Where pvol-convert writes a picture that it makes of others.
#pragma once

#include <filesystem>

#include "pvol/formats/image.h"

namespace pvol::cli {

/// The tool's name in messages.
inline constexpr const char* kConvertTool = "pvol-convert";

/// What the user gave: an .exr and, unless there is to be none, a .png beside it.
struct PictureOutput {
  std::filesystem::path exr, png;
  bool no_png = false;
  formats::Display display{};
};

/// Throws UsageError for names that do not go together.
void check(const PictureOutput& o);

/// Writes the .png, if one is wanted.
void save_png(const PictureOutput& o, const Film& film, bool background);

}  // namespace pvol::cli
