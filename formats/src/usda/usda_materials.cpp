// Colours of surfaces.
#include <fmt/format.h>

#include <algorithm>

#include "usda/usda_world.h"

namespace pvol::formats::detail {
namespace {

constexpr double kUsualAlbedo = 0.5;

Rgb within_one(Vec3d color) { return Rgb(min(max(color, Vec3d(0.0)), Vec3d(1.0))); }

/// The even colour of a UsdPreviewSurface; nothing, and named, for all else.
std::optional<Vec3d> color_of_material(const UsdPrim& material, const UsdMaking& making) {
  const UsdView view = making.stage.view(material);
  const UsdPrim* shader = source_of(making.stage, view, "outputs:surface");
  const std::string name = usd_shown(material.name);
  if (shader == nullptr) return std::nullopt;
  const UsdView inputs = making.stage.view(*shader);
  const UsdAttribute* color = inputs.find("inputs:diffuseColor");
  const bool is_even = color == nullptr || color->sources.empty();
  if (inputs.word("info:id", "") != "UsdPreviewSurface" || !is_even) {
    making.note(shader->where, fmt::format("the material \"{}\" is taken as diffuse, of the "
                                           "displayColor or 0.5",
                                           name));
    return std::nullopt;
  }
  making.note(shader->where,
              fmt::format("the material \"{}\" is taken as diffuse, of its diffuseColor", name));
  return inputs.vector("inputs:diffuseColor", Vec3d(0.18));  // USD's own
}

/// The mean of what may vary over the surface.
Vec3d display_color(const UsdView& view, const UsdMaking& making) {
  const std::string name = "primvars:displayColor";
  const std::vector<Vec3d> all = view.vectors(name);
  if (all.empty()) return Vec3d(kUsualAlbedo);
  Vec3d sum;
  for (const Vec3d c : all) sum += c;
  const bool varies = std::ranges::any_of(all, [&](Vec3d c) { return !(c == all.front()); });
  if (varies) {
    making.note(view.find(name)->where, "a displayColor that varies becomes its mean");
  }
  return varies ? sum / double(all.size()) : all.front();
}

}  // namespace

const UsdPrim* source_of(const UsdStage& stage, const UsdView& shader, const std::string& name) {
  const UsdAttribute* a = shader.find(name);
  if (a == nullptr || a->sources.empty()) return nullptr;
  const std::string& path = a->sources.front().path;
  return stage.find(path.substr(0, path.find('.')));  // without the output
}

Rgb albedo_of(const UsdItem& surface, const UsdView& view, const UsdMaking& making) {
  const Vec3d own = display_color(view, making);
  const UsdPrim* material = making.stage.find(surface.material);
  const auto color = material == nullptr ? std::nullopt : color_of_material(*material, making);
  return within_one(color.value_or(own));
}

}  // namespace pvol::formats::detail
