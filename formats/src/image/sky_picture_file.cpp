// Sky pictures in, whatever their format and colours.
#include <fmt/format.h>

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "image/color_config.h"
#include "image/sky_readers.h"
#include "pvol/error.h"
#include "pvol/formats/image.h"

namespace pvol::formats {
namespace {

/// Pixels are never negative.
void convert(ImageSky& sky, const Affine& map, ColorSpace to) {
  const Vec3d weights = luminance_weights(to);
  std::vector<Rgb>& pixels = sky.pixels.edit();
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const Vec3d there = map.vector(Vec3d(pixels[i]));
    pixels[i] = Rgb(into_gamut(there, weights));
    if (is_finite(there) && is_finite(pixels[i])) continue;
    const auto width = std::size_t(sky.width);
    throw Error(
        fmt::format("pixel ({}, {}) is not finite in {}; expected another "
                    "environment.color_space",
                    i % width, i / width, name(to)));
  }
}

void convert(detail::StoredSky& stored, const SkyColors& colors) {
  Primaries from = stored.primaries;
  if (!colors.from.empty()) {
    const auto named = find_named<ColorSpace>(colors.from);
    if (!named) {
      const ColorSpace linear = detail::to_linear(stored.sky.pixels.edit(), colors.from);
      return convert(stored.sky, conversion(linear, colors.to), colors.to);
    }
    from = primaries_of(*named);
  }
  const std::optional<ColorSpace> space = find_space(from);
  if (space == colors.to) return;
  const auto map = conversion(space ? primaries_of(*space) : from, primaries_of(colors.to));
  if (!map) {
    throw Error(
        "has primaries that span no colours; expected chromaticities of red, green, blue "
        "and white: save it again, or set environment.color_space");
  }
  convert(stored.sky, *map, colors.to);
}

}  // namespace

ImageSky read_sky(const std::filesystem::path& file, const SkyColors& colors) {
  detail::StoredSky stored =
      detail::is_hdr(file) ? detail::read_hdr_sky(file) : detail::read_exr_sky(file);
  try {
    convert(stored, colors);
  } catch (const Error& e) {
    throw Error(file.string() + ": " + e.what());
  }
  stored.sky.pixels = std::move(stored.sky.pixels.edit());  // looked through once for all
  return std::move(stored.sky);
}

}  // namespace pvol::formats
