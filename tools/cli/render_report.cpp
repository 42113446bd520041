#include "cli/render_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "cli/cli.h"
#include "cli/picture_facts.h"
#include "pvol/bounds/homogenise.h"
#include "pvol/version.h"
#include "pvol/volume/facts.h"

namespace pvol::cli {
namespace {

/// The precision of a volume's density and, unless that is exact, how far samples are off.
Json describe_density(const VolumeReport& v) {
  Json j;
  j["precision"] = name(v.density.precision);
  if (v.density.precision == Precision::fp32) return j;
  if (v.density.precision == Precision::fpn) j["tolerance"] = v.density.tolerance;
  j["absolute_error"] = v.density_error.absolute;
  j["relative_error"] = v.density_error.relative;
  j["mass_error"] = v.density_error.mass;
  return j;
}

/// What was made of each volume; the options above it hold for the first.
Json describe_volumes(const RenderJob& job) {
  Json list = Json::array();
  for (std::size_t i = 0; i < job.volumes.size(); ++i) {
    const Volume& v = job.volumes[i];
    Json one = {{"file", job.reports[i].file.string()},
                {"extinction", v.medium.extinction},
                {"effective_depth", job.facts[i].depth},
                {"micro_bounds", micro_bounds_text(v)},
                {"shell_used", job.plan.shells[i].kept}};
    if (count_places(v) > 1) one["instances"] = count_places(v);
    if (v.density.homogeneous) {
      one["homogenised_nodes"] = v.density.homogeneous->nodes;
      one["depth_error_bound"] = v.density.homogeneous->depth_error;
    }
    list.push_back(std::move(one));
  }
  return list;
}

/// What was made of the options for the first volume, and of the density for each.
void describe_choices(const RenderJob& job, const TimedRender& t, Json& j) {
  const Volume& first = job.volumes.front();
  j["kernel_used"] = name(job.plan.kernel.kind);
  j["micro_bounds_from"] = micro_bounds_text(first);
  for (const VolumeReport& v : job.reports) j["density"].push_back(describe_density(v));
  j["effective_depth"] = job.facts.front().depth;
  j["shell_used"] = job.plan.shells.front().kept;
  if (const auto& h = first.density.homogeneous) {
    j["homogenised"] = {{"nodes", h->nodes},
                        {"volume_share", h->volume_share},
                        {"mass_share", h->mass_share},
                        {"depth_error_bound", h->depth_error}};
  }
  j["volumes"] = describe_volumes(job);
  j["biased"] = describe_bias(job, t);
  j["denoised"] = t.filtered ? "on" : "off";
  j["extinction"] = first.medium.extinction;
}

/// Every option that bears on the picture, by its key; not the number of threads, on which no byte
/// of a picture depends.
Json describe_options(const RenderJob& job, const TimedRender& t) {
  Json j;
  j["input"] = job.input.string();
  if (job.frame) j["frame"] = job.frame->number;
  if (job.frame && job.frame->locked_to) j["lock_frame"] = *job.frame->locked_to;
  j["volume"] = job.file.volumes.front().file.string();
  j["grid"] = job.file.volumes.front().grid;
  for (const Entry& e : entries(job.file.scene.options)) {
    if (e.about.in_scenes) j[e.about.key] = to_json(e.value());
  }
  describe_choices(job, t, j);
  j["set"] = job.sets;
  j["version"] = PVOL_VERSION;
  return j;
}

}  // namespace

std::string describe_bias(const RenderJob& job, const TimedRender& t) {
  std::vector<std::string> reasons;
  const bool homogenised = std::any_of(job.volumes.begin(), job.volumes.end(), [](const Volume& v) {
    return v.density.homogeneous && v.density.homogeneous->nodes > 0;
  });
  const RenderOptions unbiased;
  const Entries defaults = entries(unbiased);
  for (const Entry& e : entries(job.file.scene.options)) {
    const std::string key = e.about.key;
    if (e.about.effect != Effect::bias || e.value() == find_key(defaults, key)->value()) continue;
    if (key != "homogenise" || homogenised) reasons.push_back(key);
  }
  for (const VolumeReport& v : job.reports) {
    if (v.density_error.absolute == 0) continue;  // exact, in whatever precision
    const std::string reason = fmt::format("density {}", name(v.density.precision));
    if (std::find(reasons.begin(), reasons.end(), reason) == reasons.end()) {
      reasons.push_back(reason);
    }
  }
  if (t.filtered) reasons.emplace_back("denoised");
  return reasons.empty() ? "no" : fmt::format("yes: {}", fmt::join(reasons, ", "));
}

std::string micro_bounds_text(const Volume& volume) {
  if (volume.density.codes) return "codes";
  if (volume.density.micro.edge == 0) return "none";
  if (volume.density.micro.edge == 1) return "single voxels, built at load";
  return volume.density.micro_stored ? "2^3 from the file" : "2^3 built at load";
}

std::string progress_text(const TimedRender& t) {
  return progress_text(t.samples, t.samples_wanted);
}

std::map<std::string, std::string> describe_picture(const RenderJob& job, const TimedRender& t) {
  std::map<std::string, std::string> a;
  const Json options = describe_options(job, t);
  for (const auto& [key, value] : options.items()) {
    a["pvol:" + key] = value.is_string() ? value.get<std::string>() : value.dump();
  }
  a["pvol:scene"] = formats::to_toml(job.file);
  a["pvol:key"] = job.key;
  if (job.denoise && !t.filtered) a[kWishForFilter] = "on";
  const std::string part = part_text(job.file.scene.options);
  if (!part.empty()) a["pvol:part"] = part;
  describe_film(t.film(), t.samples, t.samples_wanted, t.filtered, a);
  return a;
}

std::string stats_text(const RenderJob& job, const TimedRender& t) {
  Vec3d mean_rgb, variance_rgb;
  for (const PixelSums& p : t.result.film.pixels) {
    mean_rgb += mean(p);
    variance_rgb += variance_of_mean(p);
  }
  const double pixels = double(t.result.film.pixels.size());
  mean_rgb = mean_rgb / pixels;
  variance_rgb = variance_rgb / pixels;
  Json j;
  j["samples"] = t.samples;
  j["cpu_seconds"] = t.cpu_seconds;
  j["wall_seconds"] = t.wall_seconds;
  j["forecast"] = {{"cpu_seconds", t.forecast.cpu_seconds()},
                   {"guide_seconds", t.forecast.guide_seconds},
                   {"samples", t.forecast.samples},
                   {"own_cpu_seconds", t.forecast.own_seconds}};
  for (const Counter& counter : kCounters) j[counter.name] = value(counter, t.result.counts);
  j["mean_rgb"] = {mean_rgb.x, mean_rgb.y, mean_rgb.z};
  j["variance_rgb"] = {variance_rgb.x, variance_rgb.y, variance_rgb.z};
  const std::optional<double> noise = relative_noise(t.result.film);
  j["relative_noise"] = noise ? Json(*noise) : Json();
  const std::optional<double> of_pixels = pixel_noise(t.result.film);
  j["pixel_noise"] = of_pixels ? Json(*of_pixels) : Json();
  if (t.filtered) {
    j["denoised"] = {{"estimated_error", t.filtered->relative_error},
                     {"estimated_error_deviation", t.filtered->relative_error_deviation},
                     {"fireflies", t.filtered->fireflies},
                     {"cpu_seconds", t.filtered->cpu_seconds},
                     {"wall_seconds", t.filtered->wall_seconds}};
  }
  j["options"] = describe_options(job, t);
  j["options"]["guided"] = t.result.guided;
  j["options"]["threads"] = job.file.scene.options.threads;
  return to_text(j);
}

}  // namespace pvol::cli
