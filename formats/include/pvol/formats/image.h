// Pictures: OpenEXR out and in, PNG out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "pvol/render/film.h"
#include "pvol/render/scene.h"

namespace pvol::formats {

/// Writes R, G, B, A (float, linear Rec.709 with the chromaticities header, premultiplied alpha),
/// the variance of each pixel's mean (variance.R, .G, .B), the number of samples (samples) and,
/// where they were counted, look-ups, segments and collisions per sample (count.lookups,
/// count.segments, count.collisions). The data window is the rendered rectangle, the display window
/// the whole image. `attributes` become string attributes of the header; their names must not be
/// those of EXR's own. Values are written as they are, non-finite ones too. The same film gives the
/// same bytes. Atomic. Throws Error for an empty film and where writing fails.
void write_exr(const std::filesystem::path& file, const Film& film,
               const std::map<std::string, std::string>& attributes);

/// Writes the rendered rectangle as 8-bit sRGB (IEC 61966-2-1, with the sRGB chunk): radiance times
/// 2^exposure, clipped to [0, 1], rounded to the nearest code. With `alpha` an RGBA picture with
/// unpremultiplied colour, black where alpha is 0; it suits films rendered without background.
/// Atomic. Throws Error for an empty film, an exposure beyond what double holds, and a pixel that
/// is not finite, which it names.
void write_png(const std::filesystem::path& file, const Film& film, double exposure, bool alpha);

/// 8-bit sRGB, rows from the top: what screens show.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  ///< 3 * width * height
};

/// The film as write_png would write it without alpha; pixels that are not finite are magenta.
[[nodiscard]] Picture to_picture(const Film& film, double exposure);

/// The bytes of a PNG file with this picture, which has at least one pixel.
[[nodiscard]] std::vector<std::byte> encode_png(const Picture& picture);

/// Writes the picture. Atomic. Throws Error where writing fails.
void write_png(const std::filesystem::path& file, const Picture& picture);

/// A film as an EXR file keeps it.
struct StoredFilm {
  Film film;
  bool has_variances = false;  ///< else every pixel counts as one sample, without variance
  std::map<std::string, std::string> attributes;  ///< all of type string, such as "pvol:seed"
};

/// Reads what `write_exr` wrote: means, variances, samples and counts are those of the film
/// written, rounded to float; sums follow from them. From other programs' files it takes R, G, B
/// and, where it is there, A. Throws Error as `read_sky` does, but radiance may be negative; and
/// for variances, samples and counts that are negative.
[[nodiscard]] StoredFilm read_film(const std::filesystem::path& file);

/// The R, G, B channels of an EXR (half, float or integer; scanlines or the finest level of tiles)
/// as a sky picture of the size of its data window; scale and rotation are the defaults. Throws
/// Error for files that are damaged or incomplete, without those channels (the message lists what
/// is there), with primaries other than Rec.709, with non-finite or negative pixels, with deep ones,
/// with channels of fewer samples than pixels, of more than 2^28 pixels or with an edge above 2^16.
[[nodiscard]] ImageSky read_sky(const std::filesystem::path& file);

}  // namespace pvol::formats
