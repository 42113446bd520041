#include "render_report.h"

#include "json.h"
#include "pvol/version.h"

namespace pvol::cli {
namespace {

/// Every option that bears on the picture, by the name it has on the command line; not the number
/// of threads, on which no byte of a picture depends.
Json describe_options(const RenderJob& job) {
  const RenderOptions& r = job.file.scene.options;
  Json j;
  j["input"] = job.input.string();
  j["volume"] = job.file.volume.string();
  j["grid"] = job.file.grid;
  j["size"] = {r.width, r.height};
  j["crop"] = {r.crop_x, r.crop_y, r.crop_width, r.crop_height};
  j["spp"] = r.samples;
  j["seed"] = r.seed;
  j["tracker"] = formats::name(r.tracker);
  j["transmittance"] = formats::name(r.transmittance);
  j["micro_bounds"] = formats::name(r.micro_bounds);
  j["micro_bounds_used"] = job.volumes.front().micro.edge;
  j["interpolation"] = formats::name(r.interpolation);
  j["depth"] = r.depth ? Json(*r.depth) : Json("auto");
  j["effective_depth"] = job.reports.front().facts.depth;
  j["shells"] = formats::name(r.shells);
  j["shell_used"] = job.volumes.front().shell.has_value();
  j["guide"] = formats::name(r.guide);
  j["max_bounces"] = r.max_bounces ? Json(*r.max_bounces) : Json("none");
  j["background"] = r.background ? "on" : "off";
  j["extinction"] = job.file.scene.medium.extinction;
  j["set"] = job.sets;
  j["version"] = PVOL_VERSION;
  return j;
}

}  // namespace

std::map<std::string, std::string> describe_picture(const RenderJob& job, const TimedRender& t) {
  std::map<std::string, std::string> a;
  const Json options = describe_options(job);
  for (const auto& [key, value] : options.items()) {
    a["pvol:" + key] = value.is_string() ? value.get<std::string>() : value.dump();
  }
  a["pvol:scene"] = formats::to_toml(job.file);
  a["pvol:biased"] = job.file.scene.options.max_bounces ? "yes: max_bounces" : "no";
  a["pvol:samples"] = std::to_string(t.samples) + " of " + std::to_string(t.samples_wanted);
  return a;
}

std::string stats_text(const RenderJob& job, const TimedRender& t) {
  const Counts& c = t.result.counts;
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
  j["lookups_path"] = c.lookups_path;
  j["lookups_shadow"] = c.lookups_shadow;
  j["bounds_tests_path"] = c.bounds_tests_path;
  j["bounds_tests_shadow"] = c.bounds_tests_shadow;
  j["segments_path"] = c.segments_path;
  j["segments_shadow"] = c.segments_shadow;
  j["collisions"] = c.collisions;
  j["null_collisions"] = c.null_collisions;
  j["shadow_rays"] = c.shadow_rays;
  j["shell_tests"] = c.shell_tests;
  j["shell_rejections"] = c.shell_rejections;
  j["mean_rgb"] = {mean_rgb.x, mean_rgb.y, mean_rgb.z};
  j["variance_rgb"] = {variance_rgb.x, variance_rgb.y, variance_rgb.z};
  j["options"] = describe_options(job);
  j["options"]["guided"] = t.result.guided;
  j["options"]["threads"] = job.file.scene.options.threads;
  return to_text(j);
}

}  // namespace pvol::cli
