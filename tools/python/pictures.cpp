#include "python/pictures.h"

#include <algorithm>
#include <limits>
#include <string_view>
#include <utility>

#include "cli/cli.h"
#include "cli/load_scene.h"
#include "cli/picture_facts.h"
#include "cli/render_report.h"
#include "cli/scene_clouds.h"
#include "pvol/error.h"
#include "pvol/render/film_channels.h"
#include "pvol/render/render.h"

namespace pvol::python {
namespace {

constexpr const char* kRender = "render.";

/// Words as a command line has them: without quotes.
std::string bare(const std::string& toml) {
  const bool is_quoted = toml.size() >= 2 && toml.front() == '"';
  return is_quoted ? toml.substr(1, toml.size() - 2) : toml;
}

/// Takes those out that no scene has, such as the number of threads, and sets them.
void set_loose(Words loose, formats::SceneFile& file) {
  for (const Entry& e : formats::render_keys(file)) {
    const auto found = loose.find(kRender + std::string(e.about.key));
    if (e.about.in_scenes || found == loose.end()) continue;
    const std::string text = bare(found->second);
    if (const auto refusal = e.set(parse_value(e.about.limits, text))) {
      throw Error(std::string(e.about.key) + ": found '" + text + "', expected " +
                  command_expected(e.about.limits, *refusal));
    }
  }
}

bool is_loose(const std::string& name) {
  formats::SceneFile any;
  for (const Entry& e : formats::render_keys(any)) {
    if (!e.about.in_scenes && name == kRender + std::string(e.about.key)) return true;
  }
  return false;
}

/// Makes a volume of a scene ready, loading it where it is not in memory.
void add_volume(const CloudVolume* in_memory, cli::SceneClouds& clouds, formats::SceneVolume& v,
                cli::RenderJob& job) {
  std::shared_ptr<const formats::Cloud> cloud;
  if (in_memory) {
    const std::vector<Affine> instances = v.instances;
    v = in_memory->given;
    v.instances = instances;
    cloud = in_memory->cloud;
  } else {
    cloud = clouds.load(v);
    if (!v.has_extinction && !cloud->pyramid.empty()) {
      v.medium.extinction =
          cli::choose_extinction(*cloud, v.first_place(), cli::chosen_thickness(v), v.density_map);
      v.has_extinction = true;
    }
  }
  const Scene& scene = job.file.scene;
  job.volumes.push_back(cli::naming(v.file, [&] { return cli::make_volume(*cloud, v, scene); }));
  job.reports.push_back({v.file, cloud->metadata.quantisation, cloud->metadata.quantisation_error});
  job.facts.push_back(describe(job.volumes.back(), cli::describe(*cloud, v)));
  if (scene.options.shells != ShellUse::off) cli::require_proof(v.file, *cloud);
}

cli::RenderJob load(const SceneRequest& request) {
  cli::RenderJob job;
  job.input = request.file;
  job.sets = sets_of(request.settings);
  job.file = read_request(request);
  job.file.scene.options.count = request.count;
  cli::load_sky(job.file);
  cli::load_surfaces(job.file);
  cli::SceneClouds clouds({"pvol", true}, false, job.file);
  for (std::size_t i = 0; i < job.file.volumes.size(); ++i) {
    const bool known = i < request.in_memory.size();
    add_volume(known ? request.in_memory[i].get() : nullptr, clouds, job.file.volumes[i], job);
  }
  if (!job.file.has_camera) {
    job.file.scene.camera = cli::frame_all(job.volumes, job.file.scene);
    job.file.has_camera = true;
  }
  return job;
}

std::string text_of(const RenderPlan& plan) {
  std::string text;
  for (const Decision& d : plan.decisions) {
    text += (d.volume < 0 ? "" : "volume " + std::to_string(d.volume + 1) + ", ") + d.what + ": " +
            d.choice + (d.reason.empty() ? "" : " (" + d.reason + ")") + '\n';
  }
  return text;
}

void describe(const cli::RenderJob& job, RenderResult result, Picture& picture) {
  cli::TimedRender t;
  for (const PixelSums& p : result.film.pixels) t.samples += p.samples;
  t.samples_wanted = result.goal;
  t.result = std::move(result);
  picture.attributes = cli::describe_picture(job, t);
  picture.attributes.erase("pvol:key");  // of what is merged, which these are not
  picture.film = std::move(t.result.film);
  picture.film.sums = {};
}

bool has_row(const FilmChannel& c, const std::string& name) {
  return c.aov && row(*c.aov).name == name;
}

}  // namespace

formats::SceneFile read_request(const SceneRequest& request) {
  Words settings = request.settings, loose;
  for (const auto& [name, text] : request.settings) {
    if (is_loose(name)) loose.insert(settings.extract(name));
  }
  for (const auto& v : request.in_memory) {
    if (v) settings.insert(v->making.begin(), v->making.end());  // those given before hold
  }
  formats::SceneFile file = request.file.empty()
                                ? formats::parse_scene(request.text, "scene", sets_of(settings))
                                : cli::read_scene(request.file, sets_of(settings));
  set_loose(std::move(loose), file);
  return file;
}

Picture render_request(const SceneRequest& request, const Stop& stop) {
  cli::RenderJob job = load(request);
  if (stop) return {};
  Scene& scene = job.file.scene;
  job.chose_transmittance = scene.options.transmittance == Transmittance::automatic;
  job.plan = plan(job.volumes, scene, {.facts = job.facts, .force = request.force});
  scene.options.transmittance = job.plan.scene.options.transmittance;
  Picture picture;
  picture.plan = text_of(job.plan);
  picture.warnings = job.plan.warnings;
  RenderResult result =
      render(job.plan, [&](std::uint64_t, std::uint64_t) { return !stop.load(); });
  picture.counts = result.counts;
  picture.counted = request.count || counted(scene.options.aovs);
  picture.layout = cli::exr_options({}, scene);
  describe(job, std::move(result), picture);
  return picture;
}

void save(const Picture& picture, const std::filesystem::path& file, double exposure,
          formats::ToneMap map) {
  cli::check_output(file, {".exr", ".png"});
  if (formats::ending(file) == ".png") {
    formats::write_png(file, picture.film, exposure, !picture.layout.opaque, map);
    return;
  }
  formats::ExrOptions layout = picture.layout;
  layout.aovs.add(Aov::variance), layout.aovs.add(Aov::samples);
  (void)formats::write_exr(file, picture.film, picture.attributes, layout);
}

Picture read_picture(const std::filesystem::path& file) {
  formats::StoredFilm stored = formats::read_film(file);
  Picture picture;
  picture.film = std::move(stored.film);
  picture.attributes = std::move(stored.attributes);
  return picture;
}

std::vector<std::string> layer_names(const Picture& picture) {
  std::vector<std::string> names;
  for (const FilmChannel& c : kFilmChannels) {
    if (!c.aov || (row(*c.aov).counted && !picture.counted)) continue;
    if (names.empty() || names.back() != row(*c.aov).name) names.emplace_back(row(*c.aov).name);
  }
  for (const Layer& layer : picture.film.layers) names.push_back(layer.name);
  return names;
}

Plane layer_of(const Picture& picture, const std::string& name) {
  const Film& film = picture.film;
  const std::vector<std::string> known = layer_names(picture);
  if (std::ranges::find(known, name) == known.end()) {
    throw Error("the picture has no layer '" + name + "'; it has " + listed(known) +
                ". Request others with aov=[...]");
  }
  Plane plane;
  for (const Layer& layer : film.layers) {
    if (layer.name != name) continue;
    plane.components = int(layer.components.size());
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      const Vec3d v = value(layer, film, i);
      for (int k = 0; k < plane.components; ++k) plane.values.push_back(float(v[k]));
    }
    return plane;
  }
  std::vector<const FilmChannel*> channels;
  for (const FilmChannel& c : kFilmChannels) {
    if (has_row(c, name)) channels.push_back(&c);
  }
  plane.components = int(channels.size());
  for (const PixelSums& p : film.pixels) {
    for (const FilmChannel* c : channels) plane.values.push_back(float(c->get(p)));
  }
  return plane;
}

}  // namespace pvol::python
