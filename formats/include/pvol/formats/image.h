// Pictures: OpenEXR out and in, PNG out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pvol/formats/film_record.h"
#include "pvol/formats/screen.h"
#include "pvol/render/aov.h"
#include "pvol/render/camera.h"
#include "pvol/render/film.h"
#include "pvol/render/scene.h"

namespace pvol::formats {

/// From here on, EXR files are packed and unpacked by so many threads of the process, 0 for one for
/// each hardware thread; before, by the one that calls. No byte depends on it.
void use_exr_threads(int threads);

/// How the colour of an EXR is stored; layers of numbers are always float.
enum class PixelType {
  half,    ///< 11 bits; up to 65504, larger values are clamped to that
  single,  ///< 24 bits
};
[[nodiscard]] constexpr auto names(PixelType) {
  return std::to_array<Named<PixelType>>({{PixelType::half, "half"}, {PixelType::single, "float"}});
}

/// How an EXR is packed. All but dwaa give back what was written.
enum class ExrCompression {
  zip,   ///< 16 rows at a time
  zips,  ///< each row by itself: for programs that read lines here and there
  piz,   ///< wavelets, best for grain; of float larger than zip
  dwaa,  ///< rounds colour by what the eye sees
  none,
};
[[nodiscard]] constexpr auto names(ExrCompression) {
  return std::to_array<Named<ExrCompression>>({{ExrCompression::zip, "zip"},
                                               {ExrCompression::zips, "zips"},
                                               {ExrCompression::piz, "piz"},
                                               {ExrCompression::dwaa, "dwaa"},
                                               {ExrCompression::none, "none"}});
}

/// Exact sums to go on with and to merge (film_file.h).
struct KeptSums {
  const Film* film = nullptr;  ///< that has them, of the picture's window; perhaps the picture
  FilmRecord record{};
};

struct ExrOptions {
  AovSet aovs{};           ///< what is written beside colour, alpha and the film's layers
  bool opaque = false;     ///< alpha is 1 everywhere, as where a background is seen
  bool multipart = false;  ///< each layer in a part of its own; else all in one
  PixelType pixels = PixelType::single;
  ExrCompression compression = ExrCompression::zip;
  std::optional<Camera> camera{};  ///< for worldToCamera and worldToNDC
  std::optional<KeptSums> sums{};  ///< to keep in a part "sums" besides
};

/// Throws Error where layers of numbers would be rounded: dwaa without parts.
void validate(const ExrOptions& options);

/// Writes R, G, B, A (linear, with the chromaticities of the film's space, premultiplied alpha) and
/// nothing more but for `options.aovs` and the film's layers, as channels LAYER.R, .G, .B or
/// LAYER.Y (kFilmChannels, Layer): colour alone opens as a plain picture everywhere. The data
/// window is the rendered rectangle, the display window the whole image. `attributes` become string
/// attributes of the (first) header; their names must not be those of EXR's own. Values are written
/// as they are, non-finite ones too, but for those that half does not hold: returns how many those
/// were. The same film gives the same bytes. Atomic. Throws Error for an empty film, options that
/// do not go together and where writing fails.
std::uint64_t write_exr(const std::filesystem::path& file, const Film& film,
                        const std::map<std::string, std::string>& attributes,
                        const ExrOptions& options = {});

struct DeepExrOptions {
  double error = 0;                      ///< that merging may make, see deep_samples
  PixelType pixels = PixelType::single;  ///< of colour; alpha and depths are always float
  ExrCompression compression = ExrCompression::zips;  ///< or none; deep files know no other
  std::optional<Camera> camera{};                     ///< as in ExrOptions
};

struct DeepExrWritten {
  std::uint64_t samples = 0;  ///< of all pixels
  std::uint64_t clamped = 0;  ///< values that half does not hold
};

/// Writes what a film that was rendered with RenderOptions::deep sees, by depth: deep scanlines
/// with R, G, B, A, Z and ZBack (deep_samples), sorted and disjoint in each pixel, Z in world units
/// along the camera's axis as in the layer `depth`, without background; windows and attributes as
/// write_exr. Pixels that nothing covers have no samples. The same film gives the same bytes.
/// Atomic. Throws Error for a film without depths or pixels, attributes of EXR's own names and
/// where writing fails.
DeepExrWritten write_deep_exr(const std::filesystem::path& file, const Film& film,
                              const std::map<std::string, std::string>& attributes,
                              const DeepExrOptions& options = {});

/// Writes the rendered rectangle as 8-bit sRGB (IEC 61966-2-1, with the sRGB chunk; for views of
/// other screens, their codes and no such chunk): radiance times 2^exposure, by the tone map in [0,
/// 1], rounded up or down to a code by a fixed pattern whose mean is the value, so that gradients
/// have no bands (dither). With `alpha` an RGBA picture with unpremultiplied colour, black where
/// alpha is 0; it suits films rendered without background. Atomic. Throws Error for an empty film,
/// what `validate` refuses of a display, and a pixel that is not finite, which it names.
void write_png(const std::filesystem::path& file, const Film& film, const Display& display = {},
               bool alpha = false);

/// 8 bits for a screen, rows from the top.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  ///< 3 * width * height
};

