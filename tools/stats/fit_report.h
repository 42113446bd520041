// What pvol-fit was asked for, what it made, and what it says about that.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/cli.h"
#include "cli/sequence.h"
#include "pvol/density/recipe.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/pvol_file.h"

namespace pvol::cli {

/// What the user gave.
struct FitOptions {
  Common common;
  FramesGiven frames;
  std::filesystem::path input, output;
  formats::GridOptions grid;
  std::string unit;
  std::string density = "fp32", look_up = "trilinear";
  std::optional<double> tolerance;
  std::string micro_bounds = "none";
  std::string compression = "zstd";
  std::string shells = "none", shell_kind = "hard";
  int shell_effort = 1;
  std::string fields = "auto";
  bool check = false, closed_form = false;
  bool json = false;
  int threads = 0;
};

/// What was made of a cloud.
struct Fit {
  formats::LoadedGrid loaded;  ///< without samples where the bounds are a recipe's in closed form
  Recipe recipe;               ///< of those
  formats::PvolFile file;
  std::vector<formats::GridReport> fields;  ///< of the file's fields, in their order
  formats::PvolSizes bytes;
  std::uint64_t source_bytes = 0;
  double read_seconds = 0, bounds_seconds = 0, shell_seconds = 0, write_seconds = 0;
  std::string check;  ///< what CGAL's check found
};

/// The report on stdout: some lines, or for scripts.
void print_text(const FitOptions& o, const Fit& f);
void print_json(const FitOptions& o, const Fit& f);

/// One line, for a frame of a sequence.
void print_line(const FitOptions& o, const Fit& f, const std::string& label);

/// What the input is unlikely to mean, and what is written and perhaps not what was wanted, in
/// whole sentences.
[[nodiscard]] std::vector<std::string> warnings(const FitOptions& o, const Fit& f);

}  // namespace pvol::cli
