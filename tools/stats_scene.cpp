#include "stats_scene.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>

#include "cli.h"
#include "instructions.h"
#include "pvol/error.h"
#include "pvol/formats/image.h"
#include "pvol/formats/recipe_file.h"
#include "pvol/render/render.h"
#include "pvol/render/shell_choice.h"
#include "pvol/render/trade.h"

namespace pvol::cli {
namespace {

/// The extinction of three digits with which the cloud is this many mean free paths thick, averaged
/// over the columns along its thickest axis.
double extinction_for(const formats::Cloud& cloud, Medium medium, double thickness) {
  medium.extinction = 1;
  const VolumeFacts f = describe(Volume{}, cloud.grid, medium);
  const double unit =
      *std::max_element(std::begin(f.mean_optical_thickness), std::end(f.mean_optical_thickness));
  if (!(unit > 0)) return 1;
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.3g", thickness / unit);
  constexpr double kLargest = 3e38;  // fits a float, for clouds of denormal densities
  return std::min(std::stod(digits), kLargest);
}

formats::SceneFile read(const SceneOptions& o) {
  const bool is_scene = formats::ending(o.input) == ".toml" && !formats::is_recipe(o.input);
  formats::SceneFile file =
      is_scene ? formats::read_scene(o.input, o.sets) : formats::default_scene(o.input, o.sets);
  if (!o.grid.grid.empty()) file.grid = o.grid.grid;
  if (file.sky.empty()) return file;
  ImageSky picture = formats::read_sky(file.sky);
  const auto& wanted = std::get<ImageSky>(file.scene.environment);
  picture.scale = wanted.scale;
  picture.rotation = wanted.rotation;
  file.scene.environment = std::move(picture);
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
  constexpr double kThickness = 40;  // as pvol-render chooses it
  Medium& medium = loaded.file.scene.medium;
  if (o.extinction) {
    medium.extinction = *o.extinction;
  } else if (o.thickness || !loaded.file.has_extinction) {
    loaded.chose_extinction = !o.thickness;
    medium.extinction =
        extinction_for(loaded.clouds.front(), medium, o.thickness.value_or(kThickness));
  }
  loaded.file.has_extinction = true;
  for (std::size_t i = 0; i < loaded.file.others.size(); ++i) {
    formats::FurtherVolume& other = loaded.file.others[i];
    if (other.has_extinction) continue;
    other.medium.extinction = extinction_for(loaded.clouds[i + 1], other.medium, kThickness);
    other.has_extinction = true;
  }
}

/// Refuses what a render would not end with in reasonable time.
void refuse_endless(double events, const std::string& what, const std::string& remedy) {
  constexpr double kMost = 1e6;  // as pvol-render has it
  if (events > kMost) {
    throw Error(what + " about " + readable(events) + " times, expected at most " +
                readable(kMost) + "; " + remedy);
  }
}

void refuse_endless_paths(const LoadedScene& loaded) {
  const Scene& scene = loaded.file.scene;
  if (scene.options.max_bounces) return;
  double albedo = double(max_component(scene.medium.albedo));
  for (const Component& c : scene.medium.others) {
    albedo = std::max(albedo, double(max_component(c.albedo)));
  }
  refuse_endless(estimate_scatterings(loaded.facts.largest_optical_thickness, albedo),
                 loaded.file.volume.string() + ": a path would scatter",
                 "lower the extinction, or limit paths with --set render.max_bounces=N");
}

/// Null collisions in the thin part of the worst segment.
double null_collisions(const Volume& v) {
  const double cell_length = std::cbrt(1 / std::abs(determinant(v.world_to_cells)));
  double most = 0;
  for (const Octree::Entry& e : v.octree.entries) {
    if (e.log2 > 0) most = std::max(most, double(e.hi - e.lo) * std::ldexp(cell_length, e.log2));
  }
  return most;
}

/// The volumes of a scene, each made for its own medium.
std::vector<Volume> make_volumes(const LoadedScene& loaded,
                                 const std::vector<formats::Cloud>& clouds, const Scene& scene) {
  std::vector<Volume> volumes;
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    Scene own = scene;
    if (i > 0) own.medium = loaded.file.others[i - 1].medium;
    volumes.push_back(make_volume(clouds[i].grid, clouds[i].pyramid, own));
    refuse_endless(null_collisions(volumes.back()), "a ray would meet null collisions",
                   "lower the extinction");
    if (clouds[i].shell) (void)choose_shell(volumes.back(), *clouds[i].shell, scene);
  }
  return volumes;
}

void frame_all(LoadedScene& loaded) {
  Scene& scene = loaded.file.scene;
  if (loaded.file.has_camera) return;
  Box all;
  for (const Volume& v : make_volumes(loaded, loaded.clouds, scene)) {
    if (!v.world_box.empty()) all = extend(extend(all, v.world_box.lo), v.world_box.hi);
  }
  scene.camera = frame(all, double(scene.options.width) / scene.options.height);
  loaded.file.has_camera = true;
  loaded.framed = true;
}

SetUp set_up_of(const std::vector<Volume>& volumes, double seconds) {
  SetUp s;
  s.seconds = seconds;
  for (const Volume& v : volumes) {
    s.field_bytes += v.field.samples.size() * sizeof(float);
    s.octree_bytes += v.octree.nodes.size() * sizeof(Octree::Node) +
                      v.octree.entries.size() * sizeof(Octree::Entry);
    s.micro_bytes += v.micro.bytes();
    s.depth = std::max(s.depth, v.octree.depth);
  }
  return s;
}

/// The scene that a request asks for. A pilot's picture has a sixteenth of the pixels.
Scene requested(const LoadedScene& loaded, const RunRequest& request, int threads) {
  Scene scene = loaded.file.scene;
  RenderOptions& r = scene.options;
  r.samples = request.samples;
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

LoadedScene load_scene(const SceneOptions& o, int pixels) {
  LoadedScene loaded;
  loaded.file = read(o);
  choose_size(o, pixels, loaded);
  const auto add = [&](const std::filesystem::path& file, const std::string& grid) {
    loaded.clouds.push_back(formats::load_cloud(file, {grid, o.grid.strict}));
    print_warnings("pvol-stats", loaded.clouds.back().report.warnings);
    if (loaded.clouds.back().pyramid.empty()) {
      throw Error(file.string() + ": the density is 0 everywhere; there is nothing to measure");
    }
  };
  add(loaded.file.volume, loaded.file.grid);
  for (const formats::FurtherVolume& v : loaded.file.others) add(v.file, v.grid);
  set_extinction(o, loaded);
  loaded.facts = describe(Volume{}, loaded.clouds.front().grid, loaded.file.scene.medium);
  refuse_endless_paths(loaded);
  frame_all(loaded);
  return loaded;
}

Run render_changed(const LoadedScene& loaded, const ChangeScene& change_scene,
                   const ChangeCloud& change_cloud, const RunRequest& request, int threads) {
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
  const double ready = cpu_seconds();
  Run run;
  run.set_up = set_up_of(volumes, ready - begin);
  const InstructionCounter instructions;
  RenderResult result =
      render(volumes, scene, [&](std::uint64_t, std::uint64_t) { return clock_seconds() < stop; });
  run.seconds = cpu_seconds() - ready;
  run.instructions = instructions.read();
  run.film = std::move(result.film);
  run.counts = result.counts;
  run.complete = result.complete;
  return run;
}

Film render_reference(const LoadedScene& loaded, double seconds, std::uint64_t seed, int threads) {
  const double end = clock_seconds() + seconds;
  RunRequest request{.samples = 2, .seed = seed, .most_seconds = seconds};
  Film sum;
  for (;;) {
    const double begin = clock_seconds();
    const Run run = render_changed(loaded, {}, {}, request, threads);
    if (!run.complete) {
      throw Error("the budget is too short: two samples a pixel for the reference take more than " +
                  readable_seconds(seconds) + "; raise --budget or lower --size");
    }
    if (sum.pixels.empty()) {
      sum = run.film;
    } else {
      add_samples(sum, run.film);
    }
    // Growing chunks, so that setting up takes little of the time whatever a sample costs.
    const double took = clock_seconds() - begin, left = end - clock_seconds();
    const double grown = std::min(4.0, 0.8 * left / took) * request.samples;
    if (grown < 1 || left < 0.1 * seconds || interrupted()) return sum;
    request.samples = std::uint32_t(std::min(grown, 65536.0));
    ++request.seed;
    request.most_seconds = std::numeric_limits<double>::infinity();
  }
}

double clock_seconds() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now).count();
}

std::string describe(const LoadedScene& loaded) {
  const Scene& scene = loaded.file.scene;
  const VolumeFacts& f = loaded.facts;
  const Medium& m = scene.medium;
  return "mean optical thickness " + readable(f.mean_optical_thickness[0]) + ", " +
         readable(f.mean_optical_thickness[1]) + ", " + readable(f.mean_optical_thickness[2]) +
         " along the axes (extinction " + readable(m.extinction) +
         (loaded.chose_extinction ? ", chosen" : "") + "), albedo " +
         readable(double(luminance(m.albedo))) + ", g " + readable(m.g) + "; " +
         std::to_string(scene.options.width) + "x" + std::to_string(scene.options.height) +
         " pixels" + (loaded.framed ? ", framed" : "");
}

}  // namespace pvol::cli
