// Sky pictures in, whatever their format and colours.
#include <optional>
#include <utility>

#include "image/color_config.h"
#include "image/sky_readers.h"
#include "pvol/error.h"
#include "pvol/formats/image.h"

namespace pvol::formats {
namespace {

/// Pixels are never negative.
void convert(std::vector<Rgb>& pixels, const Affine& map, ColorSpace to) {
  for (Rgb& c : pixels) c = Rgb(into_gamut(map.vector(Vec3d(c)), to));
}

void convert(detail::StoredSky& stored, const SkyColors& colors) {
  Primaries from = stored.primaries;
  if (!colors.from.empty()) {
    const auto named = find_named<ColorSpace>(colors.from);
    if (!named) {
      const ColorSpace linear = detail::to_linear(stored.sky.pixels, colors.from);
      return convert(stored.sky.pixels, conversion(linear, colors.to), colors.to);
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
  convert(stored.sky.pixels, *map, colors.to);
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
  return std::move(stored.sky);
}

}  // namespace pvol::formats
