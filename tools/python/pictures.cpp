#include "python/pictures.h"

#include <atomic>
#include <utility>

#include "cli/cli.h"
#include "cli/film_samples.h"
#include "cli/filter_picture.h"
#include "cli/load_scene.h"
#include "cli/picture_facts.h"
#include "cli/render_report.h"
#include "pvol/error.h"
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

std::string text_of(const RenderPlan& plan) {
  std::string text;
  for (const Decision& d : plan.decisions) {
    text += (d.volume < 0 ? "" : "volume " + std::to_string(d.volume + 1) + ", ") + d.what + ": " +
            d.choice + (d.reason.empty() ? "" : " (" + d.reason + ")") + '\n';
  }
  return text;
}

/// A picture of the job, filtered where `t` is.
Picture describe(const cli::RenderJob& job, cli::TimedRender t) {
  const Scene& scene = job.file.scene;
  Picture picture;
  picture.plan = text_of(job.plan);
  picture.warnings = job.plan.warnings;
  picture.counts = t.result.counts;
  picture.counted = scene.options.count || counted(scene.options.aovs);
  picture.figures = cli::figures_of_renders(picture.counted);
  picture.layout = cli::exr_options({.filtered = t.filtered.has_value()}, scene);
  t.samples = cli::count_samples(t.film());
  picture.attributes = cli::describe_picture(job, t);
  picture.attributes.erase("pvol:key");  // of what is merged, which these are not
  picture.film = t.filtered ? std::move(t.filtered->film) : std::move(t.result.film);
  picture.film.remainders = {};
  return picture;
}

/// A film while samples are added to it.
cli::TimedRender so_far(const Film& film, std::uint64_t wanted) {
  cli::TimedRender t;
  t.result.film = cli::without_sums(film);
  t.result.complete = false;
  t.samples_wanted = wanted;
  return t;
}

/// Filters the picture where all of its pixels have the two samples that it takes.
void filter(const cli::RenderJob& job, const Stop& stop, cli::TimedRender& t) {
  if (cli::least_samples(t.result.film) < 2) return;
  t.filtered =
      cli::filter_picture(t.result.film, job.file.scene.options, [&] { return stop.load(); });
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

cli::GivenClouds place_volumes(const SceneRequest& request, formats::SceneFile& file) {
  cli::GivenClouds clouds;
  for (std::size_t i = 0; i < request.in_memory.size(); ++i) {
    const CloudVolume* const given = request.in_memory[i].get();
    clouds.push_back(given ? given->cloud : nullptr);
    if (!given) continue;
    formats::SceneVolume& v = file.volumes[i];
    const std::vector<Affine> instances = std::move(v.instances);
    v = given->given;
    v.instances = instances;
  }
  return clouds;
}

Picture render_request(const SceneRequest& request, const OnPass& on_pass, const Stop& stop) {
  formats::SceneFile file = read_request(request);
  file.scene.options.count = request.count;
  const cli::GivenClouds clouds = place_volumes(request, file);
  cli::RenderJob job = cli::LiveScene({"pvol", true}).prepare(std::move(file), clouds);
  job.input = request.file;
  job.sets = sets_of(request.settings);
  job.denoise = request.denoise;
  if (stop) return {};
  Scene& scene = job.file.scene;
  job.chose_transmittance = scene.options.transmittance == Transmittance::automatic;
  job.plan = plan(job.volumes, request.denoise ? cli::with_needs_of_filter(scene) : scene,
                  {.facts = job.facts, .force = request.force});
  scene.options.transmittance = job.plan.scene.options.transmittance;
  std::atomic<std::uint64_t> wanted = 0;
  std::atomic<bool> goes_on = true;
  const auto progress = [&](std::uint64_t, std::uint64_t total) {
    wanted = total;
    return goes_on && !stop;
  };
  const auto pass_done = [&](const Film& film) {
    std::optional<double> share;
    if (wanted > 0) share = double(cli::count_samples(film)) / double(wanted);
    goes_on = on_pass(describe(job, so_far(film, wanted)), share);
  };
  cli::TimedRender t;
  t.result = render(job.plan, progress, on_pass ? PassDone(pass_done) : PassDone());
  t.samples_wanted = t.result.goal;
  if (stop) return {};
  if (request.denoise) filter(job, stop, t);
  return describe(job, std::move(t));
}

std::optional<Picture> picture_of(const cli::LiveState& state) {
  if (!state.film) return std::nullopt;
  if (!state.job) {  // a coarse one
    Picture coarse;
    coarse.film = *state.film;
    return coarse;
  }
  cli::TimedRender t = so_far(*state.film, state.samples_wanted);
  if (state.filtered) t.filtered = *state.filtered;
  return describe(*state.job, std::move(t));
}

void save(const Picture& picture, const std::filesystem::path& file,
          const formats::Display& display) {
  cli::check_output(file, {".exr", ".png"});
  if (formats::ending(file) == ".png") {
    formats::write_png(file, picture.film, display, !picture.layout.opaque);
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
  picture.figures = stored.figures;
  picture.attributes = std::move(stored.attributes);
  return picture;
}

std::vector<std::string> layer_names(const Picture& picture) {
  return cli::layer_names(picture.film, picture.figures);
}

cli::Plane layer_of(const Picture& picture, const std::string& name) {
  return cli::layer_of(picture.film, picture.figures, name);
}

}  // namespace pvol::python
