// UsdRender: RenderSettings, and the first of their products, which may say otherwise.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <utility>

#include "pvol/render/options.h"
#include "usda/usda_world.h"

namespace pvol::formats::detail {
namespace {

const UsdItem* at_path(const std::vector<UsdItem>& items, const std::string& path) {
  const auto found = std::ranges::find(items, path, &UsdItem::path);
  return found == items.end() ? nullptr : &*found;
}

/// The space of a token for linear colours: lin_ap1, lin_ap1_scene, lin_rec709_scene and so on, or
/// a name of ours.
std::optional<ColorSpace> space_of(const std::string& token) {
  constexpr std::pair<const char*, ColorSpace> kLinear[] = {{"lin_ap1", ColorSpace::acescg},
                                                            {"lin_ap0", ColorSpace::aces},
                                                            {"lin_rec709", ColorSpace::rec709},
                                                            {"lin_rec2020", ColorSpace::rec2020},
                                                            {"lin_p3d65", ColorSpace::p3}};
  std::string name;
  for (const char c : token) name += char(std::tolower(static_cast<unsigned char>(c)));
  for (const auto& [begin, space] : kLinear) {
    if (name.starts_with(begin)) return space;
  }
  return find_named<ColorSpace>(name);
}

void take_space(const UsdView& view, UsdPicture& picture, const UsdMaking& making) {
  const std::string token = view.word("renderingColorSpace", "");
  if (token.empty()) return;
  if (const auto space = space_of(token)) {
    picture.space = *space;
  } else {
    making.note(view.where(), fmt::format("the renderingColorSpace {} is unknown here: colours are "
                                          "taken as {}",
                                          usd_shown(token), name(picture.space)));
  }
}

void take_settings(const UsdItem& item, UsdPicture& picture, const UsdMaking& making) {
  const UsdView view = making.stage.view(*item.prim);
  const std::vector<double> size = view.numbers("resolution", 2);
  if (size.size() == 2) {
    const auto fits = [](double n) { return n >= 1 && n <= kLargestEdge; };
    if (!fits(size[0]) || !fits(size[1])) {
      fail_at(view.find("resolution")->where, fmt::format("a picture of {} x {}", size[0], size[1]),
              fmt::format("1 to {} pixels", kLargestEdge));
    }
    picture.size = {int(size[0]), int(size[1])};
  }
  const std::vector<std::string> camera = view.paths("camera");
  if (!camera.empty()) picture.camera = camera.front();
  picture.policy = view.word("aspectRatioConformPolicy", picture.policy);
  if (picture.policy == "adjustPixelAspectRatio") {
    making.note(view.where(),
                "pixels stay square: adjustPixelAspectRatio is taken as "
                "expandAperture");
  }
  take_space(view, picture, making);
  for (const char* name : {"products", "orderedVars", "productName", "productType"}) {
    view.ignore(name);  // pvol-render names its file and its layers: -o and --aov
  }
  view.note_unused(*making.notes);
}

}  // namespace

UsdPicture picture_of(const UsdMaking& making) {
  UsdPicture picture;
  const UsdStage& stage = making.stage;
  const std::string path = word_of(stage.root, "renderSettingsPrimPath");
  const UsdItem* settings = at_path(stage.settings, path);
  if (settings == nullptr && !stage.settings.empty()) settings = &stage.settings.front();
  if (settings == nullptr) return picture;
  if (stage.settings.size() > 1) {
    making.note(settings->prim->where,
                fmt::format("of {} RenderSettings {} are taken", stage.settings.size(),
                            usd_shown(settings->path)));
  }
  take_settings(*settings, picture, making);
  const std::vector<std::string> products = stage.view(*settings->prim).paths("products");
  const UsdItem* product = products.empty() ? nullptr : at_path(stage.products, products.front());
  if (product != nullptr) take_settings(*product, picture, making);
  return picture;
}

}  // namespace pvol::formats::detail
