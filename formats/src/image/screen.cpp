#include "pvol/formats/screen.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "image/color_config.h"
#include "pvol/error.h"

namespace pvol::formats {
namespace {

/// The transfer function of IEC 61966-2-1, linear [0, 1] to encoded [0, 1].
double encode_srgb(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

}  // namespace

Screen::Screen(const Display& display, ColorSpace space) {
  expose(display.exposure);
  if (const auto map = find_named<ToneMap>(display.tone_map)) {
    encode_ = [map = *map, to_rec709 = conversion(space, ColorSpace::rec709)](auto colors) {
      for (Vec3d& c : colors) {
        const Vec3d shown = to_display(to_rec709.vector(c), map);
        c = {encode_srgb(shown.x), encode_srgb(shown.y), encode_srgb(shown.z)};
      }
    };
    return;
  }
  detail::ScreenView view = detail::find_view(display.tone_map, space);
  encode_ = std::move(view.encode), is_srgb_ = view.is_srgb;
}

void Screen::expose(double stops) {
  factor_ = std::exp2(stops);
  if (std::isfinite(factor_) && factor_ != 0) return;
  throw Error(fmt::format("exposure {:f} is out of range; expected stops such as 1.5", stops));
}

void Screen::encode(std::span<Vec3d> colors) const {
  encode_(colors);
  // Views of a configuration may exceed it, and give no number for what is none.
  for (Vec3d& c : colors) c = min(max(Vec3d(0.0), c), Vec3d(1.0));
}

std::vector<std::string> tone_maps() {
  std::vector<std::string> all;
  for (const std::string_view name : all_names<ToneMap>()) all.emplace_back(name);
  for (std::string& view : detail::views_of_config()) all.push_back(std::move(view));
  return all;
}

void validate(const Display& display) { (void)Screen(display, ColorSpace::rec709); }

}  // namespace pvol::formats
