// Colours of surfaces.
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "usda/usda_world.h"

namespace pvol::formats::detail {
namespace {

constexpr double kUsualAlbedo = 0.5;

Rgb within_one(Vec3d color) { return Rgb(min(max(color, Vec3d(0.0)), Vec3d(1.0))); }

/// Materials and node graphs pass on what their inputs and outputs are connected to.
bool passes_on(const UsdPrim& prim) { return prim.type == "Material" || prim.type == "NodeGraph"; }

/// Where the connections of an input or output end: at another shader, or at the last one that
/// says a value; at none where there is no such.
UsdInput end_of(const UsdStage& stage, const UsdPrim& prim, const std::string& name) {
  constexpr int kMostConnections = 64;  // in a row: they may lead to themselves
  UsdInput at{&prim, name}, valued;
  for (int i = 0; i < kMostConnections; ++i) {
    const UsdView view = stage.view(*at.prim);
    if (view.says(at.name)) valued = at;
    const UsdAttribute* a = view.find(at.name);
    if (a == nullptr || a->targets.empty()) break;
    const std::string path = items_of(a->targets).front().path;
    const std::size_t dot = std::min(path.find('.'), path.size());
    const UsdPrim* next = stage.find(path.substr(0, dot));
    if (next == nullptr) break;
    at = {next, path.substr(std::min(dot + 1, path.size()))};
    if (!passes_on(*next)) return at;
  }
  return valued;
}

/// The even colour of a UsdPreviewSurface; nothing, and named, for all else.
std::optional<Vec3d> color_of_material(const UsdPrim& material, const UsdMaking& making) {
  const UsdView view = making.stage.view(material);
  const UsdPrim* shader = source_of(making.stage, view, "outputs:surface");
  const std::string name = usd_shown(material.name);
  if (shader == nullptr) return std::nullopt;
  const UsdView inputs = making.stage.view(*shader);
  const std::optional<UsdInput> color = valued_input(making.stage, inputs, "inputs:diffuseColor");
  if (inputs.word("info:id", "") != "UsdPreviewSurface" || !color) {
    making.note(shader->where, fmt::format("the material \"{}\" is taken as diffuse, of the "
                                           "displayColor or 0.5",
                                           name));
    return std::nullopt;
  }
  making.note(shader->where,
              fmt::format("the material \"{}\" is taken as diffuse, of its diffuseColor", name));
  return making.stage.view(*color->prim).vector(color->name, Vec3d(0.18));  // USD's own
}

bool is_constant(const UsdAttribute& primvar) {
  const auto found = primvar.words.find("interpolation");
  return found == primvar.words.end() || found->second == "constant";
}

/// The prim that says a primvar of a surface, or null: itself, else the nearest one around it, if
/// it is constant there.
const UsdPrim* prim_with(const std::string& primvar, const UsdItem& surface,
                         const UsdStage& stage) {
  for (std::string path = surface.path; !path.empty(); path.resize(path.rfind('/'))) {
    const bool is_own = path == surface.path;
    const UsdPrim* prim = is_own ? surface.prim : stage.find(path);
    if (prim == nullptr || !stage.view(*prim).says(primvar)) continue;
    return is_own || is_constant(*prim->attributes.at(primvar)) ? prim : nullptr;
  }
  return nullptr;
}

/// The colours of a primvar, each as often as its indices name it, if there are any.
std::vector<Vec3d> colors_of(const UsdView& view, const std::string& name,
                             const UsdMaking& making) {
  const std::vector<Vec3d> table = view.vectors(name);
  const std::vector<double> indices = view.numbers(name + ":indices");
  if (indices.empty()) return table;
  std::vector<Vec3d> all;
  for (const double i : indices) {
    if (i >= 0 && i < double(table.size())) all.push_back(table[std::size_t(i)]);
  }
  if (all.size() < indices.size()) {
    making.note(view.where(), fmt::format("indices of {} that are not from 0 to {}, for as many "
                                          "colours, are left out",
                                          usd_shown(name), double(table.size()) - 1));
  }
  return all;
}

/// The mean of what may vary over the surface.
Vec3d display_color(const UsdItem& surface, const UsdMaking& making) {
  const std::string name = "primvars:displayColor";
  const UsdPrim* prim = prim_with(name, surface, making.stage);
  if (prim == nullptr) return Vec3d(kUsualAlbedo);
  const UsdView view = making.stage.view(*prim);
  const std::vector<Vec3d> all = colors_of(view, name, making);
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
  shader.ignore(name);
  const UsdPrim* end = end_of(stage, shader.prim(), name).prim;
  return end == nullptr || end == &shader.prim() || passes_on(*end) ? nullptr : end;
}

std::optional<UsdInput> valued_input(const UsdStage& stage, const UsdView& shader,
                                     const std::string& name) {
  const UsdAttribute* a = shader.find(name);
  if (a == nullptr || a->targets.empty()) return UsdInput{&shader.prim(), name};
  const UsdInput end = end_of(stage, shader.prim(), name);
  const bool is_known = end.prim == &shader.prim() || (end.prim != nullptr && passes_on(*end.prim));
  return is_known ? std::optional(end) : std::nullopt;
}

Rgb albedo_of(const UsdItem& surface, const UsdMaking& making) {
  const Vec3d own = display_color(surface, making);
  const UsdPrim* material = making.stage.find(surface.material);
  const auto color = material == nullptr ? std::nullopt : color_of_material(*material, making);
  return within_one(color.value_or(own));
}

}  // namespace pvol::formats::detail