/// The film as write_png would write it without alpha; pixels that are not finite are magenta.
/// Throws Error for what `validate` refuses of a display.
[[nodiscard]] Picture to_picture(const Film& film, const Display& display = {});
/// The same by a screen for colours of the film's space.
[[nodiscard]] Picture to_picture(const Film& film, const Screen& screen);

/// The bytes of a PNG file with this picture, which has at least one pixel.
[[nodiscard]] std::vector<std::byte> encode_png(const Picture& picture);

/// Writes the picture. Atomic. Throws Error where writing fails.
void write_png(const std::filesystem::path& file, const Picture& picture);

/// A film as an EXR file keeps it.
struct StoredFilm {
  Film film;
  bool has_variances = false;  ///< else every pixel counts as one sample, without variance
  AovSet figures{};            ///< those of film_channels.h that the file has
  std::map<std::string, std::string> attributes;  ///< all of type string, such as "pvol:seed"
};

/// Reads what `write_exr` wrote, in one part or several, and what earlier versions did: means,
/// variances, samples and counts are those of the film written, rounded to the type of the file;
/// sums follow from them, alpha from the transmittance where that is there. From other programs'
/// files it takes R, G, B and, where it is there, A, of the first part; and as layers what other
/// channels share a name and end in .R, .G, .B or .X, .Y, .Z or in one letter, of parts of the same
/// window. Throws Error as `read_sky` does, but radiance may be negative; and for variances,
/// samples and counts that are negative.
[[nodiscard]] StoredFilm read_film(const std::filesystem::path& file);

/// A deep EXR (scanlines, zips or no compression) as a flat film: the samples of each pixel over
/// each other, before nothing. Every pixel counts as one sample. Throws Error for files that are
/// damaged or incomplete, without the channels R, G, B, A and Z, with primaries of no ColorSpace,
/// with tiles or several parts, with samples that are not finite, overlap or are not in
/// the order of depth, and beyond the sizes of `read_sky`.
[[nodiscard]] StoredFilm flatten_exr(const std::filesystem::path& file);

/// Colours of a sky picture: those of its file and those that are wanted.
struct SkyColors {
  /// A name of ColorSpace, or of a colour space of the OCIO configuration; empty: by the primaries
  /// in the file, or Rec.709 where it has none.
  std::string from{};
  ColorSpace to = ColorSpace::rec709;
};

/// The R, G, B channels of an EXR (half, float or integer; scanlines or the finest level of tiles)
/// as a sky picture of the size of its data window; scale and rotation are the defaults. Throws
/// Error for files that are damaged or incomplete, without those channels (the message lists what
/// is there), with non-finite or negative pixels, with deep ones, with channels of fewer samples
/// than pixels, of more than 2^28 pixels or with an edge above 2^16. Files that end in .hdr, or
/// begin as those do, are Radiance pictures (RGBE, plain or with either run-length code, lines in
/// any order, exposure undone): Error for those that are damaged, of XYZE, and of such sizes.
/// Colours are converted to another space with what lies outside its gamut cut off at the same
/// luminance; Error for a space that is unknown.
[[nodiscard]] ImageSky read_sky(const std::filesystem::path& file, const SkyColors& colors = {});

}  // namespace pvol::formats
