// PNG out, by libpng's simplified interface (which needs no setjmp).
#include <fmt/format.h>

#include <png.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "pvol/error.h"
#include "pvol/formats/atomic_file.h"
#include "pvol/formats/image.h"

namespace pvol::formats {
namespace {

std::uint8_t to_byte(double v) { return static_cast<std::uint8_t>(std::lround(255 * v)); }

double alpha_of(const PixelSums& p) {
  return p.samples ? std::clamp(p.alpha / p.samples, 0.0, 1.0) : 0;
}

/// Where a value between two codes is rounded up, in (0, 1) and even over pixels, by a pattern
/// whose neighbours differ: smooth gradients would else show bands. (J. Jimenez, "Next Generation
/// Post-Processing in Call of Duty", 2014: interleaved gradient noise.)
double dither(int x, int y) {
  const auto fraction = [](double v) { return v - std::floor(v); };
  const double noise = fraction(52.9829189 * fraction(0.06711056 * x + 0.00583715 * y));
  constexpr double kRounding = 1e-6;  // so that a value that is a code stays one
  return std::clamp(fraction(noise + 0.5), kRounding, 1 - kRounding);
}

constexpr Vec3d kMagenta(1, 0, 1);

/// The pixels of a row as codes in [0, 1]; those that are not finite are magenta.
std::vector<Vec3d> encode_row(const Film& film, int y, const Screen& screen, bool alpha) {
  std::vector<Vec3d> colors(std::size_t(film.crop_width));
  for (int x = 0; x < film.crop_width; ++x) {
    const PixelSums& sums = film.at(x, y);
    Vec3d& color = colors[std::size_t(x)];
    if (!is_finite(sums.sum)) continue;
    color = mean(sums) * screen.factor();
    if (alpha) color = alpha_of(sums) > 0 ? color / alpha_of(sums) : Vec3d{};
  }
  screen.encode(colors);
  for (int x = 0; x < film.crop_width; ++x) {
    if (!is_finite(film.at(x, y).sum)) colors[std::size_t(x)] = kMagenta;
  }
  return colors;
}

std::vector<std::uint8_t> encode_film(const Film& film, const Screen& screen, bool alpha) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(film.pixels.size() * (alpha ? 4 : 3));
  for (int y = 0; y < film.crop_height; ++y) {
    const std::vector<Vec3d> row = encode_row(film, y, screen, alpha);
    for (int x = 0; x < film.crop_width; ++x) {
      const double up = dither(film.x + x, film.y + y);
      for (int c = 0; c < 3; ++c) bytes.push_back(std::uint8_t(255 * row[std::size_t(x)][c] + up));
      if (alpha) bytes.push_back(to_byte(alpha_of(film.at(x, y))));
    }
  }
  return bytes;
}

void require_finite(const std::filesystem::path& file, const Film& film) {
  for (int y = 0; y < film.crop_height; ++y) {
    for (int x = 0; x < film.crop_width; ++x) {
      const PixelSums& sums = film.at(x, y);
      if (is_finite(sums.sum) && std::isfinite(sums.alpha)) continue;
      throw Error(fmt::format(
          "{}: pixel ({}, {}) is not finite, which PNG cannot hold; write .exr to inspect it",
          file.string(), film.x + x, film.y + y));
    }
  }
}

png_image describe(int width, int height, png_uint_32 format) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = png_uint_32(width);
  image.height = png_uint_32(height);
  image.format = format;  // 8-bit formats are sRGB
  return image;
}

std::vector<std::byte> encode(png_image image, const std::vector<std::uint8_t>& codes) {
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::vector<std::byte> bytes(size);
  if (!png_image_write_to_memory(&image, bytes.data(), &size, 0, codes.data(), 0, nullptr)) {
    throw Error(std::string("a picture cannot be encoded: ") + image.message);
  }
  bytes.resize(size);
  return bytes;
}

void write_codes(const std::filesystem::path& file, png_image image,
                 const std::vector<std::uint8_t>& codes) {
  write_atomically(file, [&](const std::filesystem::path& aside) {
    if (!png_image_write_to_file(&image, aside.c_str(), 0, codes.data(), 0, nullptr)) {
      throw Error(file.string() + ": cannot be written: " + image.message);
    }
  });
}

/// Writes codes of a screen that the file is not to describe: libpng then takes a gamma of 2.2 for
/// granted, which is left out here.
void write_undescribed(const std::filesystem::path& file, png_image image,
                       const std::vector<std::uint8_t>& codes) {
  image.flags |= PNG_IMAGE_FLAG_COLORSPACE_NOT_sRGB;
  const std::vector<std::byte> bytes = encode(image, codes);
  std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  constexpr std::size_t kLength = 4, kChunk = 16;  // of gAMA: length, name, 4 bytes and a checksum
  if (const auto name = text.find("gAMA"); name != text.npos) text.erase(name - kLength, kChunk);
  write_text_atomically(file, text);
}

Screen screen_for(const std::filesystem::path& file, const Display& display, ColorSpace space) {
  try {
    return Screen(display, space);
  } catch (const Error& e) {
    throw Error(file.string() + ": " + e.what());
  }
}

}  // namespace

void write_png(const std::filesystem::path& file, const Film& film, const Display& display,
               bool alpha) {
  if (film.crop_width < 1 || film.crop_height < 1) {
    throw Error(file.string() + ": the picture has no pixels; choose a size of at least 1 x 1");
  }
  require_finite(file, film);
  const Screen screen = screen_for(file, display, film.color_space);
  const png_image image =
      describe(film.crop_width, film.crop_height, alpha ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB);
  const std::vector<std::uint8_t> codes = encode_film(film, screen, alpha);
  screen.is_srgb() ? write_codes(file, image, codes) : write_undescribed(file, image, codes);
}

Picture to_picture(const Film& film, const Screen& screen) {
  return {film.crop_width, film.crop_height, encode_film(film, screen, false)};
}

Picture to_picture(const Film& film, const Display& display) {
  return to_picture(film, Screen(display, film.color_space));
}

std::vector<std::byte> encode_png(const Picture& picture) {
  return encode(describe(picture.width, picture.height, PNG_FORMAT_RGB), picture.rgb);
}

void write_png(const std::filesystem::path& file, const Picture& picture) {
  write_codes(file, describe(picture.width, picture.height, PNG_FORMAT_RGB), picture.rgb);
}

}  // namespace pvol::formats
