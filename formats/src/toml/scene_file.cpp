#include "pvol/formats/scene_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "pvol/error.h"
#include "toml/phase_file.h"
#include "toml/scene_keys.h"
#include "toml/toml_table.h"

namespace pvol::formats {
namespace {

/// Whether a text under this key, in whatever section, is the name of a file.
bool names_file(std::string_view key) { return key == "file" || key == kPhaseTable; }

/// Makes relative file names of the scene relative to the current folder.
void resolve_files(TomlTable& table, const std::filesystem::path& folder) {
  for (TomlValue& member : table.members) {
    if (auto* text = std::get_if<std::string>(&member.value)) {
      if (names_file(member.key) && !text->empty()) *text = (folder / *text).string();
    } else if (auto* inner = std::get_if<TomlTable>(&member.value)) {
      resolve_files(*inner, folder);
    } else if (auto* array = std::get_if<TomlArray>(&member.value)) {
      for (TomlValue& item : *array) {
        if (auto* row = std::get_if<TomlTable>(&item.value)) resolve_files(*row, folder);
      }
    }
  }
}

std::vector<std::string_view> key_names(const Entries& entries) {
  std::vector<std::string_view> names;
  for (const Entry& e : entries) {
    if (e.about.in_scenes) names.emplace_back(e.about.key);
  }
  return names;
}

/// Sets what the table has of these keys, and refuses keys that are neither theirs nor `besides`.
void read_keys(const TomlTable& table, const Entries& entries,
               const std::vector<std::string_view>& allowed) {
  table.allow_only(allowed);
  for (const Entry& e : entries) {
    const Description& about = e.about;
    if (!table.has(about.key)) {
      if (!about.required) continue;
      if (about.limits.shape == Limits::Shape::file) table.fail(about.key, expected(about.limits));
      table.require({about.key});
    }
    e.assign(*table.take(about.key, about.limits));
  }
  for (const Entry& e : entries) {
    const Description& about = e.about;
    if (*about.goes_with == 0 || !table.has(about.key)) continue;
    if (find_key(entries, about.goes_with)->value() == Value(about.of_value)) continue;
    table.fail(about.key, fmt::format("{} = \"{}\" beside it", about.goes_with, about.of_value));
  }
}
void read_keys(const TomlTable& table, const Entries& entries) {
  read_keys(table, entries, key_names(entries));
}

/// Blames the first of a misfit's keys that the table has.
void refuse_misfit(const TomlTable& table, const std::optional<Misfit>& misfit) {
  if (!misfit) return;
  for (const char* key : misfit->keys) {
    if (table.has(key)) table.fail(key, misfit->expected);
  }
  table.fail(misfit->keys.front(), misfit->expected);
}

bool is_set(const TomlValue& member) { return member.key_where.starts_with("--set "); }
bool is_set(const TomlTable& table, std::string_view key) {
  const TomlValue* found = table.find(key);
  return found != nullptr && is_set(*found);
}

/// Of a closed set the kind whose first key is there, where there is one: first of those that the
/// command line set.
template <class Variant>
void choose_kind(const TomlTable& table, Variant& thing) {
  for (const bool by_set : {true, false}) {
    for (Variant& kind : all_kinds<Variant>()) {
      const char* const key = entries(kind).front().about.key;
      if (by_set ? !is_set(table, key) : !table.has(key)) continue;
      thing = std::move(kind);
      return;
    }
  }
}

/// Without the keys of the file that belong to another kind, where the command line chose one by
/// `key`.
template <class Variant>
TomlTable of_chosen_kind(TomlTable table, std::string_view key,
                         const std::vector<std::string_view>& allowed) {
  if (!is_set(table, key)) return table;
  std::vector<Variant> kinds = all_kinds<Variant>();
  const auto is_known = [&](const std::string& name) {
    return std::any_of(kinds.begin(), kinds.end(),
                       [&](Variant& kind) { return find_key(entries(kind), name) != nullptr; });
  };
  std::erase_if(table.members, [&](const TomlValue& m) {
    return !is_set(m) && is_known(m.key) &&
           std::find(allowed.begin(), allowed.end(), m.key) == allowed.end();
  });
  return table;
}

/// The key that tells the phase function from others.
std::string_view first_key(const PhaseFunction& phase) { return entries(phase).front().about.key; }

/// Refuses the first key of a phase function other than the chosen one.
void refuse_other_phases(const TomlTable& table, const PhaseFunction& chosen) {
  const std::string_view own = first_key(chosen);
  for (PhaseFunction& kind : all_kinds<PhaseFunction>()) {
    if (kind.index() == chosen.index()) continue;
    for (const Entry& e : entries(kind)) {
      const TomlValue* const found = table.find(e.about.key);
      if (found == nullptr) continue;
      if (!table.has(own)) {
        throw Error(fmt::format("{}: {} goes with {}; add that", found->key_where, found->key,
                                first_key(kind)));
      }
      throw Error(fmt::format("{}: {} and {} are of two phase functions; leave one of them out",
                              found->key_where, found->key, own));
    }
  }
}

/// The keys, with those of all phase functions behind that of the chosen one.
std::vector<std::string_view> with_phases(std::vector<std::string_view> keys,
                                          const PhaseFunction& chosen) {
  std::vector<std::string_view> others;
  for (const PhaseFunction& kind : all_kinds<PhaseFunction>()) {
    if (kind.index() != chosen.index()) others.push_back(first_key(kind));
  }
  const auto own = std::find(keys.begin(), keys.end(), first_key(chosen));
  keys.insert(own + 1, others.begin(), others.end());
  return keys;
}

void read_camera(const TomlTable& table, SceneFile& file) {
  Camera& camera = file.scene.camera;
  Entries all = entries(camera);
  const bool by_matrix = table.has("matrix");
  file.has_camera = by_matrix || table.has("position") || table.has("target");
  if (by_matrix || !file.has_camera) {  // framed; the rest holds
    for (Entry& e : all) e.about.required = false;
  }
  for (const char* key : {"position", "target", "up"}) {
    if (by_matrix && table.has(key)) table.fail(key, "either a matrix or position, target and up");
  }
  for (const char* key : {"azimuth", "elevation", "zoom"}) {
    if (!file.has_camera || !table.has(key)) continue;
    table.fail(key,
               "none for a camera with a position; leave the position out to frame the clouds");
  }
  read_keys(table, all);
  if (file.has_camera) refuse_misfit(table, misfit(camera));
}

void read_fire(const TomlTable& table, SceneVolume& volume) {
  Fire& fire = volume.fire.emplace();
  read_keys(table, entries(fire));
  refuse_misfit(table, misfit(fire));
  volume.has_intensity = table.has("intensity");
}

void read_albedo_field(const TomlTable& table, SceneVolume& volume) {
  AlbedoMap& map = volume.albedo_field.emplace();
  read_keys(table, entries(map));
  refuse_misfit(table, misfit(map));
}

/// The medium and the placement of a volume. The table itself describes the first component, which
/// has the share that the others leave.
void read_medium(const TomlTable& given, SceneVolume& volume, Placement& placement) {
  Medium& medium = volume.medium;
  Component& first = medium.components.front();
  choose_kind(given, first.phase);
  const Entries component = joined(entries(medium), without(entries(first), "share"));
  const Entries place = entries(placement);
  std::vector<std::string_view> allowed = key_names(component);
  allowed.emplace_back("component");
  allowed.emplace_back("density");
  allowed.emplace_back("fire");
  allowed.emplace_back("motion");
  allowed.emplace_back("albedo_field");
  for (const std::string_view key : key_names(place)) allowed.push_back(key);
  const TomlTable table = of_chosen_kind<PhaseFunction>(given, first_key(first.phase), allowed);
  if (const TomlValue* albedo = table.find("albedo");
      albedo != nullptr && std::holds_alternative<TomlTable>(albedo->value)) {
    table.fail("albedo", "a number or three; set a grid of albedos in [medium.albedo_field]");
  }
  refuse_other_phases(table, first.phase);
  read_keys(table, joined(component, place), with_phases(allowed, first.phase));
  refuse_misfit(table, misfit(placement));
  volume.has_extinction = table.has("extinction");
  volume.object_to_world = placement.map();
  if (const TomlTable* map = table.table("density")) {
    read_keys(*map, entries(volume.density_map));
  }
  if (const TomlTable* fire = table.table("fire")) read_fire(*fire, volume);
  if (const TomlTable* motion = table.table("motion")) {
    read_keys(*motion, entries(volume.velocity.emplace()));
  }
  if (const TomlTable* field = table.table("albedo_field")) read_albedo_field(*field, volume);
  for (const TomlTable* t : table.tables("component")) {
    Component c;
    choose_kind(*t, c.phase);
    const Entries own = entries(c);
    const TomlTable rest = of_chosen_kind<PhaseFunction>(*t, first_key(c.phase), key_names(own));
    refuse_other_phases(rest, c.phase);
    read_keys(rest, own, with_phases(key_names(own), c.phase));
    medium.components.push_back(c);
    if (!share_rest(medium)) t->fail("share", "shares of the components that sum up to at most 1");
  }
}

/// Where what has a placement is a frame later.
MovingPlacement read_to(const TomlTable& table, const Placement& from) {
  MovingPlacement moving{from, from};
  Placement& to = moving.to;
  if (table.has("matrix")) to = {};  // it says all
  const Entries own = entries(to);
  if (from.matrix && !table.has("matrix")) {
    for (const std::string_view key : key_names(own)) {
      if (table.has(key)) table.fail(key, "a matrix, since the first placement has one");
    }
  }
  read_keys(table, own);
  refuse_misfit(table, misfit(to));
  refuse_misfit(table, misfit(moving));
  return moving;
}

/// Places of a volume after that of its medium.
void read_instances(const TomlTable& table, SceneVolume& volume) {
  for (const TomlTable* t : table.tables("instance")) {
    Placement placement;
    const Entries own = entries(placement);
    std::vector<std::string_view> allowed = key_names(own);
    allowed.emplace_back("to");
    read_keys(*t, own, allowed);
    refuse_misfit(*t, misfit(placement));
    volume.instances.push_back(placement.map());
    const TomlTable* to = t->table("to");
    if (to == nullptr) continue;
    volume.moving_instances.resize(volume.instances.size());
    volume.moving_instances.back() = read_to(*to, placement);
  }
}

/// The volumes of a scene: the first has the scene's [medium], the others one of their own.
void read_volumes(const TomlTable& root, SceneFile& file) {
  const auto tables = root.tables("volume");
  const TomlTable* medium_of_first = root.table("medium");
  for (const TomlTable* t : tables) {
    const bool first = file.volumes.empty();
    SceneVolume& v = file.volumes.emplace_back();
    const Entries own = entries(v);
    std::vector<std::string_view> allowed = key_names(own);
    if (!first) allowed.emplace_back("medium");
    allowed.emplace_back("instance");
    allowed.emplace_back("to");
    read_keys(*t, own, allowed);
    read_instances(*t, v);
    const TomlTable* medium = first ? medium_of_first : t->table("medium");
    Placement placement;
    if (medium) read_medium(*medium, v, placement);
    if (const TomlTable* to = t->table("to")) v.moving = read_to(*to, placement);
  }
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

void read_environment(const TomlTable& table, UpAxis axis, Environment& environment) {
  std::vector<Environment> kinds = usual_skies(axis);
  std::vector<std::string_view> names;
  for (const Environment& kind : kinds) names.emplace_back(kind_name(kind));
  if (const auto type = table.word("type", names)) {
    const auto at = std::find(names.begin(), names.end(), *type);
    environment = std::move(kinds[std::size_t(at - names.begin())]);
  } else {
    choose_kind(table, environment);
    environment = std::move(kinds[environment.index()]);
  }
  const Entries own = entries(environment);
  std::vector<std::string_view> allowed = key_names(own);
  allowed.insert(allowed.begin(), "type");
  read_keys(of_chosen_kind<Environment>(table, "type", allowed), own, allowed);
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

void read_surfaces(const TomlTable& root, UpAxis axis, std::vector<Surface>& surfaces) {
  for (const Surface& kind : all_kinds<Surface>()) {
    for (const TomlTable* table : root.tables(kind_name(kind))) {
      Surface& surface = surfaces.emplace_back(kind);
      if (auto* plane = std::get_if<PlaneSurface>(&surface)) plane->normal = up_of(axis);
      read_keys(*table, entries(surface));
      refuse_misfit(*table, misfit(surface));
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

}  // namespace

SceneFile read_scene(const std::filesystem::path& file, const std::vector<std::string>& sets) {
  TomlTable root = parse_toml_file(file);
  resolve_files(root, file.parent_path());
  apply_sets(root, sets);
  load_phase_files(root);
  return read_table(root);
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
  return parse_scene("[volume]\nfile = " + toml_string(volume.string()), "default scene", sets);
}

}  // namespace pvol::formats
