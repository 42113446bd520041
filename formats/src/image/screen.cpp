#include "image/screen.h"

#include <fmt/format.h>

#include <cmath>

#include "pvol/error.h"

namespace pvol::formats {
namespace {

/// The transfer function of IEC 61966-2-1, linear [0, 1] to encoded [0, 1].
double encode_srgb(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

/// By a tone map of our own, for a screen of sRGB.
detail::ScreenView own_view(ToneMap map, ColorSpace space) {
  const Affine to_rec709 = conversion(space, ColorSpace::rec709);
  return {[map, to_rec709](std::span<Vec3d> colors) {
    for (Vec3d& c : colors) {
      const Vec3d shown = to_display(to_rec709.vector(c), map);
      c = {encode_srgb(shown.x), encode_srgb(shown.y), encode_srgb(shown.z)};
    }
  }};
}

}  // namespace

detail::Screen::Screen(const Display& display, ColorSpace space)
    : factor_(std::exp2(display.exposure)) {
  if (!std::isfinite(factor_) || factor_ == 0) {
    throw Error(
        fmt::format("exposure {:f} is out of range; expected stops such as 1.5", display.exposure));
  }
  const auto map = find_named<ToneMap>(display.tone_map);
  view_ = map ? own_view(*map, space) : find_view(display.tone_map, space);
}

void detail::Screen::encode(std::span<Vec3d> colors) const {
  view_.encode(colors);
  // Views of a configuration may exceed it, and give no number for what is none.
  for (Vec3d& c : colors) c = min(max(Vec3d(0.0), c), Vec3d(1.0));
}

std::vector<std::string> tone_maps() {
  std::vector<std::string> all;
  for (const std::string_view name : all_names<ToneMap>()) all.emplace_back(name);
  for (std::string& view : detail::views_of_config()) all.push_back(std::move(view));
  return all;
}

void check(const Display& display) { (void)detail::Screen(display, ColorSpace::rec709); }

}  // namespace pvol::formats
