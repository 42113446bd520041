// Volume shaders whose inputs say what pvol's medium says, with the same meaning. UsdPreviewSurface
// has none.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

#include "usda/usda_world.h"

namespace pvol::formats::detail {
namespace {

constexpr double kFarthest = kLargestMeanCosine;
constexpr Vec3d kArnoldsScatter{0.5, 0.5, 0.5};

/// The inputs of a shader: what they say, else what is usual; nothing, and named, of those that
/// another shader makes vary, such as a texture.
struct UsdInputs {
  UsdView view;
  const UsdMaking& making;

  [[nodiscard]] std::optional<UsdInput> find(const std::string& name) const {
    const std::optional<UsdInput> input = valued_input(making.stage, view, name);
    if (!input) {
      making.note(view.find(name)->where,
                  fmt::format("the connection of {} is left out: it leads to no value of a "
                              "material",
                              usd_shown(name)));
    }
    return input;
  }
  [[nodiscard]] std::optional<double> number(const std::string& name, double usual) const {
    const std::optional<UsdInput> input = find("inputs:" + name);
    if (!input) return std::nullopt;
    return making.stage.view(*input->prim).number(input->name, usual);
  }
  [[nodiscard]] std::optional<Vec3d> color(const std::string& name, Vec3d usual) const {
    const std::optional<UsdInput> input = find("inputs:" + name);
    if (!input) return std::nullopt;
    return making.stage.view(*input->prim).vector(input->name, usual);
  }
};

/// Extinction by channel of scattering and absorption together.
void set_coefficients(SceneVolume& v, Vec3d scattering, Vec3d absorption, const UsdView& shader) {
  const Vec3d all = scattering + absorption;
  const double most = max_component(all);
  if (!(min_component(scattering) >= 0 && min_component(absorption) >= 0) || !is_finite(all)) {
    fail_at(shader.where(), "a negative coefficient", "numbers of at least 0");
  }
  v.medium.extinction = most;
  v.has_extinction = true;
  for (int c = 0; c < 3; ++c) {
    v.medium.extinction_color[c] = most > 0 ? float(all[c] / most) : 1;
    v.medium.components.front().albedo[c] = all[c] > 0 ? float(scattering[c] / all[c]) : 0;
  }
}

/// Where it is not known, the phase function stays pvol's.
void set_cosine(SceneVolume& v, std::optional<double> g) {
  if (!g) return;
  v.medium.components.front().phase = HenyeyGreenstein(std::clamp(*g, -kFarthest, kFarthest));
}

/// Arnold: density is the extinction per unit and unit of the field, deepened by `transparent`,
/// what is left after a unit of it; scattered is `scatter_color`.
void take_arnold(const UsdInputs& in, SceneVolume& v) {
  const std::optional<double> density = in.number("density", 1);
  const std::optional<double> scatter = in.number("scatter", 1);
  const std::optional<Vec3d> color = in.color("scatter_color", kArnoldsScatter);
  const std::optional<Vec3d> left = in.color("transparent", Vec3d(std::exp(-1.0)));
  set_cosine(v, in.number("scatter_anisotropy", 0));
  const Vec3d scattered = color.value_or(kArnoldsScatter) * scatter.value_or(1);
  const Vec3d albedo = min(max(scattered, Vec3d(0.0)), Vec3d(1.0));
  v.medium.components.front().albedo = Rgb(albedo);
  if (!density || !left) return;
  Vec3d extinction;
  for (int c = 0; c < 3; ++c) {
    extinction[c] = -std::log(std::clamp((*left)[c], 1e-6, 1.0)) * *density;
  }
  set_coefficients(v, extinction * albedo, extinction * (Vec3d(1.0) - albedo), in.view);
}

/// MaterialX: coefficients per unit of length, where the field is 1.
void take_anisotropic(const UsdInputs& in, SceneVolume& v) {
  const std::optional<Vec3d> scattering = in.color("scattering", {0, 0, 0});
  const std::optional<Vec3d> absorption = in.color("absorption", {0, 0, 0});
  set_cosine(v, in.number("anisotropy", 0));
  if (scattering && absorption) set_coefficients(v, *scattering, *absorption, in.view);
}

void take_absorption(const UsdInputs& in, SceneVolume& v) {
  v.medium.components.front().albedo = Rgb(0.0f);
  if (const auto absorption = in.color("absorption", {0, 0, 0})) {
    set_coefficients(v, {0, 0, 0}, *absorption, in.view);
  }
}

/// To add a shader: its row. Extinction stays open where it rests on inputs that vary.
struct UsdVolumeShader {
  std::string_view id;
  void (*take)(const UsdInputs&, SceneVolume&);
};
constexpr std::array<UsdVolumeShader, 3> kVolumeShaders{{{"arnold:standard_volume", take_arnold},
                                                         {"ND_anisotropic_vdf", take_anisotropic},
                                                         {"ND_absorption_vdf", take_absorption}}};

/// The shader of a material's volume, whatever renderer it is for: outputs:volume,
/// outputs:arnold:volume and so on. ND_volume passes on what it is connected to.
const UsdPrim* volume_shader(const UsdPrim& material, const UsdMaking& making) {
  const UsdView view = making.stage.view(material);
  for (const auto& [name, attribute] : material.attributes) {
    const bool of_volume =
        name == "outputs:volume" || (name.starts_with("outputs:") && name.ends_with(":volume"));
    if (!of_volume || attribute->targets.empty()) continue;
    const UsdPrim* shader = source_of(making.stage, view, name);
    if (shader == nullptr) continue;
    const UsdView inner = making.stage.view(*shader);
    if (inner.word("info:id", "") == "ND_volume") {
      shader = source_of(making.stage, inner, "inputs:vdf");
    }
    if (shader != nullptr) return shader;
  }
  return nullptr;
}

}  // namespace

void set_shading(const UsdItem& volume, SceneVolume& to, const UsdMaking& making) {
  if (volume.material.empty()) return;
  const std::string usual = "; extinction is left open, and albedo and phase function are pvol's";
  const std::string name = usd_shown(volume.material);
  const UsdPrim* material = making.stage.find(volume.material);
  const UsdPrim* shader = material == nullptr ? nullptr : volume_shader(*material, making);
  if (shader == nullptr) {
    making.note(volume.prim->where,
                fmt::format("the material {} has no volume shader{}", name, usual));
    return;
  }
  const UsdInputs in{making.stage.view(*shader), making};
  const std::string id = in.view.word("info:id", "");
  const auto* known = std::ranges::find_if(
      kVolumeShaders, [&](const UsdVolumeShader& s) { return id.starts_with(s.id); });
  if (known == kVolumeShaders.end()) {
    making.note(shader->where,
                fmt::format("the volume shader \"{}\" is left out{}", usd_shown(id), usual));
    return;
  }
  known->take(in, to);
  if (!to.has_extinction) {
    making.note(shader->where, fmt::format("the extinction of the material {} is left open: inputs "
                                           "of its shader vary",
                                           name));
  }
  in.view.note_unused(*making.notes);
}

}  // namespace pvol::formats::detail
