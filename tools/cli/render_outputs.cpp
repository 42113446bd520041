#include "cli/render_outputs.h"

#include <fmt/format.h>

#include <fstream>
#include <iostream>

#include "cli/cli.h"
#include "cli/picture_facts.h"
#include "cli/resume_state.h"
#include "pvol/error.h"
#include "pvol/formats/atomic_file.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/image.h"

namespace pvol::cli {
namespace {

constexpr const char* kTool = "pvol-render";
using Options = RenderOptionsGiven;

formats::ExrOptions exr_options(const Options& o, const Scene& scene) {
  return cli::exr_options(PictureLayout{o.denoise, o.multipart, o.pixels, o.compression}, scene);
}

void check_deep(const Options& o, const Outputs& out) {
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
void check_parts(const Options& o, const Outputs& out) {
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

void warn_of_clamped(const std::filesystem::path& file, std::uint64_t values) {
  if (values == 0) return;
  print_warnings(
      kTool,
      {fmt::format("{}: {} values exceed 65504, the largest that half holds, and were set to "
                   "that; keep them with --pixel-type float",
                   file.string(), values)});
}

void save_deep(const Options& o, const std::filesystem::path& file, const RenderJob& job,
               const TimedRender& t) {
  const Scene& scene = job.file.scene;
  const formats::DeepExrWritten done = formats::write_deep_exr(
      file, t.film(), describe_picture(job, t),
      {.error = scene.options.deep_error, .pixels = o.pixels, .camera = scene.camera});
  warn_of_clamped(file, done.clamped);
  if (o.common.quiet) return;
  std::cerr << kTool << ": wrote " << file.string() << ", "
            << readable(double(done.samples) / double(t.film().pixels.size()))
            << " deep samples per pixel\n";
}

/// Whether the picture is to be gone on with, or one of several.
bool keeps_sums(const Options& o, const RenderJob& job, const TimedRender& t) {
  if (o.sums != KeepSums::automatic) return o.sums == KeepSums::on;
  if (!o.deep.empty()) return false;  // which could not be gone on with
  const Film& film = t.film();
  const bool crop = film.crop_width != film.width || film.crop_height != film.height;
  const bool filter_owed = job.denoise && !t.filtered;
  return crop || job.file.scene.options.part_end > 0 || !t.result.complete || filter_owed;
}

void save_exr(const Options& o, const std::filesystem::path& file, const RenderJob& job,
              const TimedRender& t) {
  formats::ExrOptions layout = exr_options(o, job.file.scene);
  if (keeps_sums(o, job, t)) {
    const formats::FilmPiece piece = piece_of(job.file.scene.options, t.result.complete);
    layout.sums = {&t.film(), {.key = job.key, .pieces = {piece}}};
  }
  warn_of_clamped(file, formats::write_exr(file, t.picture(), describe_picture(job, t), layout));
}

}  // namespace

Outputs choose_outputs(const Options& o) {
  if (o.print_scene) return {};
  if (o.output.empty()) throw UsageError("--output is required: the picture to write");
  check_output(o.output, {".exr", ".png"});
  if (o.no_png && !o.png.empty()) throw UsageError("--png and --no-png exclude each other");
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
  if (o.live && out.png.empty()) throw UsageError("--live needs the .png; leave out --no-png");
  if (!o.stats.empty() && o.stats != "-") check_output(o.stats, {".json"});
  if (!o.summary.empty() && !o.frames.any()) {
    throw UsageError("--summary describes the frames of a sequence; it needs --frames");
  }
  if (!o.summary.empty() && o.summary != "-") check_output(o.summary, {".json"});
  return out;
}

bool all_there(const Options& o, const Outputs& out) {
  const auto is_there = [](const std::filesystem::path& file) {
    return file.empty() || std::filesystem::exists(file);
  };
  return is_there(out.exr) && is_there(out.png) && is_there(out.deep) &&
         (o.stats == "-" || is_there(o.stats));
}

void check_layout(const Options& o, const Scene& scene) {
  try {
    formats::validate(exr_options(o, scene));
  } catch (const Error& e) {
    throw UsageError(std::string("--compression and --multipart: ") + e.what());
  }
}

void save_png(const Options& o, const std::filesystem::path& file, const RenderJob& job,
              const Film& film) {
  formats::write_png(file, film, o.exposure, !job.file.scene.options.background, o.tone_map);
}

void write_text(const std::filesystem::path& file, const std::string& text) {
  if (file == "-") {
    std::cout << text;
    return;
  }
  formats::write_atomically(file, [&](const std::filesystem::path& aside) {
    std::ofstream out(aside, std::ios::binary);
    out << text;
    if (!out.flush()) throw Error(file.string() + ": cannot be written; check the disk space");
  });
}

void save_pictures(const Options& o, const Outputs& out, const RenderJob& job,
                   const TimedRender& t) {
  if (!out.exr.empty()) save_exr(o, out.exr, job, t);
  if (!out.png.empty()) save_png(o, out.png, job, t.picture());
  if (!out.deep.empty()) save_deep(o, out.deep, job, t);
}

void save(const Options& o, const Outputs& out, const RenderJob& job, const TimedRender& t) {
  save_pictures(o, out, job, t);
  if (out.exr.empty() && describe_bias(job, t) != "no") {
    print_warnings(kTool, {out.png.string() + ": the picture is biased (" + describe_bias(job, t) +
                           "), which only an .exr can record"});
  }
  if (!o.stats.empty()) write_text(o.stats, stats_text(job, t));
  if (o.common.quiet) return;
  if (job.plan.guide.used && !t.result.guided) {
    std::cerr << kTool << ": paths were not guided: only the constant part of the sky "
              << "lights what the camera sees\n";
  }
  std::cerr << kTool << ": " << (job.frame ? job.frame->label + ": " : "")
            << readable_count(t.samples) << " samples in " << readable_seconds(t.wall_seconds)
            << ", " << noise_text(t.result.film);
  if (t.filtered) {
    std::cerr << "; filtered in " << readable_seconds(t.filtered->wall_seconds)
              << ", estimated error " << readable(100 * t.filtered->relative_error) << " %";
  }
  std::cerr << "; wrote " << out.exr.string() << (out.exr.empty() || out.png.empty() ? "" : " and ")
            << out.png.string() << '\n';
}

}  // namespace pvol::cli
