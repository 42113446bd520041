#include "cli/render_report.h"

#include <algorithm>

#include "cli/json.h"
#include "pvol/bounds/homogenise.h"
#include "pvol/version.h"

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
    if (v.density.homogeneous) {
      one["homogenised_nodes"] = v.density.homogeneous->nodes;
      one["depth_error_bound"] = v.density.homogeneous->depth_error;
    }
    list.push_back(std::move(one));
  }
  return list;
}

/// Every option that bears on the picture, by the name it has on the command line; not the number
/// of threads, on which no byte of a picture depends.
Json describe_options(const RenderJob& job) {
  const RenderOptions& r = job.file.scene.options;
  Json j;
  j["input"] = job.input.string();
  j["volume"] = job.file.volumes.front().file.string();
  j["grid"] = job.file.volumes.front().grid;
  j["size"] = {r.width, r.height};
  j["crop"] = {r.crop_x, r.crop_y, r.crop_width, r.crop_height};
  j["spp"] = r.samples;
  j["seed"] = r.seed;
  j["tracker"] = formats::name(r.tracker);
  j["transmittance"] = formats::name(r.transmittance);
  j["micro_bounds"] = formats::name(r.micro_bounds);
  j["micro_bounds_used"] = job.volumes.front().density.micro.edge;
  j["micro_bounds_from"] = micro_bounds_text(job.volumes.front());
  j["interpolation"] = formats::name(r.look_up);
  for (const VolumeReport& v : job.reports) j["density"].push_back(describe_density(v));
  j["depth"] = r.depth ? Json(*r.depth) : Json("auto");
  j["effective_depth"] = job.facts.front().depth;
  j["shells"] = formats::name(r.shells);
  j["shell_used"] = job.plan.shells.front().kept;
  j["guide"] = formats::name(r.guide);
  j["max_bounces"] = r.max_bounces ? Json(*r.max_bounces) : Json("none");
  j["majorant_scale"] = r.majorant_scale;
  j["homogenise"] = r.homogenise ? Json(*r.homogenise) : Json("off");
  if (const auto& h = job.volumes.front().density.homogeneous) {
    j["homogenised"] = {{"nodes", h->nodes},
                        {"volume_share", h->volume_share},
                        {"mass_share", h->mass_share},
                        {"depth_error_bound", h->depth_error}};
  }
  j["preview"] = r.preview;
  j["volumes"] = describe_volumes(job);
  j["background"] = r.background ? "on" : "off";
  j["biased"] = describe_bias(job);
  j["extinction"] = job.volumes.front().medium.extinction;
  j["set"] = job.sets;
  j["version"] = PVOL_VERSION;
  return j;
}

}  // namespace

std::string describe_bias(const RenderJob& job) {
  std::vector<std::string> reasons;
  const RenderOptions& o = job.file.scene.options;
  if (o.max_bounces) reasons.emplace_back("max_bounces");
  const bool homogenised = std::any_of(job.volumes.begin(), job.volumes.end(), [](const Volume& v) {
    return v.density.homogeneous && v.density.homogeneous->nodes > 0;
  });
  if (homogenised) reasons.emplace_back("homogenise");
  if (o.preview > 0) reasons.emplace_back("preview");
  for (const VolumeReport& v : job.reports) {
    if (v.density_error.absolute == 0) continue;  // exact, in whatever precision
    std::string reason = "density ";
    reason += name(v.density.precision);
    if (std::find(reasons.begin(), reasons.end(), reason) == reasons.end()) {
      reasons.push_back(reason);
    }
  }
  std::string text = reasons.empty() ? "no" : "yes: ";
  for (const std::string& r : reasons) text += (&r == &reasons.front() ? "" : ", ") + r;
  return text;
}

std::string micro_bounds_text(const Volume& volume) {
  if (volume.density.micro.edge == 0) return "none";
  if (volume.density.micro.edge == 1) return "single voxels, built at load";
  return volume.density.micro_stored ? "2^3 from the file" : "2^3 built at load";
}

std::map<std::string, std::string> describe_picture(const RenderJob& job, const TimedRender& t) {
  std::map<std::string, std::string> a;
  const Json options = describe_options(job);
  for (const auto& [key, value] : options.items()) {
    a["pvol:" + key] = value.is_string() ? value.get<std::string>() : value.dump();
  }
  a["pvol:scene"] = formats::to_toml(job.file);
  a["pvol:samples"] = std::to_string(t.samples) + " of " + std::to_string(t.samples_wanted);
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
  for (const Counter& counter : kCounters) j[counter.name] = value(counter, t.result.counts);
  j["mean_rgb"] = {mean_rgb.x, mean_rgb.y, mean_rgb.z};
  j["variance_rgb"] = {variance_rgb.x, variance_rgb.y, variance_rgb.z};
  j["options"] = describe_options(job);
  j["options"]["guided"] = t.result.guided;
  j["options"]["threads"] = job.file.scene.options.threads;
  return to_text(j);
}

}  // namespace pvol::cli
