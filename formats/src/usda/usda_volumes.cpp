// UsdVol's Volumes: what their fields are is told by their names, as pvol does it of files.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <span>
#include <string_view>
#include <utility>

#include "file/grid_names.h"
#include "usda/usda_fields.h"
#include "usda/usda_world.h"

namespace pvol::formats::detail {
namespace {

// In the order in which they are looked for.
constexpr std::string_view kDensityRoles[] = {"density"};
constexpr std::string_view kFlameRoles[] = {"flames", "flame", "fire", "burn", "heat", "emission"};
constexpr std::string_view kTemperatureRoles[] = {"temperature", "temp", "heat"};
constexpr std::string_view kVelocityRoles[] = {"v", "vel", "velocity"};
constexpr std::string_view kColorRoles[] = {"Cd", "color", "colour", "albedo"};

/// The fields of a volume that are still to be given a use.
class UsdFields {
 public:
  explicit UsdFields(std::vector<UsdField> fields) : all_(std::move(fields)) {}

  /// The first field of one of the names; nothing where there is none.
  std::optional<UsdField> take(std::span<const std::string_view> roles) {
    for (const std::string_view role : roles) {
      for (UsdField& f : all_) {
        if (!same_name(f.role, role)) continue;
        used_.insert(f.role);
        return f;
      }
    }
    return std::nullopt;
  }

  /// The only one.
  std::optional<UsdField> take_only() {
    if (all_.size() != 1) return std::nullopt;
    used_.insert(all_.front().role);
    return all_.front();
  }

  /// What has no use.
  [[nodiscard]] std::vector<UsdField> rest() const {
    std::vector<UsdField> rest;
    for (const UsdField& f : all_) {
      if (!used_.contains(f.role)) rest.push_back(f);
    }
    return rest;
  }

 private:
  std::vector<UsdField> all_;
  std::set<std::string> used_{};
};

void note_field(const UsdField& field, const std::string& why, const UsdMaking& making) {
  making.note(field.where,
              fmt::format("the field \"{}\" is left out{}", usd_shown(field.role), why));
}

/// Whether a field is in the file of the density, where pvol looks for it.
bool is_beside(const SceneVolume& v, const std::optional<UsdField>& field,
               const UsdMaking& making) {
  if (!field || field->file == v.file) return field.has_value();
  note_field(*field, ": it is in another file than the density", making);
  return false;
}

/// Light by flames, of the colour of black bodies by the temperature.
void set_flames(SceneVolume& v, const UsdField& flames, const std::optional<UsdField>& hot,
                const UsdMaking& making) {
  Fire& fire = v.fire.emplace();
  fire.field = flames.grid;
  fire.kelvin = 1;
  fire.color_by = hot ? hot->grid : flames.grid;
  making.note(flames.where,
              fmt::format("the field \"{}\" becomes a fire, coloured by {} in Kelvin, "
                          "as pvol takes it of files",
                          usd_shown(flames.role), usd_shown(fire.color_by)));
}

/// Density, or a fire alone; false where there is neither.
bool set_matter(SceneVolume& v, UsdFields& fields, const UsdMaking& making) {
  std::optional<UsdField> density = fields.take(kDensityRoles);
  std::optional<UsdField> flames = fields.take(kFlameRoles), hot = fields.take(kTemperatureRoles);
  if (!density && !flames && !hot) density = fields.take_only();
  if (!density && !flames) flames = hot;  // without smoke, temperatures are those of a fire
  if (!density && !flames) return false;
  v.file = density ? density->file : flames->file;
  v.grid = density ? density->grid : kNoGrid;
  if (!is_beside(v, hot, making)) hot.reset();
  if (is_beside(v, flames, making)) {
    set_flames(v, *flames, hot, making);
  } else if (hot) {
    note_field(*hot, ": temperatures alone are no fire; for one, add [medium.fire]", making);
  }
  return true;
}

void set_motion(SceneVolume& v, UsdFields& fields) {
  const std::optional<UsdField> velocity = fields.take(kVelocityRoles);
  if (!velocity) return;
  VelocityChoice& choice = v.velocity.emplace();
  choice.field = velocity->grid;
  if (velocity->file != v.file) choice.file = velocity->file;
}

/// Its place, and those of its instances.
void set_place(SceneVolume& v, const UsdItem& item, const UsdMaking& making) {
  if (item.instances.empty()) {
    v.object_to_world = item.place.now;
    v.moving = motion_of(item.place, item, making);
    return;
  }
  bool moves = false;
  for (const UsdPlace& instance : item.instances) {
    const UsdPlace place = instance * item.place;
    v.instances.push_back(place.now);
    moves = moves || place.moves();
  }
  for (std::size_t i = 0; moves && i < item.instances.size(); ++i) {
    v.moving_instances.push_back(motion_of(item.instances[i] * item.place, item, making));
  }
}

/// What tells volumes apart besides their places.
std::string likeness_of(const UsdItem& item, const std::vector<UsdField>& fields) {
  std::string all = item.material;
  for (const UsdField& f : fields) {
    all += '\n' + f.role + '\n' + f.file.string() + '\n' + f.grid;
  }
  return all;
}

/// Volumes by what they are like.
using UsdAlike = std::map<std::string, std::size_t>;

/// Adds it, as an instance where there is one that differs only in its place. Still ones only.
void add_volume(std::vector<SceneVolume>& all, SceneVolume v, const std::string& likeness,
                UsdAlike& alike) {
  if (!v.instances.empty() || v.moving) {
    all.push_back(std::move(v));
    return;
  }
  const auto [first, is_new] = alike.emplace(likeness, all.size());
  if (is_new) {
    all.push_back(std::move(v));
    return;
  }
  SceneVolume& like = all[first->second];
  if (like.instances.empty()) like.instances = {std::exchange(like.object_to_world, {})};
  like.instances.push_back(v.object_to_world);
}

void make_volume(const UsdItem& item, const UsdMaking& making, UsdAlike& alike) {
  const UsdView view = making.stage.view(*item.prim);
  const std::vector<UsdField> all = fields_of(view, making);
  UsdFields fields(all);
  SceneVolume v;
  if (!set_matter(v, fields, making)) {
    making.note(item.prim->where, fmt::format("volume {} is left out: it has neither density nor "
                                              "flames in a .vdb file",
                                              usd_shown(item.path)));
    return;
  }
  set_motion(v, fields);
  if (const auto color = fields.take(kColorRoles); is_beside(v, color, making)) {
    v.albedo_field.emplace().grid = color->grid;
  }
  for (const UsdField& field : fields.rest()) note_field(field, "", making);
  set_shading(item, v, making);
  set_place(v, item, making);
  for (const char* name : {"extent", "primvars:displayColor", "primvars:displayOpacity"}) {
    view.ignore(name);  // for viewers
  }
  view.note_unused(*making.notes);
  add_volume(making.scene->file.volumes, std::move(v), likeness_of(item, all), alike);
}

}  // namespace

void make_volumes(const UsdMaking& making) {
  UsdAlike alike;
  for (const UsdItem& item : making.stage.volumes) make_volume(item, making, alike);
}

}  // namespace pvol::formats::detail
