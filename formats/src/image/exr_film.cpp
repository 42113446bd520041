// Films in from the EXR files that write_exr made, and what can be had of others.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "image/exr_check.h"
#include "pvol/error.h"
#include "pvol/formats/image.h"

namespace pvol::formats {
namespace {

constexpr int kBlockRows = 16;

/// The channels that a film is made of; those that are not there read as 0.
constexpr std::array<const char*, 11> kNames = {"R",
                                                "G",
                                                "B",
                                                "A",
                                                "variance.R",
                                                "variance.G",
                                                "variance.B",
                                                "samples",
                                                "count.lookups",
                                                "count.segments",
                                                "count.collisions"};
using Values = std::array<float, kNames.size()>;

bool has(const Imf::InputFile& in, const char* channel) {
  return in.header().channels().findChannel(channel) != nullptr;
}

bool has_variances(const Imf::InputFile& in) {
  return has(in, "variance.R") && has(in, "variance.G") && has(in, "variance.B") &&
         has(in, "samples");
}

/// Sums whose mean and variance of the mean are those given.
PixelSums to_sums(const Values& v, bool variances) {
  PixelSums p;
  p.samples = variances ? std::uint32_t(std::lround(v[7])) : 1;
  const double n = p.samples;
  p.sum = Vec3d(double(v[0]), double(v[1]), double(v[2])) * n;
  p.alpha = double(v[3]) * n;
  if (p.samples > 0) {
    const Vec3d variance{double(v[4]), double(v[5]), double(v[6])};
    p.sum_squares = variance * (n * (n - 1)) + p.sum * p.sum / n;
  }
  p.lookups = std::uint64_t(std::llround(double(v[8]) * n));
  p.segments = std::uint64_t(std::llround(double(v[9]) * n));
  p.collisions = std::uint64_t(std::llround(double(v[10]) * n));
  return p;
}

void check(const Values& v, int x, int y) {
  // Floats above are whole and fit the sums' counter; no pixel gets near.
  constexpr float kMostSamples = 0x1p31f, kMostCounts = 0x1p31f;
  bool ok = true;
  for (const float f : v) ok = ok && std::isfinite(f);
  for (std::size_t i = 4; i < v.size(); ++i) ok = ok && v[i] >= 0;
  ok = ok && v[7] <= kMostSamples && v[7] == std::floor(v[7]);
  for (std::size_t i = 8; i < v.size(); ++i) ok = ok && v[i] <= kMostCounts;
  if (ok) return;
  std::string found;
  for (std::size_t i = 0; i < v.size(); ++i) {
    if (v[i] != 0)
      found += (found.empty() ? "" : ", ") + std::string(kNames[i]) + ' ' + std::to_string(v[i]);
  }
  throw Error("pixel (" + std::to_string(x) + ", " + std::to_string(y) + ") holds " + found +
              "; expected finite values, and variances, samples and counts of at least 0");
}

Film film_of(const Imf::Header& header) {
  const Imath::Box2i &display = header.displayWindow(), &data = header.dataWindow();
  const auto extent = [](int lo, int hi) { return std::int64_t(hi) - lo + 1; };
  const std::int64_t width = extent(display.min.x, display.max.x);
  const std::int64_t height = extent(display.min.y, display.max.y);
  const std::int64_t x = std::int64_t(data.min.x) - display.min.x;
  const std::int64_t y = std::int64_t(data.min.y) - display.min.y;
  constexpr std::int64_t kMost = std::numeric_limits<int>::max();
  if (width < 1 || height < 1 || width > kMost || height > kMost || x < -kMost || x > kMost ||
      y < -kMost || y > kMost) {
    throw Error("has windows whose size makes no sense; it is damaged");
  }
  Film f;
  f.width = int(width), f.height = int(height);
  f.x = int(x), f.y = int(y);
  f.crop_width = int(extent(data.min.x, data.max.x));
  f.crop_height = int(extent(data.min.y, data.max.y));
  return f;
}

Film read_pixels(Imf::InputFile& in) {
  const Imath::Box2i& data = in.header().dataWindow();
  const bool variances = has_variances(in);
  Film film = film_of(in.header());
  const auto width = std::size_t(film.crop_width);
  // Memory grows with what was decoded: a small damaged file cannot ask for gigabytes.
  for (int begin = 0; begin < film.crop_height; begin += kBlockRows) {
    const int rows = std::min(kBlockRows, film.crop_height - begin);
    std::vector<Values> block(width * std::size_t(rows));
    Imf::FrameBuffer buffer;
    for (std::size_t c = 0; c < kNames.size(); ++c) {
      if (!has(in, kNames[c])) continue;
      buffer.insert(
          kNames[c],
          Imf::Slice::Make(Imf::FLOAT, &block[0][c], Imath::V2i{data.min.x, data.min.y + begin},
                           film.crop_width, rows, sizeof(Values), sizeof(Values) * width));
    }
    in.setFrameBuffer(buffer);
    in.readPixels(data.min.y + begin, data.min.y + begin + rows - 1);
    for (std::size_t i = 0; i < block.size(); ++i) {
      check(block[i], film.x + int(i % width), film.y + begin + int(i / width));
      film.pixels.push_back(to_sums(block[i], variances));
    }
  }
  return film;
}

}  // namespace

StoredFilm read_film(const std::filesystem::path& file) {
  try {
    Imf::InputFile in(file.c_str());
    detail::check_picture(in);
    StoredFilm stored;
    stored.film = read_pixels(in);
    stored.has_variances = has_variances(in);
    for (auto a = in.header().begin(); a != in.header().end(); ++a) {
      if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&a.attribute())) {
        stored.attributes[a.name()] = text->value();
      }
    }
    return stored;
  } catch (const Error& e) {
    throw Error(file.string() + ": " + e.what());
  } catch (const std::exception& e) {
    throw Error(file.string() + ": cannot be read as an EXR picture: " + e.what());
  }
}

}  // namespace pvol::formats
