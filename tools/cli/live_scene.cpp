#include "cli/live_scene.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cli/cli.h"
#include "pvol/error.h"
#include "pvol/render/scene_volume.h"

namespace pvol::cli {
namespace {

/// What a volume says of the grids that are read for it, and nothing else.
formats::SceneVolume grids_of(const formats::SceneVolume& v) {
  formats::SceneVolume grids;
  grids.file = v.file, grids.grid = v.grid;
  grids.shows_fire = v.shows_fire;
  grids.velocity = v.velocity;
  if (v.fire) grids.fire = Fire{.field = v.fire->field, .color_by = v.fire->color_by};
  if (v.albedo_field) grids.albedo_field = AlbedoMap{.grid = v.albedo_field->grid};
  return grids;
}

/// Gives a volume what was chosen for another one of the same grids.
void choose_alike(const formats::SceneVolume& chosen, formats::SceneVolume& v) {
  v.grid = chosen.grid;
  if (!v.fire) {
    v.fire = chosen.fire;
    v.has_intensity = chosen.has_intensity;
  } else if (chosen.fire) {
    v.fire->field = chosen.fire->field;
    v.fire->color_by = chosen.fire->color_by;
  }
  if (!v.albedo_field) {
    v.albedo_field = chosen.albedo_field;
  } else if (chosen.albedo_field) {
    v.albedo_field->grid = chosen.albedo_field->grid;
  }
}

/// Whether the volumes differ at most in what may be exchanged in a volume that is made.
bool are_made_alike(const formats::SceneVolume& a, formats::SceneVolume b) {
  b.medium.components = a.medium.components;
  b.medium.extinction_color = a.medium.extinction_color;
  return a == b;
}

/// Figures about a cloud as this volume, by those about it as another one where they differ by the
/// extinction alone: to look at all samples takes as long as to make the volume.
VolumeFacts describe_like(const formats::Cloud& cloud, const formats::SceneVolume& v,
                          const formats::SceneVolume& known, VolumeFacts facts) {
  formats::SceneVolume as_known = v;
  as_known.medium = known.medium;
  const double factor = v.medium.extinction / known.medium.extinction;
  if (as_known != known || !std::isfinite(factor)) return describe(cloud, v);
  facts.largest_extinction *= factor;
  facts.shortest_free_path /= factor;
  for (double& thickness : facts.mean_optical_thickness) thickness *= factor;
  facts.largest_optical_thickness *= factor;
  return facts;
}

/// Chooses what a volume leaves open that follows from its cloud.
void choose_strengths(const formats::Cloud& cloud, formats::SceneVolume& v) {
  if (!v.has_extinction && !cloud.pyramid.empty()) {
    v.medium.extinction =
        choose_extinction(cloud, v.first_place(), chosen_thickness(v), v.density_map);
    v.has_extinction = true;
  }
  if (v.fire && !v.has_intensity && cloud.fire) {
    v.fire->intensity = choose_intensity(cloud, *v.fire, v.first_place());
    v.has_intensity = true;
  }
}

}  // namespace

LiveScene::Making LiveScene::making_of(const formats::SceneFile& scene) {
  const RenderOptions& o = scene.scene.options;
  Making making{.shutter = scene.scene.camera.shutter,
                .fps = scene.scene.camera.fps,
                .density = scene.density};
  RenderOptions& kept = making.options;
  kept.look_up = o.look_up, kept.micro_bounds = o.micro_bounds;
  kept.depth = o.depth, kept.homogenise = o.homogenise;
  kept.tracker = o.tracker, kept.majorant_scale = o.majorant_scale;
  kept.transmittance = o.transmittance;
  kept.preview = o.preview;
  kept.color_space = o.color_space;
  if (o.aovs.has(Aov::velocity)) kept.aovs.add(Aov::velocity);
  return making;
}

LiveScene::Prepared LiveScene::make_volume_of(const formats::SceneFile& scene,
                                              const formats::SceneVolume& asked,
                                              const std::shared_ptr<const formats::Cloud>& given,
                                              std::span<const Prepared> known) const {
  const auto same = std::ranges::find_if(
      known, [&](const Prepared& p) { return p.given == given && p.asked == asked; });
  if (same != known.end()) return *same;

  Prepared p{.given = given, .asked = asked, .chosen = asked, .cloud = given};
  const formats::SceneVolume grids = grids_of(asked);
  const auto read = std::ranges::find_if(known, [&](const Prepared& k) {
    return k.given == given && (grids_of(k.asked) == grids || grids_of(k.chosen) == grids);
  });
  if (read != known.end()) {
    p.cloud = read->cloud;
    choose_alike(read->chosen, p.chosen);
  } else if (!given) {
    p.cloud = std::make_shared<const formats::Cloud>(load_cloud(by_, p.chosen, false, scene));
  }
  choose_strengths(*p.cloud, p.chosen);
  if (read != known.end() && are_made_alike(read->chosen, p.chosen)) {
    validate(p.chosen.medium);
    Volume changed = *read->volume;
    changed.medium = p.chosen.medium;
    p.volume = std::make_shared<const Volume>(std::move(changed));
    p.facts = read->facts;
    p.is_proven = read->is_proven;
    return p;
  }
  p.volume = std::make_shared<const Volume>(
      naming(asked.file, [&] { return make_volume(*p.cloud, p.chosen, scene.scene); }));
  const bool is_known = read != known.end();
  p.facts = pvol::describe(*p.volume,
                           is_known ? describe_like(*p.cloud, p.chosen, read->chosen, read->facts)
                                    : describe(*p.cloud, p.chosen));
  p.is_proven = is_known && read->is_proven;
  return p;
}

LiveScene::Prepared LiveScene::prepare_volume(const formats::SceneFile& scene,
                                              const formats::SceneVolume& asked,
                                              const std::shared_ptr<const formats::Cloud>& given,
                                              std::span<const Prepared> known) const {
  Prepared p = make_volume_of(scene, asked, given, known);
  if (!p.is_proven && scene.scene.options.shells != ShellUse::off) {
    require_proof(asked.file, *p.cloud);
    p.is_proven = true;
  }
  return p;
}

void LiveScene::load_files(formats::SceneFile& scene) const {
  auto* sky = std::get_if<ImageSky>(&scene.scene.environment);
  const auto* known_sky = std::get_if<ImageSky>(&sky_);
  const ColorSpace space = scene.scene.options.color_space;
  if (sky && known_sky && sky->file == known_sky->file &&
      sky->color_space == known_sky->color_space && space == making_.options.color_space) {
    sky->width = known_sky->width, sky->height = known_sky->height;
    sky->pixels = known_sky->pixels;
  } else {
    load_sky("pvol", scene);
  }
  for (Surface& surface : scene.scene.surfaces) {
    for (const Surface& known : surfaces_) {
      auto* mesh = std::get_if<MeshSurface>(&surface);
      const auto* known_mesh = std::get_if<MeshSurface>(&known);
      if (mesh && known_mesh && mesh->file == known_mesh->file) mesh->mesh = known_mesh->mesh;
      auto* solid = std::get_if<SolidSurface>(&surface);
      const auto* known_solid = std::get_if<SolidSurface>(&known);
      if (solid && known_solid && solid->file == known_solid->file) solid->body = known_solid->body;
    }
  }
  load_surfaces(scene);
}

RenderJob LiveScene::prepare(formats::SceneFile scene, const GivenClouds& given) {
  RenderJob job;
  job.file = std::move(scene);
  load_files(job.file);
  const Making making = making_of(job.file);
  std::vector<Prepared> known, now;
  if (making == making_) known = prepared_;
  for (std::size_t i = 0; i < job.file.volumes.size(); ++i) {
    formats::SceneVolume& v = job.file.volumes[i];
    now.push_back(prepare_volume(job.file, v, i < given.size() ? given[i] : nullptr, known));
    known.push_back(now.back());  // for further volumes of the same file
    const Prepared& p = now.back();
    v = p.chosen;
    job.volumes.push_back(*p.volume);
    job.facts.push_back(p.facts);
    job.reports.push_back(
        {v.file, p.cloud->metadata.quantisation, p.cloud->metadata.quantisation_error});
  }
  if (!job.file.has_camera) {
    job.file.scene.camera = frame_all(job.volumes, job.file.scene);
    job.file.has_camera = true;
  }
  making_ = making;
  prepared_ = std::move(now);
  sky_ = job.file.scene.environment;
  surfaces_ = job.file.scene.surfaces;
  return job;
}

}  // namespace pvol::cli
