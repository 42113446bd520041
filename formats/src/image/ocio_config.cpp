// OCIO configurations, by OpenColorIO.
#include <OpenColorIO/OpenColorIO.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <initializer_list>
#include <sstream>

#include "image/color_config.h"
#include "pvol/error.h"
#include "pvol/formats/screen.h"

namespace pvol::formats::detail {
namespace {

namespace ocio = OCIO_NAMESPACE;

constexpr const char* kVariable = "OCIO";

/// Used where nobody names another one. All transforms are OpenColorIO's own.
constexpr const char* kOwnConfig = R"(ocio_profile_version: 2
roles: {aces_interchange: ACES2065-1, cie_xyz_d65_interchange: CIE-XYZ-D65,
        scene_linear: ACEScg, default: ACES2065-1}
file_rules: [!<Rule> {name: Default, colorspace: default}]
displays:
  sRGB:
    - !<View> {name: ACES 1.0, view_transform: ACES 1.0, display_colorspace: sRGB}
    - !<View> {name: Un-tone-mapped, view_transform: Un-tone-mapped, display_colorspace: sRGB}
  Display P3:
    - !<View> {name: ACES 1.0, view_transform: ACES 1.0, display_colorspace: Display P3}
    - !<View> {name: Un-tone-mapped, view_transform: Un-tone-mapped, display_colorspace: Display P3}
  Rec.1886:
    - !<View> {name: ACES 1.0, view_transform: ACES 1.0, display_colorspace: Rec.1886}
    - !<View> {name: Un-tone-mapped, view_transform: Un-tone-mapped, display_colorspace: Rec.1886}
active_displays: [sRGB, Display P3, Rec.1886]
active_views: [ACES 1.0, Un-tone-mapped]
default_view_transform: Un-tone-mapped
view_transforms:
  - !<ViewTransform>
    name: ACES 1.0
    from_scene_reference: !<BuiltinTransform>
      style: ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - SDR-VIDEO_1.0
  - !<ViewTransform>
    name: Un-tone-mapped
    from_scene_reference: !<BuiltinTransform> {style: UTILITY - ACES-AP0_to_CIE-XYZ-D65_BFD}
display_colorspaces:
  - !<ColorSpace> {name: CIE-XYZ-D65}
  - !<ColorSpace>
    name: sRGB
    from_display_reference: !<BuiltinTransform> {style: DISPLAY - CIE-XYZ-D65_to_sRGB}
  - !<ColorSpace>
    name: Display P3
    from_display_reference: !<GroupTransform>
      children:
        - !<MatrixTransform>
          matrix: [2.4934969119, -0.9313836179, -0.4027107845, 0, -0.8294889696, 1.7626640603,
                   0.0236246858, 0, 0.0358458302, -0.0761723893, 0.9568845240, 0, 0, 0, 0, 1]
        - !<ExponentWithLinearTransform> {gamma: 2.4, offset: 0.055, direction: inverse}
  - !<ColorSpace>
    name: Rec.1886
    from_display_reference: !<BuiltinTransform> {style: DISPLAY - CIE-XYZ-D65_to_REC.1886-REC.709}
colorspaces:
  - !<ColorSpace> {name: ACES2065-1, aliases: [aces2065_1], encoding: scene-linear}
  - !<ColorSpace>
    name: ACEScg
    aliases: [acescg, lin_ap1]
    encoding: scene-linear
    to_scene_reference: !<BuiltinTransform> {style: ACEScg_to_ACES2065-1}
  - !<ColorSpace>
    name: sRGB - Texture
    aliases: [srgb_tx, srgb_texture]
    to_scene_reference: !<GroupTransform>
      children:
        - !<ExponentWithLinearTransform> {gamma: 2.4, offset: 0.055}
        - !<MatrixTransform>
          matrix: [0.4396329819, 0.3829886982, 0.1773783199, 0, 0.0897764430, 0.8134394287,
                   0.0967841283, 0, 0.0175411704, 0.1115465533, 0.8709122763, 0, 0, 0, 0, 1]
)";

/// Empty where nobody names one.
std::string config_file() {
  const char* const file = std::getenv(kVariable);
  return file != nullptr ? file : "";
}

/// The work's result, with the configuration's name before what OpenColorIO says of it.
template <class Work>
auto naming_config(const Work& work) {
  try {
    return work();
  } catch (const ocio::Exception& e) {
    const std::string file = config_file();
    throw Error(
        fmt::format("the OCIO configuration {}: {}", file.empty() ? "of pvol" : file, e.what()));
  }
}

ocio::ConstConfigRcPtr read_config() {
  if (const std::string file = config_file(); !file.empty()) {
    return ocio::Config::CreateFromFile(file.c_str());
  }
  std::istringstream own(kOwnConfig);
  return ocio::Config::CreateFromStream(own);
}

/// A space of a configuration whose primaries are known here.
struct LinearSpace {
  const char* name;
  ColorSpace space;
};

/// The role that OCIO 2 has for this purpose, else names that are usual for `wanted` and, of
/// configurations that lack it, for others.
LinearSpace linear_space(const ocio::Config& config, ColorSpace wanted) {
  constexpr LinearSpace kUsual[] = {{"acescg", ColorSpace::acescg},
                                    {"ACES - ACEScg", ColorSpace::acescg},
                                    {"lin_ap1", ColorSpace::acescg},
                                    {"lin_rec709", ColorSpace::rec709},
                                    {"lin_rec709_srgb", ColorSpace::rec709},
                                    {"Linear Rec.709 (sRGB)", ColorSpace::rec709},
                                    {"Linear Rec.709", ColorSpace::rec709},
                                    {"Utility - Linear - Rec.709", ColorSpace::rec709},
                                    {"Utility - Linear - sRGB", ColorSpace::rec709},
                                    {"Linear", ColorSpace::rec709},
                                    {"ACES2065-1", ColorSpace::aces},
                                    {"ACES - ACES2065-1", ColorSpace::aces}};
  if (config.hasRole("aces_interchange")) return {"aces_interchange", ColorSpace::aces};
  const LinearSpace* found = nullptr;
  for (const LinearSpace& usual : kUsual) {
    if (!config.getColorSpace(usual.name)) continue;
    if (found == nullptr || (found->space != wanted && usual.space == wanted)) found = &usual;
  }
  if (found != nullptr) return *found;
  throw ocio::Exception(
      "expected the role aces_interchange, or a colour space called ACEScg, lin_rec709 or "
      "ACES2065-1; add one of them");
}

/// Maps colours in place, some at a time in single precision.
template <class Color>
void apply(const ocio::CPUProcessor& processor, std::span<Color> colors) {
  constexpr std::size_t kBlock = 1 << 14;
  std::vector<float> values;
  for (std::size_t begin = 0; begin < colors.size(); begin += kBlock) {
    const auto block = colors.subspan(begin, std::min(kBlock, colors.size() - begin));
    values.clear();
    for (const Color& c : block) values.insert(values.end(), {float(c.x), float(c.y), float(c.z)});
    ocio::PackedImageDesc image(values.data(), long(block.size()), 1, 3);
    processor.apply(image);
    for (std::size_t i = 0; i < block.size(); ++i) {
      block[i] = Color(Vec3f(values[3 * i], values[3 * i + 1], values[3 * i + 2]));
    }
  }
}

/// A view as `views_of_config` names it, and as its configuration does.
struct NamedView {
  std::string name, display, view;
};

std::vector<NamedView> list_views(const ocio::Config& config) {
  std::vector<NamedView> all;
  const std::string first = config.getDefaultDisplay();
  std::vector<std::string> displays{first};
  for (int d = 0; d < config.getNumDisplays(); ++d) {
    if (const std::string display = config.getDisplay(d); display != first) {
      displays.push_back(display);
    }
  }
  for (const std::string& display : displays) {
    for (int v = 0; v < config.getNumViews(display.c_str()); ++v) {
      const std::string view = config.getView(display.c_str(), v);
      all.push_back({display == first ? view : display + '/' + view, display, view});
    }
  }
  return all;
}

bool names_srgb(std::string text) {
  for (char& c : text) c = char(std::tolower(static_cast<unsigned char>(c)));
  return text.find("srgb") != std::string::npos;
}

std::vector<std::string> names_of(const std::vector<NamedView>& all) {
  std::vector<std::string> names;
  for (const NamedView& v : all) names.push_back(v.name);
  return names;
}

NamedView require_view(const ocio::Config& config, const std::string& name) {
  const std::vector<NamedView> all = list_views(config);
  const auto found = std::ranges::find_if(
      all, [&](const NamedView& v) { return v.name == name || v.display + '/' + v.view == name; });
  if (found != all.end()) return *found;
  throw Error(fmt::format(
      "there is no tone map '{}'; expected srgb, neutral, filmic, or a view of the OCIO "
      "configuration: {}",
      name, fmt::join(names_of(all), ", ")));
}

/// The name of the space in which a view's codes are.
std::string space_of(const ocio::Config& config, const NamedView& v) {
  const std::string name = config.getDisplayViewColorSpaceName(v.display.c_str(), v.view.c_str());
  return name == "<USE_DISPLAY_NAME>" ? v.display : name;
}

bool is_data(const ocio::Config& config, const std::string& space) {
  const ocio::ConstColorSpaceRcPtr found = config.getColorSpace(space.c_str());
  return found && found->isData();
}

}  // namespace

