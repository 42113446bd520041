#include "cli/choose_outputs.h"

#include <fmt/format.h>

#include "cli/cli.h"
#include "cli/picture_facts.h"
#include "pvol/error.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/scene_files.h"

namespace pvol::cli {
namespace {

void check_deep(const RenderOptionsGiven& o, const Outputs& out) {
  for (const char* key : {"deep_bins", "deep_error"}) {
    if (!o.deep.empty() || !o.options.contains(key)) continue;
    throw UsageError("--deep-bins and --deep-error need --deep FILE, the deep picture");
  }
  if (o.deep.empty()) return;
  check_output(o.deep, {".exr"});
  for (const std::filesystem::path& other : {out.exr, out.png}) {
    if (other.empty() || weakly_canonical(other) != weakly_canonical(o.deep)) continue;
    throw UsageError(fmt::format(
        "--deep and the output are the same file, {}; choose another name, such as {}",
        o.deep.string(), std::filesystem::path(o.deep).replace_extension(".deep.exr").string()));
  }
}

/// Throws UsageError for what only pictures with exact sums can be.
void check_parts(const RenderOptionsGiven& o, const Outputs& out) {
  const std::pair<bool, const char*> wanted[] = {{o.resume.value_or(false), "--resume"},
                                                 {!o.pilot.empty(), "--pilot"},
                                                 {o.sums == KeepSums::on, "--sums on"}};
  for (const auto& [given, flag] : wanted) {
    if (!given) continue;
    if (out.exr.empty()) {
      throw UsageError(fmt::format("{} needs exact sums and thus an .exr; found the output {}",
                                   flag, o.output.string()));
    }
    if (!out.deep.empty()) {
      throw UsageError(
          fmt::format("{} and --deep exclude each other: deep pictures have no exact sums", flag));
    }
  }
}

/// Throws UsageError for what a PNG cannot hold.
void check_layers(const RenderOptionsGiven& o, const Outputs& out) {
  if (!out.exr.empty()) return;
  const RenderOptionsGiven usual;
  const std::pair<bool, const char*> wanted[] = {
      {o.options.contains("aov"), "--aov"},
      {o.denoise_layers, "--denoise-layers"},
      {o.multipart, "--multipart"},
      {o.pixels != usual.pixels, "--pixel-type"},
      {o.compression != usual.compression, "--compression"}};
  for (const auto& [given, flag] : wanted) {
    if (!given) continue;
    throw UsageError(
        fmt::format("{} needs an .exr: a .png has colours and alpha alone; found the "
                    "output {}",
                    flag, o.output.string()));
  }
}

}  // namespace

Outputs choose_outputs(const RenderOptionsGiven& o) {
  if (o.print_scene) return {};
  if (o.output.empty()) throw UsageError("--output is required: the picture to write");
  check_output(o.output, {".exr", ".png"});
  if (o.no_png && !o.png.empty()) throw UsageError("--png and --no-png exclude each other");
  if (o.denoise && o.denoise_layers) {
    throw UsageError(
        "--denoise and --denoise-layers exclude each other: the layers are for a picture that "
        "pvol-convert denoise filters afterwards");
  }
  Outputs out;
  if (formats::ending(o.output) == ".png") {
    if (o.no_png || !o.png.empty()) {
      throw UsageError("the output is a .png; --png and --no-png need an .exr");
    }
    out.png = o.output;
  } else {
    out.exr = o.output;
    if (!o.no_png) {
      out.png = o.png.empty() ? std::filesystem::path(o.output).replace_extension(".png") : o.png;
      check_output(out.png, {".png"});
    }
  }
  out.deep = o.deep;
  check_deep(o, out);
  check_parts(o, out);
  check_layers(o, out);
  if (o.live && out.png.empty()) throw UsageError("--live needs the .png; leave out --no-png");
  if (!o.stats.empty() && o.stats != "-") check_output(o.stats, {".json"});
  if (!o.summary.empty() && !o.frames.any()) {
    throw UsageError("--summary describes the frames of a sequence; it needs --frames");
  }
  if (!o.summary.empty() && o.summary != "-") check_output(o.summary, {".json"});
  return out;
}

void check_inputs_stay(const Outputs& out, const formats::SceneFile& scene) {
  for (const std::filesystem::path& input : formats::files_of(scene)) {
    for (const std::filesystem::path& output : {out.exr, out.png, out.deep}) {
      if (!same_file(input, output)) continue;
      throw UsageError(
          fmt::format("{}: the scene reads this file, which the output would replace; choose "
                      "another name for the output",
                      output.string()));
    }
  }
}

bool all_there(const RenderOptionsGiven& o, const Outputs& out) {
  const auto is_there = [](const std::filesystem::path& file) {
    std::error_code missing;
    if (file.empty()) return true;
    const auto bytes = std::filesystem::file_size(file, missing);
    return !missing && bytes > 0;
  };
  return is_there(out.exr) && is_there(out.png) && is_there(out.deep) &&
         (o.stats == "-" || is_there(o.stats));
}

formats::ExrOptions exr_options(const RenderOptionsGiven& o, const Scene& scene) {
  return cli::exr_options(PictureLayout{o.denoise, o.multipart, o.pixels, o.compression}, scene);
}

void check_layout(const RenderOptionsGiven& o, const Scene& scene) {
  try {
    formats::validate(exr_options(o, scene));
  } catch (const Error& e) {
    throw UsageError(std::string("--compression and --multipart: ") + e.what());
  }
}

}  // namespace pvol::cli
