#include "cli/render_outputs.h"

#include <fmt/format.h>
#include <unistd.h>

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

void warn_of_clamped(const std::filesystem::path& file, std::uint64_t values) {
  if (values == 0) return;
  print_warnings(
      kRenderTool,
      {fmt::format("{}: {} values exceed 65504, the largest that half holds, and were set to "
                   "that; keep them with --pixel-type float",
                   file.string(), values)});
}

void save_deep(const RenderOptionsGiven& o, const std::filesystem::path& file, const RenderJob& job,
               const TimedRender& t) {
  const Scene& scene = job.file.scene;
  const formats::DeepExrWritten done = formats::write_deep_exr(
      file, t.film(), describe_picture(job, t),
      {.error = scene.options.deep_error, .pixels = o.pixels, .camera = scene.camera});
  warn_of_clamped(file, done.clamped);
  if (o.common.quiet) return;
  std::cerr << kRenderTool << ": wrote " << file.string() << ", "
            << readable(double(done.samples) / double(t.film().pixels.size()))
            << " deep samples per pixel\n";
}

/// Whether the picture is to be gone on with, or one of several.
bool keeps_sums(const RenderOptionsGiven& o, const RenderJob& job, const TimedRender& t) {
  if (o.sums != KeepSums::automatic) return o.sums == KeepSums::on;
  if (!o.deep.empty()) return false;  // which could not be gone on with
  const Film& film = t.film();
  const bool crop = film.crop_width != film.width || film.crop_height != film.height;
  const bool filter_owed = job.denoise && !t.filtered;
  return crop || job.file.scene.options.part_end > 0 || !t.result.complete || filter_owed;
}

void save_exr(const RenderOptionsGiven& o, const std::filesystem::path& file, const RenderJob& job,
              const TimedRender& t) {
  formats::ExrOptions layout = exr_options(o, job.file.scene);
  if (keeps_sums(o, job, t)) {
    const formats::FilmPiece piece = piece_of(job.file.scene.options, t.result.complete);
    layout.sums = {&t.film(), {.key = job.key, .pieces = {piece}}};
  }
  warn_of_clamped(file, formats::write_exr(file, t.picture(), describe_picture(job, t), layout));
}

}  // namespace

void save_png(const RenderOptionsGiven& o, const std::filesystem::path& file, const RenderJob& job,
              const Film& film) {
  formats::write_png(file, film, o.display, !job.file.scene.options.background);
}

void write_text(const std::filesystem::path& file, const std::string& text) {
  if (file == "-") {
    std::cout << text;
    return;
  }
  formats::write_text_atomically(file, text);
}

void save_pictures(const FrameJob& frame, const RenderJob& job, const TimedRender& t) {
  const RenderOptionsGiven& o = frame.options;
  const Outputs& out = frame.outputs;
  if (!out.exr.empty()) save_exr(o, out.exr, job, t);
  if (!out.png.empty()) save_png(o, out.png, job, t.picture());
  if (!out.deep.empty()) save_deep(o, out.deep, job, t);
}

namespace {

/// Saves pictures in the folder of temporary files, where the disk of their own folder is full or
/// gone: a render may be worth days. Throws Error in any case, for the first that could not be
/// saved, with where they are instead.
[[noreturn]] void save_elsewhere(const FrameJob& frame, const RenderJob& job, const TimedRender& t,
                                 const Error& failure) {
  FrameJob other = frame;
  std::string names;
  // Pictures of one name in different folders stay apart.
  const auto rename = [&](std::filesystem::path& file, const char* kind) {
    if (file.empty()) return;
    file = std::filesystem::temp_directory_path() /
           fmt::format("pvol-{}-{}{}", getpid(), kind, file.filename().string());
    names += (names.empty() ? "" : " and ") + file.string();
  };
  try {
    rename(other.outputs.exr, ""), rename(other.outputs.png, "");
    rename(other.outputs.deep, "deep-");
    save_pictures(other, job, t);
  } catch (const std::exception&) {
    throw Error(failure.what());
  }
  throw Error(std::string(failure.what()) + " The picture was saved as " + names +
              " instead; move it to its place.");
}

/// Whether no light came to any pixel of a whole picture, with all its samples.
bool is_black(const Film& film, const RenderOptions& o) {
  const bool whole = film.crop_width == film.width && film.crop_height == film.height &&
                     o.part_end == 0 && o.first_sample == 0;
  const auto is_dark = [](const PixelSums& p) { return p.sum == Vec3d{} && p.samples > 0; };
  return whole && std::ranges::all_of(film.pixels, is_dark);
}

}  // namespace

void save(const FrameJob& frame, const RenderJob& job, const TimedRender& t) {
  const RenderOptionsGiven& o = frame.options;
  const Outputs& out = frame.outputs;
  require_unchanged(job.mapped);
  try {
    save_pictures(frame, job, t);
  } catch (const Error& e) {
    save_elsewhere(frame, job, t, e);
  }
  if (out.exr.empty() && describe_bias(job, t) != "no") {
    print_warnings(kRenderTool, {out.png.string() + ": the picture is biased (" +
                                 describe_bias(job, t) + "), which only an .exr can record"});
  }
  if (!o.stats.empty()) write_text(o.stats, stats_text(job, t));
  if (frame.prints_facts && is_black(t.result.film, job.file.scene.options)) {
    print_warnings(kRenderTool, {"the picture is black: no light reaches the camera; check the "
                                 "lights, the sky and what is before the camera"});
  }
  if (o.common.quiet) return;
  if (job.plan.guide.used && !t.result.guided) {
    std::cerr << kRenderTool << ": paths were not guided: only the constant part of the sky "
              << "lights what the camera sees\n";
  }
  std::cerr << kRenderTool << ": " << (job.frame ? job.frame->label + ": " : "")
            << readable_count(t.samples) << " samples in " << readable_seconds(t.wall_seconds)
            << ", " << noise_text(t.result.film);
  if (t.filtered) {
    std::cerr << "; filtered in " << readable_seconds(t.filtered->wall_seconds) << ", "
              << error_text(*t.filtered);
    if (t.filtered->fireflies > 0) {
      std::cerr << ", fireflies in " << readable_count(t.filtered->fireflies) << " pixels spread";
    }
  }
  std::cerr << "; wrote " << out.exr.string() << (out.exr.empty() || out.png.empty() ? "" : " and ")
            << out.png.string() << '\n';
}

}  // namespace pvol::cli
