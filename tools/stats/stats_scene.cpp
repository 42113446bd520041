#include "stats/stats_scene.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <utility>

#include "cli/cli.h"
#include "cli/instructions.h"
#include "cli/load_scene.h"
#include "cli/missing_file.h"
#include "pvol/error.h"
#include "pvol/render/render.h"
#include "pvol/render/scene_volume.h"
#include "pvol/volume/facts.h"

namespace pvol::cli {
namespace {

formats::SceneFile read(const SceneOptions& o) {
  formats::SceneFile file = read_scene(o.input, o.sets);
  if (!o.grid.grid.empty()) file.volumes.front().grid = o.grid.grid;
  return file;
}

void choose_size(const SceneOptions& o, int pixels, LoadedScene& loaded) {
  RenderOptions& r = loaded.file.scene.options;
  loaded.picture_width = r.crop_width > 0 ? r.crop_width : r.width;
  loaded.picture_height = r.crop_height > 0 ? r.crop_height : r.height;
  r.crop_x = r.crop_y = r.crop_width = r.crop_height = 0;
  if (o.size) {
    r.width = (*o.size)[0], r.height = (*o.size)[1];
    return;
  }
  const double scale = std::sqrt(double(pixels) / (double(r.width) * r.height));
  if (scale >= 1) return;
  r.width = std::max(1, int(std::lround(r.width * scale)));
  r.height = std::max(1, int(std::lround(r.height * scale)));
}

void set_extinction(const SceneOptions& o, LoadedScene& loaded) {
  for (std::size_t i = 0; i < loaded.clouds.size(); ++i) {
    formats::SceneVolume& v = loaded.file.volumes[i];
    const bool asked = i == 0 && (o.extinction || o.thickness);
    if (v.has_extinction && !asked) continue;
    if (i == 0) loaded.chose_extinction = !asked;
    const double chosen = chosen_thickness(v);
    const double thickness = i == 0 ? o.thickness.value_or(chosen) : chosen;
    v.medium.extinction =
        i == 0 && o.extinction
            ? *o.extinction
            : choose_extinction(loaded.clouds[i], v.first_place(), thickness, v.density_map);
    v.has_extinction = true;
  }
}

/// The volumes of a scene, each made for its own medium.
std::vector<Volume> make_volumes(const LoadedScene& loaded,
                                 const std::vector<formats::Cloud>& clouds, const Scene& scene) {
  std::vector<Volume> volumes;
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    volumes.push_back(make_volume(clouds[i], loaded.file.volumes[i], scene));
  }
  return volumes;
}

/// Frames the clouds where the scene has no camera; refuses what pvol-render would, and warns as it
/// does.
void choose_camera(LoadedScene& loaded) {
  Scene& scene = loaded.file.scene;
  const std::vector<Volume> volumes = make_volumes(loaded, loaded.clouds, scene);
  if (!loaded.file.has_camera) {
    scene.camera = frame_all(volumes, scene);
    loaded.file.has_camera = true;
    loaded.framed = true;
  }
  loaded.warnings = plan(volumes, scene, {.facts = loaded.facts, .force = loaded.force}).warnings;
}

measure::SetUp set_up_of(const std::vector<Volume>& volumes, double seconds) {
  measure::SetUp s;
  s.seconds = seconds;
  for (const Volume& v : volumes) {
    s.field_bytes += v.density.value_bytes();
    s.octree_bytes += v.density.octree.bytes();
    s.micro_bytes += v.density.squeeze_bytes();
    s.depth = std::max(s.depth, v.density.octree.depth);
  }
  return s;
}

/// The scene that a request asks for. A pilot's picture has a sixteenth of the pixels.
Scene requested(const LoadedScene& loaded, const measure::RunRequest& request, int threads) {
  Scene scene = loaded.file.scene;
  RenderOptions& r = scene.options;
  r.samples = request.samples;
  r.noise.reset(), r.time.reset(), r.aovs = {};  // of the user's picture, not of measurements
  r.seed = request.seed;
  r.count = request.count;
  r.threads = threads;
  if (request.pilot) {
    r.width = std::max(1, r.width / 4);
    r.height = std::max(1, r.height / 4);
  }
  return scene;
}

}  // namespace

