// pvol-render: a scene, or a cloud alone, into a picture.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <fstream>
#include <iostream>
#include <optional>

#include "cli/filter_picture.h"
#include "cli/instructions.h"
#include "cli/load_scene.h"
#include "cli/render_options.h"
#include "cli/render_report.h"
#include "pvol/bounds/homogenise.h"
#include "pvol/bounds/recipe_bounds.h"
#include "pvol/error.h"
#include "pvol/formats/atomic_file.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/image.h"
#include "pvol/formats/recipe_file.h"
#include "pvol/formats/scene_file.h"
#include "pvol/render/scene_volume.h"
#include "pvol/shell/certificate.h"
#include "pvol/volume/facts.h"
#include "report/live_page.h"

namespace {

using namespace pvol;
using cli::RenderJob;
using Options = cli::RenderOptionsGiven;
using cli::TimedRender;

constexpr const char* kTool = "pvol-render";

// --- the scene ----------------------------------------------------------------------------------

void apply(const Options& o, formats::SceneFile& file) {
  if (!o.grid.grid.empty()) file.volumes.front().grid = o.grid.grid;
  cli::apply(o.options, formats::render_keys(file));
  file.scene.options.count = !o.stats.empty();
  file.scene.options.deep = !o.deep.empty();
}

formats::SceneFile read_scene(const Options& o) {
  formats::SceneFile file = cli::read_scene(o.input, o.sets);
  apply(o, file);
  cli::load_sky(file);
  return file;
}

/// Loads a volume, choosing an extinction for its medium where there is none. `key` is what to set
/// for another.
formats::Cloud load_volume(const Options& o, const formats::SceneFile& scene,
                           const std::string& key, formats::SceneVolume& volume) {
  formats::Cloud cloud =
      cli::load_cloud({kTool, o.common.quiet}, volume.file, {volume.grid, o.grid.strict}, scene);
  if (!volume.has_extinction) {
    volume.medium.extinction = cli::choose_extinction(cloud, volume.object_to_world);
    volume.has_extinction = true;
    if (!o.common.quiet) {
      std::cerr << kTool << ": no extinction given; chose "
                << cli::readable(volume.medium.extinction)
                << " per world unit (change it with --set " << key << "=X)\n";
    }
  }
  return cloud;
}

/// Names bounds that do not hold, where trackers with weights make up for them.
void warn_of_bounds(const std::filesystem::path& file, const Volume& volume) {
  const BoundsExcess& e = volume.density.excess;
  if (e.nodes == 0) return;
  cli::print_warnings(
      kTool, {fmt::format("{}: the bounds of {} cubes do not hold, the worst majorant is {} times "
                          "too low, at ({:.0f}, {:.0f}, {:.0f}); the tracker's weights make up for "
                          "it, with more noise. Fit the cloud again",
                          file.string(), e.nodes, cli::readable(e.factor), e.worst.lo.x,
                          e.worst.lo.y, e.worst.lo.z)});
}

RenderJob prepare(const Options& o) {
  RenderJob job;
  job.input = o.input;
  job.sets = o.sets;
  job.file = read_scene(o);
  Scene& scene = job.file.scene;
  for (formats::SceneVolume& v : job.file.volumes) {
    const std::size_t number = job.volumes.size() + 1;
    const std::string key =
        number == 1 ? "medium.extinction" : fmt::format("volume[{}].medium.extinction", number);
    formats::Cloud cloud = load_volume(o, job.file, key, v);
    job.volumes.push_back(cli::naming(v.file, [&] {
      const cli::StageLine stage("preparing " + v.file.filename().string(), o.common.quiet);
      return cli::make_volume(cloud, v, scene.options);
    }));
    warn_of_bounds(v.file, job.volumes.back());
    job.reports.push_back({v.file, cloud.metadata.quantisation, cloud.metadata.quantisation_error});
    job.facts.push_back(describe(job.volumes.back(), cli::describe(cloud, v)));
    if (scene.options.shells != ShellUse::off) cli::require_proof(v.file, cloud);
  }
  if (!job.file.has_camera) {
    scene.camera = cli::frame_all(job.volumes, scene);
    job.file.has_camera = true;
  }
  job.chose_transmittance = scene.options.transmittance == Transmittance::automatic;
  job.plan =
      plan(job.volumes, o.denoise ? cli::with_needs_of_filter(scene) : scene,
           {.facts = job.facts, .force = o.force || o.print_scene, .forecast = !o.print_scene});
  cli::print_warnings(kTool, job.plan.doubts);
  const bool any_shell = std::any_of(job.volumes.begin(), job.volumes.end(),
                                     [](const Volume& v) { return v.shell != nullptr; });
  if (scene.options.shells == ShellUse::on && !any_shell) {
    cli::print_warnings(kTool, {"--shells on: no volume has a shell; fit one with pvol-fit CLOUD "
                                "--shells auto"});
  }
  if (!o.print_scene) scene.options.transmittance = job.plan.scene.options.transmittance;
  return job;
}

/// "  paths guided (--guide auto): ...", for the decision of this name about a volume, or all.
void print_decision(const RenderPlan& plan, const std::string& what, const std::string& told,
                    int volume = -1) {
  for (const Decision& d : plan.decisions) {
    if (d.what == what && d.volume == volume) {
      std::cerr << "  " << what << ' ' << d.choice << told << ": " << d.reason << '\n';
    }
  }
}

void print_density(const Volume& volume, const cli::VolumeReport& report) {
  using cli::readable;
  if (report.density.precision != Precision::fp32) {
    const QuantisationError& e = report.density_error;
    std::cerr << "  density " << name(report.density.precision)
              << (e.absolute == 0 ? ", exact for this cloud\n"
                                  : ", biased: samples are off by up to " + readable(e.absolute) +
                                        ", their sum by " + readable(100 * e.mass) + " %\n");
  }
  if (const auto& h = volume.density.homogeneous) {
    std::cerr << "  homogeneous parts: " << h->nodes << " nodes, "
              << readable(100 * h->volume_share) << " % of the volume and "
              << readable(100 * h->mass_share)
              << " % of the mass; no ray's optical depth changes by more than "
              << readable(h->depth_error) << '\n';
  }
}

void print_facts(const Volume& volume, const VolumeFacts& f) {
  using cli::readable;
  std::cerr << kTool << ": " << volume.name << ": ";
  if (volume.density.world_box.empty()) {
    std::cerr << "the density is 0 everywhere\n";
    return;
  }
  const Vec3d size = volume.density.world_box.extent();
  std::cerr << readable(size.x) << " x " << readable(size.y) << " x " << readable(size.z)
            << " world units\n"
            << "  largest extinction " << readable(f.largest_extinction)
            << " per world unit: shortest free path " << readable(f.shortest_free_path)
            << " world units\n"
            << "  mean optical thickness along the axes " << readable(f.mean_optical_thickness[0])
            << ", " << readable(f.mean_optical_thickness[1]) << ", "
            << readable(f.mean_optical_thickness[2]) << "; octree depth " << f.depth
            << "; micro-bounds: " << cli::micro_bounds_text(volume) << '\n';
}

void print_facts(const RenderJob& job) {
  const RenderOptions& o = job.file.scene.options;
  const auto told = [](const char* flag, const char* value) {
    return fmt::format(" ({} {})", flag, value);
  };
  for (std::size_t i = 0; i < job.volumes.size(); ++i) {
    print_facts(job.volumes[i], job.facts[i]);
    if (job.volumes[i].density.world_box.empty()) continue;
    print_density(job.volumes[i], job.reports[i]);
    print_decision(job.plan, "shell", told("--shells", name(o.shells)), int(i));
  }
  if (std::all_of(job.volumes.begin(), job.volumes.end(),
                  [](const Volume& v) { return v.density.octree.empty(); })) {
    return;
  }
  print_decision(job.plan, "paths", told("--guide", name(o.guide)));
  print_decision(job.plan, "kernel", "");
  if (job.chose_transmittance) print_decision(job.plan, "shadow rays", "");
  const Forecast& f = job.plan.forecast;
  std::cerr << "  roughly " << cli::readable(f.collisions / f.samples)
            << " collisions per sample and " << cli::readable_seconds(f.cpu_seconds)
            << (by_need(o) ? " of CPU time for " + cli::readable(expected_samples(o)) +
                                 " samples a pixel\n"
                           : " of CPU time to expect\n");
  if (by_need(o)) {
    std::cerr << "  samples by need until";
    if (o.noise) std::cerr << " the noise is about " << cli::readable(100 * *o.noise) << " %";
    if (o.noise && o.time) std::cerr << " or";
    if (o.time) std::cerr << " the time is up, " << cli::readable_seconds(*o.time);
    std::cerr << '\n';
  }
}

// --- rendering ----------------------------------------------------------------------------------

void save_png(const Options& o, const std::filesystem::path& file, const RenderJob& job,
              const Film& film) {
  formats::write_png(file, film, o.exposure, !job.file.scene.options.background, o.tone_map);
}

/// Shows the picture so far. A render that is worth hours does not end for a page: whether it went
/// well.
bool show_live(const Options& o, const RenderJob& job, const std::filesystem::path& png,
               const Film& film, report::LivePage& live) {
  try {
    std::uint64_t samples = 0;
    for (const PixelSums& p : film.pixels) samples += p.samples;
    live.show(fmt::format("{:.4g} samples per pixel, {}",
                          double(samples) / double(film.pixels.size()), cli::noise_text(film)),
              [&] { save_png(o, png, job, film); });
    return true;
  } catch (const Error& e) {
    cli::print_warnings(kTool, {std::string(e.what()) + "; rendering goes on without --live"});
    return false;
  }
}

/// "noise 7.2 %, 2.1 % to expect", where the number of samples wanted is known: noise falls with
/// its root.
std::string note(const Film& film, std::uint64_t wanted) {
  double done = 0;
  for (const PixelSums& p : film.pixels) done += p.samples;
  std::string text = cli::noise_text(film);
  const std::optional<double> noise = relative_noise(film);
  if (double(wanted) > done && noise.value_or(0) > 0) {
    text += ", " + cli::readable(100 * *noise * std::sqrt(done / double(wanted))) + " % to expect";
  }
  return text;
}

/// With `live`, shows the picture between passes.
TimedRender render_timed(const Options& o, const RenderJob& job, const std::filesystem::path& png,
                         report::LivePage* live) {
  TimedRender t;
  cli::ProgressBar bar("rendering", "samples", o.common.quiet);
  cli::catch_interrupt();
  cli::Stopwatch watch;
  const double before = cli::cpu_seconds();
  std::atomic<std::uint64_t> wanted = 0;
  const auto progress = [&](std::uint64_t done, std::uint64_t total) {
    bar.show(done, total);
    wanted = total;
    return !cli::interrupted();
  };
  t.result = render(job.plan, progress, [&](const Film& film) {
    bar.note(note(film, wanted));
    if (live && !show_live(o, job, png, film, *live)) live = nullptr;
  });
  t.cpu_seconds = cli::cpu_seconds() - before;
  t.wall_seconds = watch.lap();
  for (const PixelSums& p : t.result.film.pixels) t.samples += p.samples;
  t.samples_wanted = t.result.complete ? t.samples : wanted.load();
  return t;
}

/// Filters the picture. Interrupted renders may have too few samples for that; they are saved as
/// they are.
std::optional<cli::FilteredPicture> filter(const Options& o, const RenderJob& job,
                                           const RenderResult& result) {
  const cli::StageLine stage("filtering", o.common.quiet);
  try {
    return cli::filter_picture(result.film, job.file.scene.options);
  } catch (const Error& e) {
    if (result.complete) throw;
    cli::print_warnings(kTool, {std::string(e.what()) + "; it is saved as it is"});
    return std::nullopt;
  }
}

// --- results ------------------------------------------------------------------------------------

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

/// Before anything is rendered for a file that would then not be written.
void check_layout(const Options& o, const Scene& scene) {
  try {
    formats::validate(exr_options(o, scene));
  } catch (const Error& e) {
    throw cli::UsageError(std::string("--compression and --multipart: ") + e.what());
  }
}

/// Names of the files to write; empty for those that are not wanted.
struct Outputs {
  std::filesystem::path exr, png, deep;
};

void check_deep(const Options& o, const Outputs& out) {
  for (const char* key : {"deep_bins", "deep_error"}) {
    if (!o.deep.empty() || !o.options.contains(key)) continue;
    throw cli::UsageError("--deep-bins and --deep-error go with --deep FILE: the deep picture");
  }
  if (o.deep.empty()) return;
  cli::check_output(o.deep, {".exr"});
  for (const std::filesystem::path& other : {out.exr, out.png}) {
    if (other.empty() || weakly_canonical(other) != weakly_canonical(o.deep)) continue;
    throw cli::UsageError(fmt::format(
        "--deep and the output are the same file, {}; choose another name, such as {}",
        o.deep.string(), std::filesystem::path(o.deep).replace_extension(".deep.exr").string()));
  }
}

Outputs choose_outputs(const Options& o) {
  if (o.output.empty()) throw cli::UsageError("--output is required: the picture to write");
  cli::check_output(o.output, {".exr", ".png"});
  if (o.no_png && !o.png.empty()) throw cli::UsageError("--png and --no-png exclude each other");
  Outputs out;
  if (formats::ending(o.output) == ".png") {
    if (o.no_png || !o.png.empty()) {
      throw cli::UsageError("the output is a .png; --png and --no-png go with an .exr");
    }
    out.png = o.output;
  } else {
    out.exr = o.output;
    if (!o.no_png) {
      out.png = o.png.empty() ? std::filesystem::path(o.output).replace_extension(".png") : o.png;
      cli::check_output(out.png, {".png"});
    }
  }
  out.deep = o.deep;
  check_deep(o, out);
  if (o.live && out.png.empty()) throw cli::UsageError("--live shows the .png; leave out --no-png");
  if (!o.stats.empty() && o.stats != "-") cli::check_output(o.stats, {".json"});
  return out;
}

void warn_of_clamped(const std::filesystem::path& file, std::uint64_t values) {
  if (values == 0) return;
  cli::print_warnings(
      kTool,
      {fmt::format("{}: {} values are beyond 65504, the most that half holds, and were set to "
                   "that; keep them with --pixel-type float",
                   file.string(), values)});
}

void save_deep(const Options& o, const std::filesystem::path& file, const RenderJob& job,
               const TimedRender& t) {
  const Scene& scene = job.file.scene;
  const formats::DeepExrWritten done = formats::write_deep_exr(
      file, t.result.film, cli::describe_picture(job, t),
      {.error = scene.options.deep_error, .pixels = o.pixels, .camera = scene.camera});
  warn_of_clamped(file, done.clamped);
  if (o.common.quiet) return;
  std::cerr << kTool << ": wrote " << file.string() << ", "
            << cli::readable(double(done.samples) / double(t.result.film.pixels.size()))
            << " deep samples a pixel\n";
}

void save_exr(const Options& o, const std::filesystem::path& file, const RenderJob& job,
              const TimedRender& t) {
  warn_of_clamped(file, formats::write_exr(file, t.picture(), cli::describe_picture(job, t),
                                           exr_options(o, job.file.scene)));
}

void save(const Options& o, const Outputs& out, const RenderJob& job, const TimedRender& t) {
  if (!out.exr.empty()) save_exr(o, out.exr, job, t);
  if (!out.png.empty()) save_png(o, out.png, job, t.picture());
  if (!out.deep.empty()) save_deep(o, out.deep, job, t);
  if (out.exr.empty() && cli::describe_bias(job, t) != "no") {
    cli::print_warnings(
        kTool, {out.png.string() + ": the picture is biased (" + cli::describe_bias(job, t) +
                "), which only an .exr can say of itself"});
  }
  if (!o.stats.empty()) write_stats(o.stats, cli::stats_text(job, t));
  if (o.common.quiet) return;
  if (job.plan.guide.used && !t.result.guided) {
    std::cerr << kTool << ": paths were not guided: no light but the constant part of the sky "
              << "reaches what the camera sees\n";
  }
  std::cerr << kTool << ": " << cli::readable_count(t.samples) << " samples in "
            << cli::readable_seconds(t.wall_seconds) << ", " << cli::noise_text(t.result.film);
  if (t.filtered) {
    std::cerr << "; filtered in " << cli::readable_seconds(t.filtered->wall_seconds)
              << ", estimated error " << cli::readable(100 * t.filtered->relative_error) << " %";
  }
  std::cerr << "; wrote " << out.exr.string() << (out.exr.empty() || out.png.empty() ? "" : " and ")
            << out.png.string() << '\n';
}

void end_live(report::LivePage& live, const TimedRender& t) {
  try {
    live.end(fmt::format("{}: {} samples in {}", t.result.complete ? "done" : "interrupted",
                         cli::readable_count(t.samples), cli::readable_seconds(t.wall_seconds)));
  } catch (const Error& e) {  // the picture is saved
    cli::print_warnings(kTool, {e.what()});
  }
}

int run(const Options& o) {
  const Outputs out = o.print_scene ? Outputs{} : choose_outputs(o);
  const RenderJob job = prepare(o);
  if (o.print_scene) {
    std::cout << formats::to_toml(job.file);
    return cli::kSuccess;
  }
  if (!out.exr.empty()) check_layout(o, job.file.scene);
  if (!o.common.quiet) print_facts(job);
  std::optional<report::LivePage> live;
  if (o.live) live.emplace(out.png);
  TimedRender t = render_timed(o, job, out.png, live ? &*live : nullptr);
  if (t.samples == 0) throw Error("interrupted before the first sample; nothing is saved");
  if (o.denoise) t.filtered = filter(o, job, t.result);
  save(o, out, job, t);
  if (live) end_live(*live, t);
  if (t.result.complete) return cli::kSuccess;
  throw Error("interrupted after " + cli::progress_text(t) +
              " samples; what was rendered is saved");
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  if (const auto code = cli::read_command_line(argc, argv, options)) return *code;
  return cli::run_guarded(kTool, [&] { return run(options); });
}
