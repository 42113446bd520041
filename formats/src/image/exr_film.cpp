// Films in from the EXR files that write_exr made, and what can be had of others.
#include <fmt/format.h>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "image/cryptomatte.h"
#include "image/exr_check.h"
#include "image/exr_threads.h"
#include "pvol/error.h"
#include "pvol/formats/image.h"
#include "pvol/render/film_channels.h"

namespace pvol::formats {
namespace {

/// A pixel's values of the film's channels, in the order of the table; those that are not there are
/// 0.
using Values = std::array<float, kFilmChannels.size()>;

/// Where a file has something: the part, and the channel's name there.
struct Place {
  int part = 0;
  std::string name;  ///< "": nowhere
};

/// What of a file is read.
struct Layout {
  std::array<Place, kFilmChannels.size()> channels;
  std::vector<std::array<Place, 3>> layers;  ///< of those of the film; unused ones are nowhere

  [[nodiscard]] bool has(std::size_t channel) const { return !channels[channel].name.empty(); }
};

constexpr std::size_t channel_named(std::string_view name) {
  for (std::size_t i = 0; i < kFilmChannels.size(); ++i) {
    if (kFilmChannels[i].name == name) return i;
  }
  return kFilmChannels.size();
}
constexpr std::size_t kSamples = channel_named("samples.Y");
constexpr std::size_t kVariance = channel_named("variance.R");  // and the two after it

bool has_variances(const Layout& l) {
  return l.has(kSamples) && l.has(kVariance) && l.has(kVariance + 1) && l.has(kVariance + 2);
}

/// The parts of the first one's window.
std::vector<int> parts_of(const Imf::MultiPartInputFile& in, std::size_t count) {
  std::vector<int> parts;
  for (int p = 0; p < int(count); ++p) {
    if (in.header(p).dataWindow() == in.header(0).dataWindow()) parts.push_back(p);
  }
  return parts;
}

bool has(const Imf::MultiPartInputFile& in, int part, const std::string& channel) {
  return in.header(part).channels().findChannel(channel) != nullptr;
}

/// Adds a pixel with sums whose mean and variance of the mean are those given.
void add_pixel(Values v, const Layout& layout, Film& film) {
  if (!has_variances(layout)) v[kSamples] = 1;
  const std::size_t pixel = film.pixels.size();
  film.pixels.emplace_back();
  for (std::size_t i = 0; i < v.size(); ++i) {
    if (layout.has(i) || i == kSamples) kFilmChannels[i].put(film, pixel, double(v[i]));
  }
}

bool is_possible(std::size_t channel, float v) {
  constexpr float kMost = 0x1p31f;  // of samples and counts; no pixel gets near
  const FilmChannel& c = kFilmChannels[channel];
  return std::isfinite(v) && (v >= 0 || !c.positive) && (v <= kMost || !c.number);
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

/// Whether the film's own channels include this one, under its name of today or of old.
bool is_the_films(const std::string& name) {
  return std::ranges::any_of(kFilmChannels, [&](const FilmChannel& c) {
    return name == c.name || (c.old_name && name == c.old_name);
  });
}

/// Adds what a part's channels make up that are not the film's own: three that belong together, or
/// one.
void add_layers(const Imf::MultiPartInputFile& in, int part, Film& film, Layout& layout) {
  const auto add = [&](const std::string& stem, const std::string& components) {
    const auto same = [&](const Layer& l) { return l.name == stem; };
    if (std::ranges::any_of(film.layers, same)) return;
    film.layers.push_back({stem, {}, components});
    auto& places = layout.layers.emplace_back();
    for (std::size_t k = 0; k < components.size(); ++k) {
      places[k] = {part, stem + "." + components[k]};
    }
  };
  const Imf::ChannelList& channels = in.header(part).channels();
  for (auto c = channels.begin(); c != channels.end(); ++c) {
    const std::string name = c.name();
    const std::size_t size = name.size();
    if (size < 3 || name[size - 2] != '.' || is_the_films(name)) continue;
    if (name.starts_with(detail::kCryptomatte)) continue;  // made again of the layers of objects
    const std::string stem = name.substr(0, size - 2);
    const auto whole = [&](const std::string& letters) {
      return std::ranges::all_of(letters,
                                 [&](char letter) { return has(in, part, stem + "." + letter); });
    };
    const bool colour = whole("RGB"), vector = !colour && whole("XYZ");
    add(stem, colour ? "RGB" : vector ? "XYZ" : std::string(1, name.back()));
  }
}

Layout layout_of(const Imf::MultiPartInputFile& in, const std::vector<int>& parts, Film& film) {
  Layout layout;
  for (const int part : parts) {
    for (std::size_t i = 0; i < kFilmChannels.size(); ++i) {
      if (layout.has(i)) continue;
      for (const char* name : {kFilmChannels[i].name, kFilmChannels[i].old_name}) {
        if (name && !layout.has(i) && has(in, part, name)) layout.channels[i] = {part, name};
      }
    }
    add_layers(in, part, film, layout);
  }
  return layout;
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

void read_block(Imf::MultiPartInputFile& in, int part, const Layout& layout, Block& b) {
  const Imath::Box2i& window = in.header(part).dataWindow();
  const Imath::V2i origin{window.min.x, window.min.y + b.begin};
  Imf::FrameBuffer buffer;
  const auto insert = [&](const Place& place, float* to, std::size_t stride) {
    if (place.part != part || place.name.empty()) return;
    buffer.insert(place.name, Imf::Slice::Make(Imf::FLOAT, to, origin, std::int64_t(b.width),
                                               b.rows, stride, stride * b.width));
  };
  for (std::size_t c = 0; c < kFilmChannels.size(); ++c) {
    insert(layout.channels[c], &b.values[0][c], sizeof(Values));
  }
  for (std::size_t k = 0; k < b.layers.size(); ++k) {
    for (int axis = 0; axis < 3; ++axis) {
      insert(layout.layers[k][std::size_t(axis)], &b.layers[k][0][axis], sizeof(Vec3f));
    }
  }
  if (buffer.begin() == buffer.end()) return;
  Imf::InputPart input(in, part);
  input.setFrameBuffer(buffer);
  input.readPixels(origin.y, origin.y + b.rows - 1);
}

void add_block(const Block& b, const Layout& layout, Film& film) {
  for (std::size_t i = 0; i < b.values.size(); ++i) {
    const int x = film.x + int(i % b.width), y = film.y + b.begin + int(i / b.width);
    check(b.values[i], x, y);
    add_pixel(b.values[i], layout, film);
    for (std::size_t k = 0; k < b.layers.size(); ++k) {
      if (!is_finite(b.layers[k][i])) {
        throw Error("pixel (" + std::to_string(x) + ", " + std::to_string(y) + ") of the layer " +
                    film.layers[k].name + " is not finite");
      }
      film.layers[k].sums.push_back(Vec3d(b.layers[k][i]) * double(film.pixels.back().samples));
    }
  }
}

StoredFilm read_pixels(Imf::MultiPartInputFile& in, const std::vector<int>& parts) {
  StoredFilm stored;
  Film& film = stored.film;
  film = detail::film_of(in.header(0));
  const Layout layout = layout_of(in, parts, film);
  stored.has_variances = has_variances(layout);
  for (std::size_t i = 0; i < kFilmChannels.size(); ++i) {
    if (kFilmChannels[i].aov && layout.has(i)) stored.figures.add(*kFilmChannels[i].aov);
  }
  // Memory grows with what was decoded: a small damaged file cannot ask for gigabytes.
  const auto width = std::size_t(film.crop_width);
  const int at_once = detail::rows_at_once(
      film.crop_height, width * (sizeof(Values) + film.layers.size() * sizeof(Vec3f)));
  for (int begin = 0; begin < film.crop_height; begin += at_once) {
    Block block(begin, std::min(at_once, film.crop_height - begin), width, film.layers.size());
    for (const int part : parts) read_block(in, part, layout, block);
    add_block(block, layout, film);
  }
  return stored;
}

}  // namespace

StoredFilm read_film(const std::filesystem::path& file) {
  const std::size_t count = detail::check_exr_file(file);
  try {
    Imf::MultiPartInputFile in(file.c_str());
    detail::check_picture(in.header(0));
    const std::vector<int> parts = parts_of(in, count);
    for (const int part : parts) detail::check_complete(in.partComplete(part));
    StoredFilm stored = read_pixels(in, parts);
    stored.attributes = detail::string_attributes(in.header(0));
    return stored;
  } catch (const Error& e) {
    throw Error(file.string() + ": " + e.what());
  } catch (const std::exception& e) {
    throw Error(file.string() + ": cannot be read as an EXR picture: " + e.what());
  }
}

}  // namespace pvol::formats
