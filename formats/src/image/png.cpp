// PNG out, by libpng's simplified interface (which needs no setjmp).
#include <fmt/format.h>

#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "pvol/error.h"
#include "pvol/formats/atomic_file.h"
#include "pvol/formats/image.h"

namespace pvol::formats {
namespace {

/// The transfer function of IEC 61966-2-1, linear [0, 1] to encoded [0, 1].
double encode_srgb(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

std::uint8_t to_byte(double v) { return static_cast<std::uint8_t>(std::lround(255 * v)); }

/// Where a value between two codes is rounded up, in (0, 1) and even over pixels, by a pattern
/// whose neighbours differ: smooth gradients would else show bands. (J. Jimenez, "Next Generation
/// Post-Processing in Call of Duty", 2014: interleaved gradient noise.)
double dither(int x, int y) {
  const auto fraction = [](double v) { return v - std::floor(v); };
  const double noise = fraction(52.9829189 * fraction(0.06711056 * x + 0.00583715 * y));
  constexpr double kRounding = 1e-6;  // so that a value that is a code stays one
  return std::clamp(fraction(noise + 0.5), kRounding, 1 - kRounding);
}

/// The bytes of one pixel of the whole picture; three or four of them count.
std::array<std::uint8_t, 4> encode_pixel(const PixelSums& sums, int x, int y, double factor,
                                         bool alpha, ToneMap map) {
  const double a = sums.samples ? std::clamp(sums.alpha / sums.samples, 0.0, 1.0) : 0;
  Vec3d colour = mean(sums) * factor;
  if (alpha) colour = a > 0 ? colour / a : Vec3d{};
  colour = to_display(colour, map);
  const double up = dither(x, y);
  const auto encode = [&](double v) { return std::uint8_t(255 * encode_srgb(v) + up); };
  return {encode(colour.x), encode(colour.y), encode(colour.z), to_byte(a)};
}

std::vector<std::uint8_t> encode_film(const std::filesystem::path& file, const Film& film,
                                      double factor, bool alpha, ToneMap map) {
  const std::size_t depth = alpha ? 4 : 3;
  std::vector<std::uint8_t> bytes;
  bytes.reserve(film.pixels.size() * depth);
  for (int y = 0; y < film.crop_height; ++y) {
    for (int x = 0; x < film.crop_width; ++x) {
      const PixelSums& sums = film.at(x, y);
      if (!is_finite(sums.sum) || !std::isfinite(sums.alpha)) {
        throw Error(fmt::format(
            "{}: pixel ({}, {}) is not finite, which PNG cannot hold; write .exr to inspect it",
            file.string(), film.x + x, film.y + y));
      }
      const std::array<std::uint8_t, 4> pixel =
          encode_pixel(sums, film.x + x, film.y + y, factor, alpha, map);
      bytes.insert(bytes.end(), pixel.begin(), pixel.begin() + std::ptrdiff_t(depth));
    }
  }
  return bytes;
}

png_image describe(int width, int height, png_uint_32 format) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = png_uint_32(width);
  image.height = png_uint_32(height);
  image.format = format;  // 8-bit formats are sRGB
  return image;
}

void write_bytes(const std::filesystem::path& file, png_image image,
                 const std::vector<std::uint8_t>& bytes) {
  write_atomically(file, [&](const std::filesystem::path& aside) {
    if (!png_image_write_to_file(&image, aside.c_str(), 0, bytes.data(), 0, nullptr)) {
      throw Error(file.string() + ": cannot be written: " + image.message);
    }
  });
}

}  // namespace

void write_png(const std::filesystem::path& file, const Film& film, double exposure, bool alpha,
               ToneMap map) {
  const double factor = std::exp2(exposure);
  if (!std::isfinite(factor) || factor == 0) {
    throw Error(fmt::format("{}: exposure {:f} is out of range; expected stops such as 1.5",
                            file.string(), exposure));
  }
  if (film.crop_width < 1 || film.crop_height < 1) {
    throw Error(file.string() + ": the picture has no pixels; choose a size of at least 1 x 1");
  }
  const std::vector<std::uint8_t> bytes = encode_film(file, film, factor, alpha, map);
  write_bytes(file,
              describe(film.crop_width, film.crop_height, alpha ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB),
              bytes);
}

Picture to_picture(const Film& film, double exposure, ToneMap map) {
  Picture p{film.crop_width, film.crop_height, {}};
  p.rgb.reserve(3 * film.pixels.size());
  for (int y = 0; y < film.crop_height; ++y) {
    for (int x = 0; x < film.crop_width; ++x) {
      const PixelSums& sums = film.at(x, y);
      std::array<std::uint8_t, 4> pixel{255, 0, 255, 255};
      if (is_finite(sums.sum)) {
        pixel = encode_pixel(sums, film.x + x, film.y + y, std::exp2(exposure), false, map);
      }
      p.rgb.insert(p.rgb.end(), pixel.begin(), pixel.begin() + 3);
    }
  }
  return p;
}

std::vector<std::byte> encode_png(const Picture& picture) {
  png_image image = describe(picture.width, picture.height, PNG_FORMAT_RGB);
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::vector<std::byte> bytes(size);
  if (!png_image_write_to_memory(&image, bytes.data(), &size, 0, picture.rgb.data(), 0, nullptr)) {
    throw Error(std::string("a picture cannot be encoded: ") + image.message);
  }
  bytes.resize(size);
  return bytes;
}

void write_png(const std::filesystem::path& file, const Picture& picture) {
  write_bytes(file, describe(picture.width, picture.height, PNG_FORMAT_RGB), picture.rgb);
}

}  // namespace pvol::formats
