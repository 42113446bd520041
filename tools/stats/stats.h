// The verbs of pvol-stats, one source file each.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "cli/cli.h"
#include "pvol/formats/cloud.h"

namespace pvol::cli {

struct InfoOptions {
  std::vector<std::filesystem::path> inputs;
  bool json = false;
};
[[nodiscard]] int run_info(const InfoOptions& o);

struct BoundsOptions {
  std::filesystem::path input;
  formats::GridOptions grid;
  std::optional<double> extinction;
  std::optional<std::filesystem::path> html;
  bool measure = false, verify = false, json = false;
};
[[nodiscard]] int run_bounds(const BoundsOptions& o);

struct ShellsOptions {
  std::filesystem::path input;
  std::optional<std::filesystem::path> html;
  bool verify = false, check = false, json = false;
};
[[nodiscard]] int run_shells(const ShellsOptions& o);

struct ImageOptions {
  std::filesystem::path a, b;
  std::optional<std::filesystem::path> html, map;
  double confidence = 0.95, level = 1e-3;
  bool json = false, fail_on_bias = false;
};
[[nodiscard]] int run_image(const ImageOptions& o);

}  // namespace pvol::cli
