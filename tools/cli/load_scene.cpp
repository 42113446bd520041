#include "cli/load_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "cli/cli.h"
#include "pvol/bounds/recipe_bounds.h"
#include "pvol/error.h"
#include "pvol/formats/image.h"
#include "pvol/formats/recipe_file.h"
#include "pvol/render/render.h"
#include "pvol/render/scene_volume.h"
#include "pvol/shell/certificate.h"
#include "pvol/shell/recipe_support.h"
#include "pvol/shell/shell.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/make_volume.h"

namespace pvol::cli {
namespace {

StageLine reading(const Loader& by, const std::filesystem::path& file) {
  return {"reading " + file.filename().string(), by.quiet};
}

}  // namespace

formats::SceneFile read_scene(const std::filesystem::path& input,
                              const std::vector<std::string>& sets) {
  const bool is_scene = formats::ending(input) == ".toml" && !formats::is_recipe(input);
  try {
    return is_scene ? formats::read_scene(input, sets) : formats::default_scene(input, sets);
  } catch (const Error& e) {
    // What the command line set is the command line's fault.
    if (std::string_view(e.what()).starts_with("--set ")) throw UsageError(e.what());
    throw;
  }
}

void load_sky(formats::SceneFile& file) {
  auto* sky = std::get_if<ImageSky>(&file.scene.environment);
  if (!sky) return;
  ImageSky picture = formats::read_sky(sky->file);
  sky->width = picture.width;
  sky->height = picture.height;
  sky->pixels = std::move(picture.pixels);
}

formats::LoadedGrid load_grid(const Loader& by, const std::filesystem::path& file,
                              const formats::GridOptions& grid) {
  StageLine stage = reading(by, file);
  formats::LoadedGrid loaded = formats::load_grid(file, grid);
  stage.erase();
  print_warnings(by.tool, loaded.report.warnings);
  return loaded;
}

formats::Cloud load_cloud(const Loader& by, const std::filesystem::path& file,
                          const formats::GridOptions& grid, LookUp look_up) {
  StageLine stage = reading(by, file);
  formats::Cloud cloud =
      formats::load_cloud(file, grid, look_up, [&] { stage.show("building bounds"); });
  stage.erase();
  print_warnings(by.tool, cloud.report.warnings);
  return cloud;
}

formats::Cloud load_cloud(const Loader& by, const std::filesystem::path& file,
                          const formats::GridOptions& grid, const formats::SceneFile& scene) {
  const RenderOptions& o = scene.scene.options;
  formats::Cloud cloud = load_cloud(by, file, grid, o.look_up);
  if (scene.density) formats::quantise(cloud, *scene.density, file);
  formats::coarsen(cloud, o.preview, file);
  return cloud;
}

double choose_extinction(const formats::Cloud& cloud, const Affine& object_to_world,
                         double thickness) {
  const VolumeFacts f = pvol::describe(cloud.density, 1, object_to_world);
  const double unit =
      *std::max_element(std::begin(f.mean_optical_thickness), std::end(f.mean_optical_thickness));
  if (!(unit > 0)) return 1;
  constexpr double kLargest = 3e38;  // fits a float, for clouds of denormal densities
  return std::min(std::stod(fmt::format("{:.3g}", thickness / unit)), kLargest);
}

Volume make_volume(const formats::Cloud& cloud, const formats::SceneVolume& volume,
                   const RenderOptions& options) {
  VolumeOptions o = volume_options(options);
  o.object_to_world = volume.object_to_world;
  const LeafMicroBounds* stored = cloud.micro ? &*cloud.micro : nullptr;
  Volume v = pvol::make_volume(cloud.density, cloud.pyramid, volume.medium, o, stored);
  if (cloud.shell) v.shell = std::make_shared<const Shell>(*cloud.shell);
  v.name = volume.file.string();
  return v;
}

VolumeFacts describe(const formats::Cloud& cloud, const formats::SceneVolume& volume) {
  return pvol::describe(cloud.density, volume.medium.extinction, volume.object_to_world);
}

void require_proof(const std::filesystem::path& file, const formats::Cloud& cloud) {
  if (!cloud.shell) return;
  CertifyOptions enough;
  enough.enough = evaluator_margin(*cloud.shell);
  const Support support = cloud.recipe() ? make_support(*cloud.recipe(), 3 - kLeafRefinement)
                                         : make_support(cloud.grid(), cloud.pyramid);
  if (certify(*cloud.shell, support, enough).bound >= enough.enough) return;
  throw Error(file.string() +
              ": its shell does not hold the cloud; fit it again, or render with --shells off");
}

Camera frame_all(std::span<const Volume> volumes, const Scene& scene) {
  const RenderOptions& o = scene.options;
  return frame(world_box(volumes), double(o.width) / o.height, scene.camera);
}

}  // namespace pvol::cli
