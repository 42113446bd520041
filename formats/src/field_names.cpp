#include "pvol/formats/field_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string_view>

#include "file/grid_names.h"
#include "pvol/error.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/color.h"

namespace pvol::formats {
namespace {

// The names in the order in which they are looked for.
constexpr std::string_view kDensityNames[] = {"density"};
constexpr std::string_view kFireNames[] = {"flames", "flame",    "fire",       "burn",
                                           "heat",   "emission", "temperature"};
constexpr std::span<const std::string_view> kFlameNames(kFireNames, std::size(kFireNames) - 1);
constexpr std::string_view kTemperatureNames[] = {"temperature", "temp", "heat"};

using detail::listed;
using detail::same_name;

/// The first of the names that a usable grid has, as the file writes it; else "".
std::string first_of(std::span<const std::string_view> names, std::span<const GridEntry> grids) {
  for (const std::string_view name : names) {
    for (const GridEntry& g : grids) {
      if (g.usable && same_name(g.name, name)) return g.name;
    }
  }
  return {};
}

bool is_called_density(const GridEntry& g) {
  return std::ranges::any_of(kDensityNames, [&](auto n) { return same_name(g.name, n); });
}

/// Why a volume has no density.
std::string only_a_fire(std::span<const GridEntry> grids) {
  const auto other = std::ranges::find_if(grids, [&](const GridEntry& g) {
    const bool is_read =
        g.type.starts_with("float") || g.type.starts_with("half") || g.type.starts_with("double");
    return is_called_density(g) && !g.usable && !is_read && g.type != "empty";
  });
  if (other == grids.end()) return "no grid is called density: the volume has only a fire";
  return fmt::format(
      "the grid {} holds {}, which pvol does not read as a density: the volume has only a fire",
      other->name, other->type);
}

}  // namespace

std::vector<std::string> usual_fire_grids(std::span<const GridEntry> grids) {
  std::vector<std::string> all;
  for (std::string name : {first_of(kFireNames, grids), first_of(kTemperatureNames, grids)}) {
    if (!name.empty() && (all.empty() || all.front() != name)) all.push_back(std::move(name));
  }
  return all;
}

bool has_flames(std::span<const GridEntry> grids) { return !first_of(kFlameNames, grids).empty(); }

bool lacks_grid(const Fire& fire, std::span<const GridEntry> grids) {
  if (fire.field.empty()) return first_of(kFireNames, grids).empty();
  const std::string_view field = fire.field;
  return first_of({&field, 1}, grids).empty();
}

bool lacks_density(std::span<const GridEntry> grids) {
  const auto usable = std::ranges::count_if(grids, [](const GridEntry& g) { return g.usable; });
  const bool empty = std::ranges::any_of(
      grids, [](const GridEntry& g) { return !g.usable && is_called_density(g); });
  return (usable > 1 || (empty && usable > 0)) && first_of(kDensityNames, grids).empty();
}

std::vector<std::string> bind_fields(SceneVolume& v, std::span<const GridEntry> grids) {
  std::vector<std::string> notes;
  if (v.grid.empty() && lacks_density(grids) && (v.fire || !first_of(kFireNames, grids).empty())) {
    v.grid = kNoGrid;
    notes.push_back(only_a_fire(grids));
  } else if (v.grid.empty() && v.shows_fire && !v.fire && has_flames(grids)) {
    v.fire.emplace();
    notes.push_back("it burns (--grid density shows the smoke alone)");
  }
  if (v.grid == kNoGrid && !v.fire) v.fire.emplace().kelvin = 1;
  if (!v.fire) return notes;
  Fire& fire = *v.fire;
  if (v.shows_fire && !fire.colored()) fire.kelvin = 1;
  if (fire.field.empty()) {
    fire.field = first_of(kFireNames, grids);
    if (fire.field.empty()) {
      throw Error(
          fmt::format("{}: no grid is called flames, heat, temperature or the like, so the fire "
                      "has no field; name one with medium.fire.field; the file has: {}",
                      v.file.string(), listed(grids)));
    }
    notes.push_back("the fire uses the grid " + fire.field);
  }
  const std::string temperature = first_of(kTemperatureNames, grids);
  if (fire.color_by.empty() && fire.colored()) {
    fire.color_by = temperature.empty() ? fire.field : temperature;
    notes.push_back("its colour uses the grid " + fire.color_by);
  }
  return notes;
}

std::vector<std::string> bind_albedo(SceneVolume& v, std::span<const GridEntry> grids) {
  if (v.grid == kNoGrid || (v.albedo_field && !v.albedo_field->grid.empty())) return {};
  const std::string name = usual_color_grid(grids);
  if (name.empty()) {
    if (!v.albedo_field) return {};
    throw Error(fmt::format(
        "{}: no grid of colours is called Cd, color, colour or albedo, so the albedo has no field; "
        "name one, or a grid of numbers, with medium.albedo_field.grid; the file has: {}",
        v.file.string(), listed(grids)));
  }
  if (!v.albedo_field && ending(v.file) == ".nvdb") {
    return {"the colours of the grid " + name +
            " are ignored: they are read from .vdb and .pvol files only"};
  }
  if (!v.albedo_field) v.albedo_field.emplace();
  v.albedo_field->grid = name;
  return {"the albedo uses the colours of the grid " + name +
          " (--set medium.albedo_field.grid=none ignores them)"};
}

}  // namespace pvol::formats
