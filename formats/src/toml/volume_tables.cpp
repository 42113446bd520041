#include "toml/volume_tables.h"

#include <fmt/format.h>

#include <algorithm>

#include "pvol/error.h"
#include "toml/read_keys.h"

namespace pvol::formats {
namespace {

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

}  // namespace

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

void read_volumes(const TomlTable& root, SceneFile& file) {
  const auto tables = root.tables("volume");
  const TomlTable* medium_of_first = root.table("medium");
  for (const TomlTable* t : tables) {
    const bool first = file.volumes.empty();
    SceneVolume& v = file.volumes.emplace_back();
    const Entries own = entries(v);
    std::vector<std::string_view> allowed = key_names(own);
    if (!first) allowed.emplace_back("medium");
    if (first && t->has("medium")) {
      t->fail("medium", "no medium here: that of the first volume is [medium]");
    }
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

}  // namespace pvol::formats
