// Films in from the EXR files that write_exr made, and what can be had of others.
#include <fmt/format.h>

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
#include "pvol/render/film_channels.h"

namespace pvol::formats {
namespace {

constexpr int kBlockRows = 16;
constexpr std::size_t kSamples = 0;  // first in the table

/// The values of a pixel's channels, in the order of the table; those that are not there are 0.
using Values = std::array<float, kFilmChannels.size()>;

bool has(const Imf::InputFile& in, const char* channel) {
  return in.header().channels().findChannel(channel) != nullptr;
}

bool has_variances(const Imf::InputFile& in) {
  return has(in, "variance.R") && has(in, "variance.G") && has(in, "variance.B") &&
         has(in, "samples");
}

/// Sums whose mean and variance of the mean are those given.
PixelSums to_sums(Values v, bool variances) {
  if (!variances) v[kSamples] = 1;
  PixelSums p;
  for (std::size_t i = 0; i < v.size(); ++i) kFilmChannels[i].put(p, double(v[i]));
  return p;
}

bool is_possible(std::size_t channel, float v) {
  constexpr float kMost = 0x1p31f;  // of samples and counts; no pixel gets near
  const FilmChannel& c = kFilmChannels[channel];
  const bool counts = c.counted || channel == kSamples;
  return std::isfinite(v) && (v >= 0 || !c.positive) && (v <= kMost || !counts);
}

void check(const Values& v, int x, int y) {
  bool ok = v[kSamples] == std::floor(v[kSamples]);
  for (std::size_t i = 0; i < v.size(); ++i) ok = ok && is_possible(i, v[i]);
  if (ok) return;
  std::string found;
  for (std::size_t i = 0; i < v.size(); ++i) {
    if (v[i] == 0) continue;
    found += fmt::format("{}{} {:f}", (found.empty() ? "" : ", "),
                         std::string(kFilmChannels[i].name), v[i]);
  }
  throw Error(
      fmt::format("pixel ({}, {}) holds {}; expected finite values, and variances, samples and "
                  "counts of at least 0",
                  x, y, found));
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

/// Names of layers: what other channels have all three parts, but for the variance.
std::vector<Layer> layers_of(const Imf::InputFile& in) {
  std::vector<Layer> layers;
  const Imf::ChannelList& channels = in.header().channels();
  for (auto c = channels.begin(); c != channels.end(); ++c) {
    const std::string name = c.name();
    if (!name.ends_with(kLayerParts[0])) continue;
    const std::string stem = name.substr(0, name.size() - std::string(kLayerParts[0]).size());
    const bool whole =
        has(in, (stem + kLayerParts[1]).c_str()) && has(in, (stem + kLayerParts[2]).c_str());
    if (whole && !stem.empty() && stem != "variance") layers.push_back({stem, {}});
  }
  return layers;
}

/// Where a block of rows is read to: values of the film's channels and of its layers.
struct Block {
  int begin, rows;
  std::size_t width;
  std::vector<Values> values;
  std::vector<std::vector<Vec3f>> layers;

  Block(int begin_, int rows_, std::size_t width_, std::size_t layer_count)
      : begin(begin_),
        rows(rows_),
        width(width_),
        values(width * std::size_t(rows)),
        layers(layer_count, std::vector<Vec3f>(values.size())) {}
};

void read_block(Imf::InputFile& in, const Film& film, Block& b) {
  const Imath::V2i origin{in.header().dataWindow().min.x, in.header().dataWindow().min.y + b.begin};
  Imf::FrameBuffer buffer;
  const auto insert = [&](const std::string& name, float* to, std::size_t stride) {
    buffer.insert(name, Imf::Slice::Make(Imf::FLOAT, to, origin, film.crop_width, b.rows, stride,
                                         stride * b.width));
  };
  for (std::size_t c = 0; c < kFilmChannels.size(); ++c) {
    if (has(in, kFilmChannels[c].name)) {
      insert(kFilmChannels[c].name, &b.values[0][c], sizeof(Values));
    }
  }
  for (std::size_t k = 0; k < b.layers.size(); ++k) {
    for (int axis = 0; axis < 3; ++axis) {
      insert(film.layers[k].name + kLayerParts[std::size_t(axis)], &b.layers[k][0][axis],
             sizeof(Vec3f));
    }
  }
  in.setFrameBuffer(buffer);
  in.readPixels(origin.y, origin.y + b.rows - 1);
}

void add_block(const Block& b, bool variances, Film& film) {
  for (std::size_t i = 0; i < b.values.size(); ++i) {
    const int x = film.x + int(i % b.width), y = film.y + b.begin + int(i / b.width);
    check(b.values[i], x, y);
    film.pixels.push_back(to_sums(b.values[i], variances));
    for (std::size_t k = 0; k < b.layers.size(); ++k) {
      if (!is_finite(b.layers[k][i])) {
        throw Error("pixel (" + std::to_string(x) + ", " + std::to_string(y) + ") of the layer " +
                    film.layers[k].name + " is not finite");
      }
      film.layers[k].sums.push_back(Vec3d(b.layers[k][i]) * double(film.pixels.back().samples));
    }
  }
}

Film read_pixels(Imf::InputFile& in) {
  const bool variances = has_variances(in);
  Film film = film_of(in.header());
  film.layers = layers_of(in);
  // Memory grows with what was decoded: a small damaged file cannot ask for gigabytes.
  for (int begin = 0; begin < film.crop_height; begin += kBlockRows) {
    Block block(begin, std::min(kBlockRows, film.crop_height - begin), std::size_t(film.crop_width),
                film.layers.size());
    read_block(in, film, block);
    add_block(block, variances, film);
  }
  return film;
}

}  // namespace

StoredFilm read_film(const std::filesystem::path& file) {
  detail::check_exr_file(file);
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