std::vector<std::string> views_of_config() {
  return naming_config([] { return names_of(list_views(*read_config())); });
}

ScreenView find_view(const std::string& name, ColorSpace from) {
  return naming_config([&] {
    const ocio::ConstConfigRcPtr config = read_config();
    const NamedView chosen = require_view(*config, name);
    const std::string codes = space_of(*config, chosen);
    const bool srgb = names_srgb(chosen.display) || names_srgb(chosen.view) || names_srgb(codes);
    if (is_data(*config, codes)) return ScreenView{[](std::span<Vec3d>) {}, srgb};  // as they are
    const auto [linear, space] = linear_space(*config, from);
    const auto view = ocio::DisplayViewTransform::Create();
    view->setSrc(linear);
    view->setDisplay(chosen.display.c_str());
    view->setView(chosen.view.c_str());
    const ocio::ConstCPUProcessorRcPtr processor =
        config->getProcessor(view)->getDefaultCPUProcessor();
    const Affine to_config = conversion(from, space);
    const auto encode = [processor, to_config](std::span<Vec3d> colors) {
      for (Vec3d& c : colors) c = to_config.vector(c);
      naming_config([&] { apply(*processor, colors); });
    };
    return ScreenView{encode, srgb};
  });
}

ColorSpace to_linear(std::span<Rgb> colors, const std::string& from) {
  return naming_config([&] {
    const ocio::ConstConfigRcPtr config = read_config();
    if (!config->getColorSpace(from.c_str()) || is_data(*config, from)) {
      std::vector<std::string> spaces;
      for (const std::string_view name : all_names<ColorSpace>()) spaces.emplace_back(name);
      constexpr auto kScene = ocio::SEARCH_REFERENCE_SPACE_SCENE;
      for (int i = 0; i < config->getNumColorSpaces(kScene, ocio::COLORSPACE_ACTIVE); ++i) {
        const char* const name =
            config->getColorSpaceNameByIndex(kScene, ocio::COLORSPACE_ACTIVE, i);
        if (!is_data(*config, name)) spaces.emplace_back(name);
      }
      throw Error(
          fmt::format("there is no colour space '{}'; expected {}", from, fmt::join(spaces, ", ")));
    }
    const auto [linear, space] = linear_space(*config, ColorSpace::acescg);
    apply(*config->getProcessor(from.c_str(), linear)->getDefaultCPUProcessor(), colors);
    return space;
  });
}

}  // namespace pvol::formats::detail

std::string pvol::formats::color_config_id() {
  return detail::naming_config([] { return std::string(detail::read_config()->getCacheID()); });
}
