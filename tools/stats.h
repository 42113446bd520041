// The verbs of pvol-stats, one source file each.
#pragma once

#include <filesystem>
#include <optional>

#include "cli.h"
#include "pvol/formats/cloud.h"

namespace pvol::cli {

struct BoundsOptions {
  std::filesystem::path input;
  formats::GridOptions grid;
  std::optional<double> extinction;
  bool json = false;
};
[[nodiscard]] int run_bounds(const BoundsOptions& o);

struct ShellsOptions {
  std::filesystem::path input;
  bool verify = false, check = false, json = false;
};
[[nodiscard]] int run_shells(const ShellsOptions& o);

}  // namespace pvol::cli
