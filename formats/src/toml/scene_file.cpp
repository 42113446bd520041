#include "pvol/formats/scene_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "pvol/error.h"
#include "toml/phase_file.h"
#include "toml/read_keys.h"
#include "toml/scene_keys.h"
#include "toml/toml_table.h"
#include "toml/volume_tables.h"

namespace pvol::formats {
namespace {

/// Whether a text under this key, in whatever section, is the name of a file.
bool names_file(std::string_view key) { return key == "file" || key == kPhaseTable; }

/// visit(value, text) for each name of a file in a table and those within it.
template <class Visit>
void visit_names(TomlTable& table, const Visit& visit) {
  for (TomlValue& member : table.members) {
    if (auto* text = std::get_if<std::string>(&member.value)) {
      if (names_file(member.key) && !text->empty()) visit(member, *text);
    } else if (auto* inner = std::get_if<TomlTable>(&member.value)) {
      visit_names(*inner, visit);
    } else if (auto* array = std::get_if<TomlArray>(&member.value)) {
      for (TomlValue& item : *array) {
        if (auto* row = std::get_if<TomlTable>(&item.value)) visit_names(*row, visit);
      }
    }
  }
}

/// Makes relative file names of the scene relative to the current folder.
void resolve_files(TomlTable& table, const std::filesystem::path& folder) {
  visit_names(table, [&](TomlValue&, std::string& text) { text = (folder / text).string(); });
}

/// Refuses what a matrix says, too.
void refuse_beside_matrix(const TomlTable& table) {
  if (!table.has("matrix")) return;
  for (const char* key : {"position", "target", "up"}) {
    if (table.has(key)) table.fail(key, "either a matrix or position, target and up");
  }
}

/// Where the camera is a frame later.
void read_way(const TomlTable& table, SceneFile& file) {
  Camera& camera = file.scene.camera;
  if (!file.has_camera) {
    throw Error(table.where +
                ": found a camera that moves without a position; expected position "
                "and target, or matrix, in [camera]");
  }
  CameraPlace& to = camera.to.emplace(CameraPlace{camera.position, camera.target, camera.up});
  refuse_beside_matrix(table);
  read_keys(table, entries(to));
  refuse_misfit(table, misfit_of_way(camera));
}

void read_camera(const TomlTable& table, SceneFile& file) {
  Camera& camera = file.scene.camera;
  Entries all = entries(camera);
  const bool by_matrix = table.has("matrix");
  file.has_camera = by_matrix || table.has("position") || table.has("target");
  if (by_matrix || !file.has_camera) {  // framed; the rest holds
    for (Entry& e : all) e.about.required = false;
  }
  refuse_beside_matrix(table);
  for (const char* key : {"azimuth", "elevation", "zoom"}) {
    if (!file.has_camera || !table.has(key)) continue;
    table.fail(key,
               "none for a camera with a position; leave the position out to frame the clouds");
  }
  std::vector<std::string_view> allowed = key_names(all);
  allowed.emplace_back("to");
  read_keys(table, all, allowed);
  if (is_set(table, "fov")) {
    if (camera.kind == CameraKind::orthographic) {
      table.fail("fov",
                 "none for an orthographic camera; its size is ortho_scale or, without a "
                 "position, zoom");
    }
    // Of the command line; a file's focal length replaces the file's fov.
    if (!is_set(table, "focal_length")) camera.focal_length.reset();
  }
  if (file.has_camera) refuse_misfit(table, misfit(camera));
  if (const TomlTable* to = table.table("to")) read_way(*to, file);
}

Vec3d up_of(UpAxis axis) { return axis == UpAxis::z ? Vec3d(0, 0, 1) : Vec3d(0, 1, 0); }

/// A sky of each kind as it stands by default.
std::vector<Environment> usual_skies(UpAxis axis) {
  std::vector<Environment> kinds = all_kinds<Environment>();
  for (Environment& sky : kinds) {
    if (auto* gradient = std::get_if<GradientSky>(&sky)) gradient->up = up_of(axis);
    if (auto* picture = std::get_if<ImageSky>(&sky)) picture->up = up_of(axis);
    if (auto* clear = std::get_if<ClearSky>(&sky); clear && axis == UpAxis::z) {
      clear->up = up_of(axis), clear->north = {0, 1, 0};
    }
  }
  return kinds;
}

UpAxis read_world(const TomlTable& root) {
  World world;
  if (const TomlTable* table = root.table("world")) read_keys(*table, entries(world));
  return world.up;
}

/// Refuses keys that skies of another kind have.
void refuse_of_other_skies(const TomlTable& table, const std::vector<Environment>& kinds,
                           const std::vector<std::string_view>& allowed) {
  for (Environment kind : kinds) {
    for (const Entry& e : entries(kind)) {
      const std::string_view key = e.about.key;
      if (!table.has(key) || std::ranges::find(allowed, key) != allowed.end()) continue;
      table.fail(key, std::string("type = \"") + kind_name(kind) + "\" beside it");
    }
  }
}

void read_environment(const TomlTable& table, UpAxis axis, Environment& environment) {
  std::vector<Environment> kinds = usual_skies(axis);
  std::vector<std::string_view> names;
  for (const Environment& kind : kinds) names.emplace_back(kind_name(kind));
  if (const auto type = table.word("type", names)) {
    const auto at = std::find(names.begin(), names.end(), *type);
    environment = kinds[std::size_t(at - names.begin())];
  } else {
    choose_kind(table, environment);
    environment = kinds[environment.index()];
  }
  const Entries own = entries(environment);
  std::vector<std::string_view> allowed = key_names(own);
  allowed.insert(allowed.begin(), "type");
  const TomlTable of_its_kind = of_chosen_kind<Environment>(table, "type", allowed);
  refuse_of_other_skies(of_its_kind, kinds, allowed);
  read_keys(of_its_kind, own, allowed);
  if (const auto* clear = std::get_if<ClearSky>(&environment)) refuse_misfit(table, misfit(*clear));
}

void read_lights(const TomlTable& root, std::vector<Light>& lights) {
  for (const Light& kind : all_kinds<Light>()) {
    for (const TomlTable* table : root.tables(kind_name(kind))) {
      Light& light = lights.emplace_back(kind);
      read_keys(*table, entries(light));
    }
  }
}

/// Where a surface is a frame later.
void read_way(const TomlTable& table, Surface& surface) {
  if (auto* ball = std::get_if<BallSurface>(&surface)) {
    read_keys(table, entries(ball->to.emplace()));
  } else if (auto* solid = std::get_if<SolidSurface>(&surface)) {
    solid->to = read_to(table, solid->place).to;
  } else if (auto* mesh = std::get_if<MeshSurface>(&surface)) {
    mesh->to = read_to(table, mesh->place).to;
  }
}

void read_surfaces(const TomlTable& root, UpAxis axis, std::vector<Surface>& surfaces) {
  for (const Surface& kind : all_kinds<Surface>()) {
    for (const TomlTable* table : root.tables(kind_name(kind))) {
      Surface& surface = surfaces.emplace_back(kind);
      if (auto* plane = std::get_if<PlaneSurface>(&surface)) plane->normal = up_of(axis);
      const Entries own = entries(surface);
      std::vector<std::string_view> allowed = key_names(own);
      if (!std::holds_alternative<PlaneSurface>(surface)) allowed.emplace_back("to");
      read_keys(*table, own, allowed);
      refuse_misfit(*table, misfit(surface));
      if (const TomlTable* to = table->table("to")) read_way(*to, surface);
    }
  }
}

void read_render(const TomlTable& table, SceneFile& file) {
  Entries all = render_keys(file);
  std::erase_if(all, [](const Entry& e) { return !e.about.in_scenes; });
  read_keys(table, all);
  refuse_misfit(table, misfit(file.scene.options));
}

SceneFile read_table(const TomlTable& root) {
  if (root.has("recipe")) {
    throw Error(root.where +
                ": found a recipe of a cloud; expected a scene, with the recipe as the " +
                "file of its [volume]");
  }
  root.allow_only(section_names());
  root.require({"volume"});
  SceneFile result;
  const UpAxis axis = read_world(root);
  result.scene.camera.up = up_of(axis);
  if (auto* sky = std::get_if<GradientSky>(&result.scene.environment)) sky->up = up_of(axis);
  if (const TomlTable* camera = root.table("camera")) read_camera(*camera, result);
  read_volumes(root, result);
  if (const TomlTable* sky = root.table("environment")) {
    read_environment(*sky, axis, result.scene.environment);
  }
  read_lights(root, result.scene.lights);
  read_surfaces(root, axis, result.scene.surfaces);
  if (const TomlTable* render = root.table("render")) read_render(*render, result);
  return result;
}

/// Whether a table, or one within it, has the key.
bool mentions(const TomlTable& table, std::string_view key) {
  const auto in = [&](const TomlValue& v) {
    const auto* inner = std::get_if<TomlTable>(&v.value);
    return inner != nullptr && mentions(*inner, key);
  };
  return std::any_of(table.members.begin(), table.members.end(), [&](const TomlValue& m) {
    const auto* list = std::get_if<TomlArray>(&m.value);
    return m.key == key || in(m) ||
           (list != nullptr && std::any_of(list->begin(), list->end(), in));
  });
}

/// Lights a scene that says nothing of light, and does not glow, by a sun of the afternoon, from
/// the left; whether it did.
bool add_usual_sun(TomlTable& root) {
  const bool z_up = read_world(root) == UpAxis::z;
  const std::string sun_text = fmt::format(
      "[[sun]]\ndirection = {}\n"
      "irradiance = [3.3, 3.0, 2.6]\nangle = 0.53\n",
      z_up ? "[-0.75, -0.35, 0.62]" : "[-0.75, 0.62, 0.35]");
  for (const Light& kind : all_kinds<Light>()) {
    if (root.has(kind_name(kind))) return false;
  }
  if (root.has("environment") || mentions(root, "emission") || mentions(root, "fire")) return false;
  TomlTable sun = parse_toml(sun_text, "usual light");
  root.members.push_back(std::move(sun.members.front()));
  std::sort(root.members.begin(), root.members.end(),
            [](const TomlValue& a, const TomlValue& b) { return a.key < b.key; });
  return true;
}

/// Whether the scene's sky brings a sun of its own.
bool has_clear_sky(const TomlTable& root) {
  const TomlTable* sky = root.table("environment");
  if (sky == nullptr) return false;
  const TomlValue* type = sky->find("type");
  if (type == nullptr) return sky->has(keys(ClearSky{}).front().about.key);
  const auto* name = std::get_if<std::string>(&type->value);
  return name != nullptr && *name == ClearSky::kName;
}

/// What is said of the world bears on the sun that is there by default, whose values may be set,
/// and which leaves where a clear sky has its own, unless it was set.
void apply_sets(TomlTable& root, const std::vector<std::string>& sets) {
  for (const std::string& set : sets) {
    if (set.starts_with("world.")) apply_set(root, set);
  }
  const bool usual = add_usual_sun(root);
  for (const std::string& set : sets) apply_set(root, set);
  const auto of_sun = [](const std::string& set) { return set.starts_with("sun"); };
  if (usual && has_clear_sky(root) && std::ranges::none_of(sets, of_sun)) {
    std::erase_if(root.members, [](const TomlValue& m) { return m.key == Sun::kName; });
  }
}

/// Which TOML is made of.
bool is_utf8(const std::string& text) {
  try {
    (void)parse_toml("name = " + toml_string(text), "");
    return true;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

SceneFile read_scene(const std::filesystem::path& file, const std::vector<std::string>& sets) {
  TomlTable root = parse_toml_file(file);
  resolve_files(root, file.parent_path());
  apply_sets(root, sets);
  load_phase_files(root);
  return read_table(root);
}

std::string where_named(const std::filesystem::path& scene, const std::filesystem::path& file) {
  TomlTable root = parse_toml_file(scene);
  resolve_files(root, scene.parent_path());
  std::string where;
  visit_names(root, [&](const TomlValue& value, const std::string& text) {
    if (where.empty() && text == file) where = value.where + ": " + value.name;
  });
  return where;
}

SceneFile parse_scene(const std::string& text, const std::string& name) {
  TomlTable root = parse_toml(text, name);
  load_phase_files(root);
  return read_table(root);
}

SceneFile parse_scene(const std::string& text, const std::string& name,
                      const std::vector<std::string>& sets) {
  TomlTable root = parse_toml(text, name);
  apply_sets(root, sets);
  load_phase_files(root);
  return read_table(root);
}

SceneFile default_scene(const std::filesystem::path& volume, const std::vector<std::string>& sets) {
  if (!is_utf8(volume.string())) {
    throw Error(volume.string() + ": the file's name is not UTF-8, as scenes must be; rename it");
  }
  return parse_scene("[volume]\nfile = " + toml_string(volume.string()), "default scene", sets);
}

}  // namespace pvol::formats