LoadedScene load_scene(const SceneOptions& o, int pixels, bool quiet) {
  formats::SceneFile file = read(o);
  const formats::SceneFile as_read = file;
  try {
    LoadedScene loaded = load_scene(std::move(file), o, pixels, [&](formats::SceneVolume& v) {
      return load_cloud({"pvol-stats", quiet}, v, o.grid.strict, as_read);
    });
    print_warnings("pvol-stats", loaded.warnings);
    return loaded;
  } catch (const Error& e) {
    rethrow_with_place(e, o.input, as_read);
  }
}

LoadedScene load_scene(formats::SceneFile file, const SceneOptions& o, int pixels,
                       const LoadCloud& load) {
  LoadedScene loaded;
  loaded.file = std::move(file);
  load_sky("pvol-stats", loaded.file);
  load_surfaces(loaded.file);
  loaded.force = o.force;
  choose_size(o, pixels, loaded);
  for (formats::SceneVolume& v : loaded.file.volumes) {
    loaded.clouds.push_back(load(v));
    if (loaded.clouds.back().pyramid.empty() && !v.fire) {
      throw Error(v.file.string() + ": the density is 0 everywhere; there is nothing to measure");
    }
    if (loaded.file.scene.options.shells != ShellUse::off) {
      require_proof(v.file, loaded.clouds.back());
    }
  }
  set_extinction(o, loaded);
  for (std::size_t i = 0; i < loaded.clouds.size(); ++i) {
    loaded.facts.push_back(describe(loaded.clouds[i], loaded.file.volumes[i]));
  }
  choose_camera(loaded);
  return loaded;
}

measure::Run render_changed(const LoadedScene& loaded, const ChangeScene& change_scene,
                            const ChangeCloud& change_cloud, const measure::RunRequest& request,
                            int threads, const std::function<bool()>& stopped) {
  Scene scene = requested(loaded, request, threads);
  if (change_scene) change_scene(scene);
  std::vector<formats::Cloud> changed;
  if (change_cloud) {
    changed = loaded.clouds;
    for (formats::Cloud& cloud : changed) change_cloud(cloud);
  }
  const double stop = clock_seconds() + request.most_seconds;
  const double begin = cpu_seconds();
  const std::vector<Volume> volumes =
      make_volumes(loaded, change_cloud ? changed : loaded.clouds, scene);
  // Chosen as for the user's picture, of which only a small one is rendered.
  const double paths = double(loaded.picture_width) * loaded.picture_height *
                       expected_samples(loaded.file.scene.options);
  const RenderPlan p =
      plan(volumes, scene,
           {.facts = loaded.facts, .force = loaded.force, .forecast = false, .paths = paths});
  const double ready = cpu_seconds();
  measure::Run run;
  run.set_up = set_up_of(volumes, ready - begin);
  const InstructionCounter instructions;
  RenderResult result =
      render(p, [&](std::uint64_t, std::uint64_t) { return clock_seconds() < stop && !stopped(); });
  run.seconds = cpu_seconds() - ready;
  run.set_up.seconds += result.guide_seconds;
  run.seconds -= result.guide_seconds;
  run.instructions = instructions.read();
  run.film = std::move(result.film);
  run.counts = result.counts;
  run.complete = result.complete;
  return run;
}

double clock_seconds() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now).count();
}

std::string describe(const LoadedScene& loaded) {
  const Scene& scene = loaded.file.scene;
  const VolumeFacts& f = loaded.facts.front();
  const Medium& m = loaded.file.volumes.front().medium;
  const Component& matter = m.components.front();
  return "mean optical thickness " + readable(f.mean_optical_thickness[0]) + ", " +
         readable(f.mean_optical_thickness[1]) + ", " + readable(f.mean_optical_thickness[2]) +
         " along the axes (extinction " + readable(m.extinction) +
         (loaded.chose_extinction ? ", chosen" : "") + "), albedo " +
         readable(double(luminance(matter.albedo))) + ", g " + readable(mean_cosine(matter.phase)) +
         "; " + std::to_string(scene.options.width) + "x" + std::to_string(scene.options.height) +
         " pixels" + (loaded.framed ? ", framed" : "");
}

}  // namespace pvol::cli
