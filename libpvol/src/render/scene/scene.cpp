// What lights and options may be: each value by its row, and what rows cannot say.
#include <string>

#include "pvol/error.h"
#include "pvol/render/scene.h"

namespace pvol {
namespace {

void require(bool ok, const std::string& message) {
  if (!ok) throw Error(message);
}

void require_fit(const std::string& what, const std::optional<Misfit>& misfit) {
  if (misfit) throw Error(what + ": " + misfit->keys.front() + ": expected " + misfit->expected);
}

}  // namespace

std::optional<Misfit> misfit(const RenderOptions& o) {
  const bool one_pixel = (o.crop_width ? o.crop_width : o.width - o.crop_x) == 1 &&
                         (o.crop_height ? o.crop_height : o.height - o.crop_y) == 1;
  if (o.noise && one_pixel) {
    return Misfit{{"noise"},
                  "off for a single pixel, whose noise cannot be estimated from neighbours"};
  }
  if (o.part_end > 0 || o.part_begin > 0) {
    if (o.time && !o.noise) {
      return Misfit{{"time"}, "none with samples A:B, a part of a given number of samples"};
    }
    const std::uint32_t all = is_adaptive(o) ? kPilot : o.samples;
    const bool pilot = o.part_begin == 0 && o.part_end == kPilot;
    if (is_adaptive(o) && !pilot) {
      return Misfit{{"samples"}, "0:" + std::to_string(kPilot) + ", the pilot of adaptive samples"};
    }
    if (o.part_begin >= o.part_end || o.part_end > all) {
      return Misfit{{"samples"},
                    "A:B with A < B among the samples of a pixel, 0:" + std::to_string(all)};
    }
  }
  if (o.crop_x < o.width && o.crop_y < o.height && o.crop_width <= o.width - o.crop_x &&
      o.crop_height <= o.height - o.crop_y) {
    return std::nullopt;
  }
  return Misfit{{"crop"},
                "[x, y, width, height] inside the image of " + std::to_string(o.width) + " x " +
                    std::to_string(o.height) + " pixels"};
}

void validate(const RenderOptions& options) {
  require_limits("render", without(entries(options), "seed"));  // any in memory
  require_fit("render", misfit(options));
}

void validate(const Environment& environment) {
  if (const auto* clear = std::get_if<ClearSky>(&environment)) {
    require_limits("sky", entries(*clear));
    return require_fit("sky", misfit(*clear));
  }
  const auto* picture = std::get_if<ImageSky>(&environment);
  if (!picture) return require_limits("sky", entries(environment));
  require_limits("sky", without(entries(environment), "file"));  // which pixels in memory lack
  require(picture->width > 0 && picture->height > 0 &&
              picture->pixels.size() == std::size_t(picture->width) * std::size_t(picture->height),
          "sky: the number of pixels is wrong; expected width x height");
  const std::optional<Rgb> largest = picture->pixels.largest();
  require(largest && is_finite(*largest * picture->scale),
          "sky: a radiance is negative or not finite; expected finite numbers of at least 0");
}

void validate(const Light& light) { require_limits(kind_name(light), entries(light)); }

}  // namespace pvol
