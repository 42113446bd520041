#include "cli/load_scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>

#include "cli/cli.h"
#include "pvol/bounds/recipe_bounds.h"
#include "pvol/error.h"
#include "pvol/formats/field_names.h"
#include "pvol/formats/image.h"
#include "pvol/formats/mesh_file.h"
#include "pvol/formats/recipe_file.h"
#include "pvol/formats/velocity.h"
#include "pvol/render/frame_volumes.h"
#include "pvol/render/render.h"
#include "pvol/render/scene_volume.h"
#include "pvol/shell/certificate.h"
#include "pvol/shell/recipe_support.h"
#include "pvol/shell/shell.h"
#include "pvol/volume/albedo_field.h"
#include "pvol/volume/emitter.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/make_volume.h"
#include "pvol/volume/motion.h"
#include "pvol/volume/moving_places.h"

namespace pvol::cli {
namespace {

StageLine reading(const Loader& by, const std::filesystem::path& file) {
  return {"reading " + file.filename().string(), by.quiet};
}

void tell(const Loader& by, const std::string& text) {
  if (!by.quiet) std::cerr << by.tool << ": " << text << '\n';
}

/// Names the grids that the volume leaves open; whether its fire got a colour that nobody
/// described.
bool bind_grids(const Loader& by, formats::SceneVolume& volume) {
  const bool colored = describes_fire_color(volume);
  const std::vector<formats::GridEntry> grids = formats::grids_of(volume.file);
  const std::string name = volume.file.filename().string() + ": ";
  for (const std::string& note : formats::bind_fields(volume, grids)) tell(by, name + note);
  const std::vector<std::string> dark = formats::usual_fire_grids(grids);
  if (!volume.fire && grids.size() > 1 && !dark.empty()) {
    tell(by, name + fmt::format("the file has {}", fmt::join(dark, " and ")) +
                 "; --set medium.fire.kelvin=1900 makes it a fire, which needs dim lights and thin "
                 "smoke");
  }
  return volume.fire && !colored;
}

/// Loads the grid of a volume's albedo, where there is one. `as_read`: the cloud's own
/// samples are those of the file, and may serve again.
void load_albedo(const Loader& by, formats::SceneVolume& volume, bool strict, bool as_read,
                 formats::Cloud& cloud) {
  const std::string kind = formats::ending(volume.file);
  if (volume.grid == formats::kNoGrid || (kind == ".toml" && !volume.albedo_field)) return;
  if (!volume.albedo_field || volume.albedo_field->grid.empty()) {
    const std::string name = volume.file.filename().string() + ": ";
    for (const std::string& note : formats::bind_albedo(volume, formats::grids_of(volume.file))) {
      tell(by, name + note);
    }
  }
  if (!volume.albedo_field || volume.albedo_field->grid == formats::kNoGrid) return;
  const bool same = as_read && (volume.grid.empty() || volume.grid == volume.albedo_field->grid);
  StageLine stage = reading(by, volume.file);
  cloud.albedo = std::make_shared<const formats::AlbedoGrid>(
      formats::load_albedo(volume.file, *volume.albedo_field, strict, same ? &cloud : nullptr));
  stage.erase();
  if (cloud.albedo->colors) print_warnings(by.tool, cloud.albedo->colors->report.warnings);
}

/// Sum of all samples as the map sees them.
double sum_mapped(const VoxelGrid& grid, const FieldMap& map) {
  double sum = 0;
  for (const Brick& b : grid.bricks) {
    for (int i = 0; i < kBrickSamples; ++i) sum += double(value_at(map, b.values[i]));
  }
  for (const Tile& t : grid.tiles) {
    sum += double(value_at(map, t.value)) * std::pow(double(t.edge), 3);
  }
  return sum;
}

/// The sum of all densities as the map sees them over that of the samples themselves.
double mapped_share(const formats::Cloud& cloud, const FieldMap& map) {
  if (map.is_identity() || cloud.recipe() != nullptr) return 1;
  const double sum = sum_mapped(cloud.grid(), {});
  return sum > 0 ? sum_mapped(cloud.grid(), map) / sum : 1;
}

/// `look_up` is that of the density.
std::shared_ptr<const AlbedoField> make_albedo(const formats::Cloud& cloud,
                                               const formats::SceneVolume& volume, LookUp look_up) {
  const AlbedoMap& map = *volume.albedo_field;
  const Affine place = volume.first_place();
  if (const auto& numbers = cloud.albedo->numbers) {
    return std::make_shared<const AlbedoField>(
        make_albedo_field(map, {numbers->grid(), numbers->pyramid}, place));
  }
  const VoxelGrid* const density = has_closed_form(look_up) ? &cloud.grid() : nullptr;
  return std::make_shared<const AlbedoField>(
      make_albedo_field(map, cloud.albedo->colors->grid, density, place));
}

Movement movement_of(const formats::CloudMotion& m) { return {m.velocity, m.seconds, m.shutter}; }

/// Moves with the cloud.
std::shared_ptr<const Emitter> make_fire(const formats::FireFields& f,
                                         const formats::SceneVolume& volume, ColorSpace space,
                                         const formats::CloudMotion* motion) {
  const BoundedGrid field{f.field.grid(), f.field.pyramid};
  const Affine place = volume.first_place();
  std::optional<BoundedGrid> color_by;
  if (f.color_by) color_by.emplace(BoundedGrid{f.color_by->grid(), f.color_by->pyramid});
  Fire described = *volume.fire;
  described.color_space = space;
  Emitter fire = make_emitter(described, field, color_by ? &*color_by : nullptr, place);
  if (motion) fire = make_moving(std::move(fire), field, place, movement_of(*motion));
  return std::make_shared<const Emitter>(std::move(fire));
}

/// What values of the field of colour mean in Kelvin, where nobody said: simulations write Kelvin
/// or numbers around 1, of which the largest is then taken for a flame of soot.
double choose_kelvin(const formats::FireFields& fields) {
  constexpr double kLeast = 100, kFlame = 2500;
  const auto largest = double((fields.color_by ? *fields.color_by : fields.field).pyramid.scale);
  return largest > kLeast || !(largest > 0) ? 1
                                            : std::stod(fmt::format("{:.3g}", kFlame / largest));
}

/// Loads the fields of a volume's fire; `undescribed` is one that nobody asked for.
void load_fire(const Loader& by, formats::SceneVolume& volume, bool strict, bool undescribed,
               formats::Cloud& cloud) {
  StageLine stage = reading(by, volume.file);
  cloud.fire = std::make_shared<const formats::FireFields>(
      formats::load_fire(volume.file, *volume.fire, strict));
  stage.erase();
  Fire& fire = *volume.fire;
  if (undescribed) {
    fire.kelvin = choose_kelvin(*cloud.fire);
    tell(by, "taken as " + readable(*fire.kelvin) +
                 " Kelvin where it is 1 (change it with --set medium.fire.kelvin=K)");
  }
  if (volume.has_intensity) return;
  fire.intensity = choose_intensity(cloud, fire, volume.first_place());
  volume.has_intensity = true;
  tell(by, "no intensity is set; chose " + readable(fire.intensity) +
               " per world unit for the fire (change it with --set medium.fire.intensity=X)");
}

/// Loads what moves a volume. A file without velocities stands still, unless the scene asks for
/// them.
void load_motion(const Loader& by, const formats::SceneVolume& volume, bool strict,
                 const Camera& camera, formats::Cloud& cloud) {
  const formats::VelocityChoice choice = volume.velocity.value_or(formats::VelocityChoice{});
  const std::filesystem::path& file = choice.file.empty() ? volume.file : choice.file;
  const bool as_a_whole = volume.moving || !volume.moving_instances.empty();
  const auto stands_still = [&](const char* why) {
    if (volume.velocity) throw Error(file.string() + ": " + why);
    if (as_a_whole || !camera.shutter.moves()) return;  // nobody expects that it moves by them
    tell(by, volume.file.filename().string() + ": " + why + ": it stands still");
  };
  if (cloud.pyramid.empty() && !cloud.fire) return stands_still("there is nothing to move");
  if (!volume.velocity && formats::ending(file) == ".nvdb") {
    return stands_still("velocities are read from .vdb and .pvol files (medium.motion.file)");
  }
  StageLine stage = reading(by, file);
  auto found = formats::read_velocity(file, choice.field, strict);
  stage.erase();
  if (!found) {
    const bool recipe = formats::ending(file) == ".toml";
    return stands_still(recipe ? "the recipe has no [flow]"
                               : "it has no velocities v, vel or velocity");
  }
  print_warnings(by.tool, found->warnings);
  if (choice.field.empty() && camera.shutter.moves()) {
    tell(by, volume.file.filename().string() + ": it moves with the grid " + found->name);
  }
  cloud.motion = std::make_shared<const formats::CloudMotion>(
      formats::CloudMotion{std::move(found->grid), choice.scale / camera.fps, camera.shutter});
}

}  // namespace

namespace {

/// What a file by itself with the grids of a fire shows where nobody says otherwise: the fire by
/// night, whatever is set of the fire itself, and sooty smoke around it in the last light of dusk.
void show_fire(const std::vector<std::string>& sets, formats::SceneFile& scene) {
  formats::SceneVolume& v = scene.volumes.front();
  const auto sets_any = [&](std::string_view section) {
    return std::ranges::any_of(sets, [&](const auto& s) { return s.starts_with(section); });
  };
  if (v.names_density()) return;
  if (!std::filesystem::exists(v.file)) return;  // it is missed where it is loaded
  const std::vector<formats::GridEntry> grids = formats::grids_of(v.file);
  const bool smokes = v.grid.empty() && !formats::lacks_density(grids);
  if (smokes ? !formats::has_flames(grids) : formats::usual_fire_grids(grids).empty()) return;
  v.shows_fire = true;
  if (smokes && !sets_any("medium.albedo")) v.medium.components.front().albedo = Rgb(0.5f);
  if (sets_any("environment") || sets_any("sun")) return;
  scene.scene.environment = ConstantSky{smokes ? Rgb(0.02f, 0.03f, 0.05f) : Rgb(0.0f)};
  scene.scene.lights.clear();
}

}  // namespace

formats::SceneFile read_scene(const std::filesystem::path& input,
                              const std::vector<std::string>& sets, const std::string& grid) {
  const bool is_scene = formats::ending(input) == ".toml" && !formats::is_recipe(input);
  try {
    formats::SceneFile scene =
        is_scene ? formats::read_scene(input, sets) : formats::default_scene(input, sets);
    if (!grid.empty()) scene.volumes.front().grid = grid;
    if (!is_scene) show_fire(sets, scene);
    return scene;
  } catch (const Error& e) {
    // What the command line set is the command line's fault.
    if (std::string_view(e.what()).starts_with("--set ")) throw UsageError(e.what());
    throw;
  }
}

void load_sky(const std::string& tool, formats::SceneFile& file) {
  auto* sky = std::get_if<ImageSky>(&file.scene.environment);
  if (!sky) return;
  formats::use_exr_threads(file.scene.options.threads);
  ImageSky picture =
      formats::read_sky(sky->file, {sky->color_space, file.scene.options.color_space});
  if (picture.width != 2 * picture.height) {
    print_warnings(tool, {fmt::format("{}: the sky has {} x {} pixels, expected twice as many "
                                      "across as down: longitudes by latitudes, evenly",
                                      sky->file, picture.width, picture.height)});
  }
  sky->width = picture.width;
  sky->height = picture.height;
  sky->pixels = std::move(picture.pixels);
}

namespace {

/// What a recipe has of bodies: the union of its forms within all cuts, and of its solids.
Body body_of(const Recipe& recipe) {
  std::vector<Body> all;
  if (!recipe.forms.empty()) {
    std::vector<Body> within = recipe.cuts;
    within.insert(within.begin(), Body(BodyOp::join, recipe.forms));
    all.emplace_back(BodyOp::intersection, std::move(within));
  }
  for (const Solid& solid : recipe.solids) all.push_back(solid.body);
  return Body(BodyOp::join, std::move(all));
}

}  // namespace

void load_surfaces(formats::SceneFile& file) {
  for (Surface& surface : file.scene.surfaces) {
    std::string name;
    if (auto* solid = std::get_if<SolidSurface>(&surface); solid && !solid->body) {
      name = solid->file;
      solid->body = std::make_shared<const Body>(body_of(formats::read_recipe(name)));
    } else if (auto* mesh = std::get_if<MeshSurface>(&surface); mesh && !mesh->mesh) {
      name = mesh->file;
      mesh->mesh = std::make_shared<const TriangleMesh>(formats::read_mesh(name));
    }
    if (name.empty()) continue;
    try {
      validate(surface);
    } catch (const Error& e) {
      throw Error(name + ": " + e.what());
    }
  }
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

formats::Cloud load_cloud(const Loader& by, formats::SceneVolume& volume, bool strict,
                          const formats::SceneFile& scene) {
  const RenderOptions& o = scene.scene.options;
  const bool undescribed = (volume.fire || !volume.names_density()) && bind_grids(by, volume);
  formats::Cloud cloud = load_cloud(by, volume.file, {volume.grid, strict}, o.look_up);
  if (scene.density) formats::quantise(cloud, *scene.density, volume.file);
  formats::coarsen(cloud, o.preview, volume.file);
  if (volume.fire) load_fire(by, volume, strict, undescribed, cloud);
  const bool as_read = !scene.density && o.preview == 0;
  load_albedo(by, volume, strict, as_read, cloud);
  const Camera& camera = scene.scene.camera;
  if (camera.shutter.moves() || o.aovs.has(Aov::velocity)) {
    load_motion(by, volume, strict, camera, cloud);
  }
  cloud.facts = look_through(cloud.density);
  return cloud;
}

double chosen_thickness(const formats::SceneVolume& volume) {
  constexpr double kAroundFire = 4;  // more would hide it
  return volume.shows_fire && volume.fire ? kAroundFire : kChosenThickness;
}

namespace {

DensityFacts facts_of(const formats::Cloud& cloud) {
  return cloud.facts ? *cloud.facts : look_through(cloud.density);
}

}  // namespace

double choose_extinction(const formats::Cloud& cloud, const Affine& object_to_world,
                         double thickness, const FieldMap& map) {
  const VolumeFacts f = pvol::describe(facts_of(cloud), 1, object_to_world);
  const double unit =
      mapped_share(cloud, map) *
      *std::max_element(std::begin(f.mean_optical_thickness), std::end(f.mean_optical_thickness));
  if (!(unit > 0)) return 1;
  constexpr double kLargest = 3e38;  // fits a float, for clouds of denormal densities
  return std::min(std::stod(fmt::format("{:.3g}", thickness / unit)), kLargest);
}

double choose_intensity(const formats::Cloud& cloud, const Fire& fire,
                        const Affine& object_to_world) {
  const formats::FireFields& f = *cloud.fire;
  const double sum = sum_mapped(f.field.grid(), {}), mapped = sum_mapped(f.field.grid(), fire.map);
  const VolumeFacts facts = pvol::describe(f.field.grid(), 1, object_to_world);
  const double longest = *std::max_element(std::begin(facts.mean_optical_thickness),
                                           std::end(facts.mean_optical_thickness));
  if (!(mapped > 0 && longest > 0)) return 1;
  constexpr double kLargest = 1e30;
  return std::min(std::stod(fmt::format("{:.3g}", sum / (mapped * longest))), kLargest);
}

namespace {

/// The map of a placement that is there all the time.
MovingMap at_rest(const Affine& map) {
  MovingMap still;
  still.linear.m = map.m;
  still.shift = map.t;
  return still;
}

MovingMap map_of(const Affine& still, const std::optional<MovingPlacement>& moving) {
  return moving ? moving->map() : at_rest(still);
}

std::vector<MovingPlace> moving_places(const formats::SceneVolume& volume) {
  std::vector<MovingPlace> places(std::max<std::size_t>(1, volume.instances.size()));
  for (MovingPlace& place : places) place.object = map_of(volume.object_to_world, volume.moving);
  for (std::size_t i = 0; i < volume.instances.size(); ++i) {
    const bool told = i < volume.moving_instances.size();
    places[i].instance =
        map_of(volume.instances[i], told ? volume.moving_instances[i] : std::nullopt);
  }
  return places;
}

}  // namespace

Volume make_volume(const formats::Cloud& cloud, const formats::SceneVolume& volume,
                   const Scene& scene, SampleStorage samples) {
  const RenderOptions& options = scene.options;
  VolumeOptions o = volume_options(options);
  if (samples != SampleStorage::automatic) o.samples = samples;
  o.object_to_world = volume.object_to_world;
  o.instances = volume.instances;
  if (!volume.density_map.is_identity()) {
    o.map = std::make_shared<const FieldMap>(volume.density_map);
  }
  // Fires ask for the density of every collision in them, media that glow for many along a flight,
  // and what moves for every density that a path meets, where it came from.
  const bool moves = cloud.motion && cloud.motion->shutter.moves();
  const bool glows = options.line_emission != LineEmission::off && emits(volume.medium);
  if (cloud.fire || glows || moves) o.samples = SampleStorage::copied;
  if (moves) o.micro_bounds = MicroBoundsUse::none;
  const LeafMicroBounds* stored = cloud.micro ? &*cloud.micro : nullptr;
  Volume v = pvol::make_volume(cloud.density, cloud.pyramid, volume.medium, o, stored);
  if (cloud.shell) v.shell = std::make_shared<const Shell>(*cloud.shell);
  if (const formats::CloudMotion* m = cloud.motion.get()) {
    v = make_moving(std::move(v), cloud.pyramid, index_to_object(cloud.density), movement_of(*m),
                    o);
  }
  if (cloud.fire && volume.fire) {
    v.fire = make_fire(*cloud.fire, volume, options.color_space, cloud.motion.get());
  }
  if (cloud.albedo && volume.albedo_field) v.albedo = make_albedo(cloud, volume, o.look_up);
  v.name = volume.file.string();
  if (volume.moving || !volume.moving_instances.empty()) {
    v = move_places(std::move(v), moving_places(volume), scene.camera.shutter);
  }
  return v;
}

VolumeFacts describe(const formats::Cloud& cloud, const formats::SceneVolume& volume) {
  VolumeFacts f = pvol::describe(facts_of(cloud), volume.medium.extinction, volume.first_place());
  if (volume.density_map.is_identity()) return f;
  const ValueRange range = range_over(volume.density_map, {0, cloud.pyramid.scale});
  f.largest_extinction = volume.medium.extinction * double(range.hi);
  f.shortest_free_path = 1 / f.largest_extinction;
  const double share = mapped_share(cloud, volume.density_map);
  for (double& thickness : f.mean_optical_thickness) thickness *= share;
  f.largest_optical_thickness *= share;
  return f;
}

void require_proof(const std::filesystem::path& file, const formats::Cloud& cloud) {
  if (!cloud.shell) return;
  CertifyOptions enough;
  enough.enough = evaluator_margin(*cloud.shell);
  const Support support = cloud.recipe() ? make_support(*cloud.recipe(), 3 - kLeafRefinement)
                                         : make_support(cloud.grid(), cloud.pyramid);
  if (certify(*cloud.shell, support, enough).bound >= enough.enough) return;
  throw Error(file.string() +
              ": its shell does not contain the cloud; fit it again, or render with --shells off");
}

Camera frame_all(std::span<const Volume> volumes, const Scene& scene) {
  const RenderOptions& o = scene.options;
  return frame_volumes(volumes, double(o.width) / o.height, scene.camera);
}

}  // namespace pvol::cli
