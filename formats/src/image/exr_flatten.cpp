// Deep EXR files into flat films. Blocks are unpacked here: OpenEXR believes what they say of
// themselves.
#include <fmt/format.h>

#include <ImfChannelList.h>
#include <ImfHeader.h>
#include <ImfMultiPartInputFile.h>
#include <half.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "image/deep_blocks.h"
#include "image/exr_check.h"
#include "image/exr_out.h"
#include "pvol/error.h"
#include "pvol/formats/image.h"

namespace pvol::formats {
namespace {

using Bytes = std::vector<char>;

/// A channel of the file, and which of a sample's values it is, if any.
struct StoredChannel {
  Imf::PixelType type;
  int value;  ///< in kNames; -1: none
};
constexpr std::array kNames = {"R", "G", "B", "A", "Z", "ZBack"};
using SampleValues = std::array<double, kNames.size()>;
constexpr std::size_t kZ = 4, kZBack = 5;

std::vector<StoredChannel> channels_of(const Imf::Header& header) {
  const Imf::ChannelList& list = header.channels();
  for (const char* name : {"A", "Z"}) {
    if (list.findChannel(name) != nullptr) continue;
    throw Error(std::string("has no channel ") + name + "; deep pictures need R, G, B, A and Z");
  }
  std::vector<StoredChannel> channels;
  for (auto c = list.begin(); c != list.end(); ++c) {  // in the order of their names, as in blocks
    const auto at = std::ranges::find(kNames, std::string_view(c.name()));
    channels.push_back({c.channel().type, at == kNames.end() ? -1 : int(at - kNames.begin())});
  }
  return channels;
}

double value_at(const char* from, Imf::PixelType type) {
  if (type == Imf::HALF) {
    half h;
    std::memcpy(&h, from, sizeof h);
    return double(float(h));
  }
  if (type == Imf::UINT) {
    std::uint32_t u = 0;
    std::memcpy(&u, from, sizeof u);
    return u;
  }
  float f = 0;
  std::memcpy(&f, from, sizeof f);
  return double(f);
}

/// The samples of a row's pixels, one after the other.
struct Row {
  std::vector<std::uint32_t> ends;  ///< of each pixel, as a number of samples
  std::vector<SampleValues> samples;
};

Row take_row(const detail::DeepBlock& block, const std::vector<StoredChannel>& channels) {
  Row row;
  row.ends = block.ends;
  row.samples.resize(row.ends.back());
  const char* next = block.samples.data();
  bool has_back = false;
  for (const StoredChannel& c : channels) {
    for (SampleValues& v : row.samples) {
      if (c.value >= 0) v[std::size_t(c.value)] = value_at(next, c.type);
      next += detail::bytes_of(c.type);
    }
    has_back = has_back || c.value == int(kZBack);
  }
  for (SampleValues& v : row.samples) {
    if (!has_back) v[kZBack] = v[kZ];
  }
  return row;
}

/// What a pixel's samples show together. Throws Error for those that would have to be sorted or
/// split first.
DeepValue flatten(std::span<const SampleValues> samples) {
  std::vector<DeepSample> all;
  for (const SampleValues& v : samples) {
    const DeepSample s{v[kZ], v[kZBack], Vec3d(v[0], v[1], v[2]), v[3]};
    if (!is_finite(s.colour) || !(s.alpha >= 0 && s.alpha <= 1) || !std::isfinite(s.z_back)) {
      throw Error("has a sample that is not finite, or an alpha that is not in [0, 1]");
    }
    if (!(s.z <= s.z_back) || (!all.empty() && s.z < all.back().z_back)) {
      throw Error(
          "has samples that overlap or are not in order of depth; expected those of one picture. "
          "Flatten it with oiiotool DEEP.exr --flatten -o FLAT.exr");
    }
    all.push_back(s);
  }
  return pvol::flatten(all);
}

void add_row(const std::filesystem::path& file, const Row& row, int y, Film& film) {
  std::uint32_t begin = 0;
  for (std::size_t x = 0; x < row.ends.size(); ++x) {
    try {
      const DeepValue v = flatten(std::span(row.samples).subspan(begin, row.ends[x] - begin));
      film.pixels.push_back({v.colour, {}, v.alpha, 1});
    } catch (const Error& e) {
      throw Error(fmt::format("{}: pixel ({}, {}) {}", file.string(), film.x + int(x), film.y + y,
                              e.what()));
    }
    begin = row.ends[x];
  }
}

/// The windows and attributes of a file, and its channels.
StoredFilm read_header(const std::filesystem::path& file, std::vector<StoredChannel>& channels,
                       int& first_row) {
  try {
    const Imf::MultiPartInputFile in(file.c_str());
    const Imf::Header& header = in.header(0);
    detail::check_picture(header);
    channels = channels_of(header);
    first_row = header.dataWindow().min.y;
    StoredFilm stored{.film = detail::film_of(header),
                      .attributes = detail::string_attributes(header)};
    stored.attributes.erase("type");  // of the part: deep
    stored.attributes.erase("name");
    return stored;
  } catch (const Error& e) {
    throw Error(file.string() + ": " + e.what());
  } catch (const std::exception& e) {
    throw Error(file.string() + ": cannot be read as an EXR picture: " + e.what());
  }
}

}  // namespace

StoredFilm flatten_exr(const std::filesystem::path& file) {
  detail::DeepBlocks blocks(file);
  std::vector<StoredChannel> channels;
  int first_row = 0;
  StoredFilm stored = read_header(file, channels, first_row);
  for (int y = 0; y < stored.film.crop_height; ++y) {
    add_row(file, take_row(blocks.read(std::size_t(y), first_row + y), channels), y, stored.film);
  }
  return stored;
}

}  // namespace pvol::formats
