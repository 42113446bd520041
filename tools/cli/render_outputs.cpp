#include "cli/render_outputs.h"

#include <fmt/format.h>

#include <fstream>
#include <iostream>

#include "cli/cli.h"
#include "pvol/error.h"
#include "pvol/formats/atomic_file.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/image.h"

namespace pvol::cli {
namespace {

constexpr const char* kTool = "pvol-render";
using Options = RenderOptionsGiven;

void write_stats(const std::filesystem::path& file, const std::string& text) {
  if (file == "-") {
    std::cout << text;
    return;
  }
  formats::write_atomically(file, [&](const std::filesystem::path& aside) {
    std::ofstream out(aside, std::ios::binary);
    out << text;
    if (!out.flush()) throw Error(file.string() + ": cannot be written; is the disk full?");
  });
}

formats::ExrOptions exr_options(const Options& o, const Scene& scene) {
  // What a filter made says how much it errs.
  AovSet aovs = scene.options.aovs;
  if (o.denoise) aovs.add(Aov::variance), aovs.add(Aov::samples);
  return {.aovs = aovs,
          .opaque = scene.options.background,
          .multipart = o.multipart,
          .pixels = o.pixels,
          .compression = o.compression,
          .camera = scene.camera};
}

void check_deep(const Options& o, const Outputs& out) {
  for (const char* key : {"deep_bins", "deep_error"}) {
    if (!o.deep.empty() || !o.options.contains(key)) continue;
    throw UsageError("--deep-bins and --deep-error go with --deep FILE: the deep picture");
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

void warn_of_clamped(const std::filesystem::path& file, std::uint64_t values) {
  if (values == 0) return;
  print_warnings(
      kTool,
      {fmt::format("{}: {} values are beyond 65504, the most that half holds, and were set to "
                   "that; keep them with --pixel-type float",
                   file.string(), values)});
}

void save_deep(const Options& o, const std::filesystem::path& file, const RenderJob& job,
               const TimedRender& t) {
  const Scene& scene = job.file.scene;
  const formats::DeepExrWritten done = formats::write_deep_exr(
      file, t.result.film, describe_picture(job, t),
      {.error = scene.options.deep_error, .pixels = o.pixels, .camera = scene.camera});
  warn_of_clamped(file, done.clamped);
  if (o.common.quiet) return;
  std::cerr << kTool << ": wrote " << file.string() << ", "
            << readable(double(done.samples) / double(t.result.film.pixels.size()))
            << " deep samples a pixel\n";
}

void save_exr(const Options& o, const std::filesystem::path& file, const RenderJob& job,
              const TimedRender& t) {
  warn_of_clamped(file, formats::write_exr(file, t.picture(), describe_picture(job, t),
                                           exr_options(o, job.file.scene)));
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
      throw UsageError("the output is a .png; --png and --no-png go with an .exr");
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
  if (o.live && out.png.empty()) throw UsageError("--live shows the .png; leave out --no-png");
  if (!o.stats.empty() && o.stats != "-") check_output(o.stats, {".json"});
  return out;
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

void save(const Options& o, const Outputs& out, const RenderJob& job, const TimedRender& t) {
  if (!out.exr.empty()) save_exr(o, out.exr, job, t);
  if (!out.png.empty()) save_png(o, out.png, job, t.picture());
  if (!out.deep.empty()) save_deep(o, out.deep, job, t);
  if (out.exr.empty() && describe_bias(job, t) != "no") {
    print_warnings(kTool, {out.png.string() + ": the picture is biased (" + describe_bias(job, t) +
                           "), which only an .exr can say of itself"});
  }
  if (!o.stats.empty()) write_stats(o.stats, stats_text(job, t));
  if (o.common.quiet) return;
  if (job.plan.guide.used && !t.result.guided) {
    std::cerr << kTool << ": paths were not guided: no light but the constant part of the sky "
              << "reaches what the camera sees\n";
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
