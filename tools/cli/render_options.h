// The command line of pvol-render, apart from the rest because CLI11 takes long to compile.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/cli.h"
#include "pvol/formats/vdb.h"

namespace pvol::cli {

/// What the user gave; absent values are left to the scene.
struct RenderOptionsGiven {
  Common common;
  std::filesystem::path input, output, png, stats;
  formats::GridOptions grid;
  std::vector<std::string> sets;
  std::optional<std::array<int, 2>> size;
  std::optional<std::array<int, 4>> crop;
  std::optional<std::uint32_t> samples;
  std::optional<std::uint64_t> seed;
  std::optional<std::string> tracker, transmittance, micro_bounds, look_up, depth, shells, guide,
      max_bounces, background, density;
  std::optional<double> density_tolerance;  ///< with density fpn only
  int threads = 0;
  double exposure = 0;
  std::optional<double> majorant_scale, homogenise;
  std::optional<int> preview;
  bool no_png = false, print_scene = false, force = false;
};

/// Nothing where the tool goes on, else its exit code.
[[nodiscard]] std::optional<int> read_command_line(int argc, char** argv, RenderOptionsGiven& o);

}  // namespace pvol::cli
