// Pictures out to OpenEXR, sky pictures in.
#include <fmt/format.h>

#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStdIO.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>

#include "image/exr_check.h"
#include "pvol/error.h"
#include "pvol/formats/atomic_file.h"
#include "pvol/formats/image.h"
#include "pvol/render/film_channels.h"

namespace pvol::formats {
namespace {

constexpr int kBlockRows = 16;  // the rows that OpenEXR's zip compresses together

/// A channel of a file, and its value at a pixel.
struct Channel {
  std::string name;
  std::function<double(std::size_t pixel)> value;
};

/// The channels that a film has something in.
std::vector<Channel> channels_of(const Film& film) {
  const bool counted = std::any_of(film.pixels.begin(), film.pixels.end(), [](const PixelSums& p) {
    return p.counts != PixelSums{}.counts;
  });
  std::vector<Channel> channels;
  for (const FilmChannel& c : kFilmChannels) {
    if (c.counted && !counted) continue;
    channels.push_back({c.name, [&](std::size_t i) { return c.get(film.pixels[i]); }});
  }
  for (const Layer& layer : film.layers) {
    for (int axis = 0; axis < 3; ++axis) {
      channels.push_back({layer.name + kLayerParts[axis], [&, axis](std::size_t i) {
                            return per_sample(film.pixels[i], layer.sums[i][axis]);
                          }});
    }
  }
  return channels;
}

Imf::Header header_of(const Film& film, const std::vector<Channel>& channels,
                      const std::map<std::string, std::string>& attributes) {
  const Imath::Box2i display({0, 0}, {film.width - 1, film.height - 1});
  const Imath::Box2i data({film.x, film.y},
                          {film.x + film.crop_width - 1, film.y + film.crop_height - 1});
  Imf::Header header(display, data);
  header.compression() = Imf::ZIP_COMPRESSION;
  Imf::addChromaticities(header, Imf::Chromaticities());  // the default is Rec.709 with D65
  for (const Channel& c : channels) header.channels().insert(c.name, Imf::Channel(Imf::FLOAT));
  for (const auto& [name, text] : attributes) {
    if (header.find(name) != header.end()) {
      throw Error("the attribute " + name + " has a meaning of its own in EXR files; rename it");
    }
    header.insert(name, Imf::StringAttribute(text));
  }
  return header;
}

/// Writes block by block, so that no second copy of the picture is needed.
void write_pixels(Imf::OutputFile& out, const Film& film, const std::vector<Channel>& channels) {
  const std::size_t pixel_bytes = channels.size() * sizeof(float);
  const std::size_t row_bytes = std::size_t(film.crop_width) * pixel_bytes;
  std::vector<float> block(row_bytes / sizeof(float) * kBlockRows);
  for (int begin = 0; begin < film.crop_height; begin += kBlockRows) {
    const int rows = std::min(kBlockRows, film.crop_height - begin);
    std::size_t next = 0;
    for (int y = begin; y < begin + rows; ++y) {
      for (int x = 0; x < film.crop_width; ++x) {
        for (const Channel& c : channels) block[next++] = float(c.value(film.index(x, y)));
      }
    }
    Imf::FrameBuffer buffer;
    for (std::size_t c = 0; c < channels.size(); ++c) {
      buffer.insert(channels[c].name,
                    Imf::Slice::Make(Imf::FLOAT, &block[c], {film.x, film.y + begin},
                                     film.crop_width, rows, pixel_bytes, row_bytes));
    }
    out.setFrameBuffer(buffer);
    out.writePixels(rows);
  }
}

void check_radiance(Rgb c, std::size_t index, std::size_t width) {
  if (is_finite(c) && min_component(c) >= 0) return;
  throw Error(
      fmt::format("pixel ({}, {}) is ({:f}, {:f}, {:f}); expected finite radiance of at least 0",
                  index % width, index / width, c.x, c.y, c.z));
}

ImageSky read_pixels(Imf::InputFile& in) {
  const Imath::Box2i& box = in.header().dataWindow();
  ImageSky sky;
  sky.width = box.max.x - box.min.x + 1;
  sky.height = box.max.y - box.min.y + 1;
  const std::size_t width = std::size_t(sky.width);
  // Memory grows with what was decoded: a small damaged file cannot ask for gigabytes.
  for (int begin = 0; begin < sky.height; begin += kBlockRows) {
    const int rows = std::min(kBlockRows, sky.height - begin);
    const std::size_t first = sky.pixels.size();
    sky.pixels.resize(first + width * std::size_t(rows));
    const Imath::V2i origin{box.min.x, box.min.y + begin};
    Imf::FrameBuffer buffer;
    const auto add = [&](const char* name, const float* at) {
      buffer.insert(name, Imf::Slice::Make(Imf::FLOAT, at, origin, sky.width, rows, sizeof(Rgb),
                                           sizeof(Rgb) * width));
    };
    add("R", &sky.pixels[first].x);
    add("G", &sky.pixels[first].y);
    add("B", &sky.pixels[first].z);
    in.setFrameBuffer(buffer);
    in.readPixels(origin.y, origin.y + rows - 1);
    for (std::size_t i = first; i < sky.pixels.size(); ++i) check_radiance(sky.pixels[i], i, width);
  }
  return sky;
}

}  // namespace

void write_exr(const std::filesystem::path& file, const Film& film,
               const std::map<std::string, std::string>& attributes) {
  if (film.crop_width < 1 || film.crop_height < 1) {
    throw Error(file.string() + ": the picture has no pixels; choose a size of at least 1 x 1");
  }
  write_atomically(file, [&](const std::filesystem::path& aside) {
    try {
      const std::vector<Channel> channels = channels_of(film);
      const Imf::Header header = header_of(film, channels, attributes);
      std::ofstream stream(aside, std::ios::binary);
      {
        Imf::StdOFStream exr_stream(stream, file.c_str());
        Imf::OutputFile out(exr_stream, header);
        write_pixels(out, film, channels);
      }
      // The destructor of OutputFile writes the offsets of the blocks and hides what goes wrong.
      stream.close();
      if (!stream) throw Error("writing failed; is the disk full?");
    } catch (const std::exception& e) {
      throw Error(file.string() + ": " + e.what());
    }
  });
}

ImageSky read_sky(const std::filesystem::path& file) {
  detail::check_exr_file(file);
  try {
    Imf::InputFile in(file.c_str());
    detail::check_picture(in);
    return read_pixels(in);
  } catch (const Error& e) {
    throw Error(file.string() + ": " + e.what());
  } catch (const std::exception& e) {
    throw Error(file.string() + ": cannot be read as an EXR picture: " + e.what());
  }
}

}  // namespace pvol::formats
