// The command line of pvol-render, apart from the rest because CLI11 takes long to compile.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cli/cli.h"
#include "cli/keep_sums.h"
#include "cli/sequence.h"
#include "cli/split_given.h"
#include "pvol/formats/image.h"
#include "pvol/formats/vdb.h"
#include "pvol/math/keys.h"

namespace pvol::cli {

/// The tool's name in messages.
inline constexpr const char* kRenderTool = "pvol-render";

/// What the user gave.
struct RenderOptionsGiven {
  Common common;
  FramesGiven frames;
  std::filesystem::path input, output, png, deep, stats;
  formats::GridOptions grid;
  std::vector<std::string> sets;
  std::map<std::string, std::string> flags_of_sets{};  ///< of those that --view and the like add
  /// Flags of formats::render_keys, as written, by key; absent ones are left to the scene.
  std::map<std::string, std::string> options;
  formats::Display display{};
  formats::PixelType pixels = formats::PixelType::single;
  formats::ExrCompression compression = formats::ExrCompression::zip;
  bool multipart = false;
  bool live = false;
  bool denoise = false, denoise_layers = false;
  SplitGiven split;
  std::filesystem::path local_copies;  ///< folder, or "auto"; empty: none
  std::vector<std::string> arguments;  ///< the command line as given, with the tool's name
  bool no_png = false, print_scene = false, force = false;
  std::filesystem::path summary;  ///< of a sequence, as JSON
  std::optional<bool> resume;     ///< --resume or --no-resume
  std::filesystem::path pilot;    ///< picture of a whole's first adaptive samples
  double checkpoint = 10;         ///< minutes; 0: none
  KeepSums sums = KeepSums::automatic;
};

/// Nothing where the tool goes on, else its exit code.
[[nodiscard]] std::optional<int> read_command_line(int argc, char** argv, RenderOptionsGiven& o);

}  // namespace pvol::cli
