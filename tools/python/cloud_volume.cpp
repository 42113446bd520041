#include "python/cloud_volume.h"

#include <utility>

#include "cli/load_scene.h"
#include "pvol/bounds/pyramid.h"
#include "pvol/error.h"

namespace pvol::python {
namespace {

CloudVolume make(std::shared_ptr<const formats::Cloud> cloud, Making how,
                 formats::SceneVolume given, const RenderOptions& options) {
  CloudVolume v{std::move(cloud),
                std::move(how.medium),
                std::move(how.options),
                std::move(given),
                options,
                {},
                std::make_shared<LazyBatchField>()};
  Scene scene;
  scene.options = options;
  // Batches of rays look up copies.
  v.volume = cli::make_volume(*v.cloud, v.given, scene, SampleStorage::copied);
  return v;
}

}  // namespace

const BatchField& CloudVolume::batch_field() const {
  std::call_once(batches->made, [&] { batches->field.emplace(volume); });
  return *batches->field;
}

formats::SceneFile read_making(const std::filesystem::path& file, const Making& how) {
  Words all = how.medium;
  all.insert(how.options.begin(), how.options.end());
  formats::SceneFile scene = formats::default_scene(file, sets_of(all));
  const formats::SceneVolume& v = scene.volumes.front();
  if (v.fire || v.velocity || v.albedo_field) {
    throw Error(
        "fire, motion and albedo_field need grids of a file; render a scene that names the file");
  }
  return scene;
}

CloudVolume make_cloud_volume(std::shared_ptr<const formats::Cloud> cloud,
                              const std::filesystem::path& file, const Making& how, bool choose) {
  formats::SceneFile scene = read_making(file, how);
  formats::SceneVolume given = scene.volumes.front();
  if (choose && !given.has_extinction && !cloud->pyramid.empty()) {
    given.medium.extinction = cli::choose_extinction(*cloud, given.first_place());
  }
  given.has_extinction = true;
  return make(std::move(cloud), how, std::move(given), scene.scene.options);
}

std::shared_ptr<const formats::Cloud> bound_grid(VoxelGrid grid, LookUp look_up) {
  if (look_up == LookUp::procedural) {
    throw Error(
        "interpolation: found procedural, which arrays of samples do not support; choose another "
        "one");
  }
  auto cloud = std::make_shared<formats::Cloud>();
  cloud->pyramid = build_pyramid(grid, look_up);
  cloud->metadata.grid_name = grid.name;
  cloud->metadata.index_to_world = grid.index_to_world;
  cloud->density = std::move(grid);
  return cloud;
}

CloudVolume with_medium(const CloudVolume& v, Words medium) {
  formats::SceneVolume given =
      read_making(v.given.file, {.medium = medium, .options = {}}).volumes.front();
  given.grid = v.given.grid;
  if (!given.has_extinction) given.medium.extinction = v.given.medium.extinction;
  given.has_extinction = true;
  formats::SceneVolume as_before = given;
  as_before.medium.components = v.given.medium.components;
  as_before.medium.extinction_color = v.given.medium.extinction_color;
  if (as_before != v.given) {
    return make(v.cloud, {std::move(medium), v.making}, std::move(given), v.options);
  }
  validate(given.medium);
  CloudVolume with = v;
  with.volume.medium = given.medium;
  with.medium = std::move(medium);
  with.given = std::move(given);
  return with;
}

CloudVolume with_options(const CloudVolume& v, const Words& options) {
  const formats::SceneFile scene = read_making(v.given.file, {.medium = {}, .options = options});
  return make(v.cloud, {v.medium, options}, v.given, scene.scene.options);
}

CloudVolume with_shell(const CloudVolume& v, const std::optional<Shell>& shell) {
  CloudVolume with = v;
  formats::Cloud cloud = *v.cloud;
  cloud.shell = shell;
  with.cloud = std::make_shared<const formats::Cloud>(std::move(cloud));
  with.volume.shell = shell ? std::make_shared<const Shell>(*shell) : nullptr;
  return with;
}

Affine index_to_world(const CloudVolume& v) {
  return v.given.first_place() * index_to_object(v.cloud->density);
}

}  // namespace pvol::python
