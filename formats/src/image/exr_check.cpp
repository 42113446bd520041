#include "image/exr_check.h"

#include <fmt/format.h>

#include <ImfChannelList.h>
#include <ImfHeader.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <cstdint>
#include <limits>

#include "image/exr_block.h"
#include "image/exr_color.h"
#include "image/exr_header.h"
#include "image/exr_zip.h"
#include "pvol/error.h"
#include "pvol/render/options.h"

namespace pvol::formats::detail {
namespace {

constexpr std::int64_t kMostPixels = std::int64_t{1} << 28;
constexpr std::int64_t kLargestTile = std::int64_t{1} << 16;
constexpr std::uint64_t kFewPixels = std::uint64_t{1} << 24;
constexpr std::uint64_t kLargestBlock = std::uint64_t{1} << 28;  // bytes

std::string names_of(const Imf::ChannelList& channels) {
  std::string names;
  for (auto c = channels.begin(); c != channels.end(); ++c) {
    names += (names.empty() ? "" : ", ") + std::string(c.name());
  }
  return names.empty() ? "none" : names;
}

void check_window(const ExrPart& p) {
  if (p.width >= 1 && p.height >= 1 && p.width <= kLargestEdge && p.height <= kLargestEdge &&
      p.width * p.height <= kMostPixels) {
    return;
  }
  throw Error(
      fmt::format("has {} x {} pixels; expected 1 to 2^20 along each edge and at most 2^28 in all",
                  p.width, p.height));
}

/// Some compressions make kilobytes of a picture of one colour that fills memory.
void check_ratio(const ExrPart& p, std::uint64_t file_bytes) {
  const auto pixels = std::uint64_t(p.width * p.height);
  if (pixels <= kFewPixels || pixels * p.pixel_bytes / kBestZipRatio <= file_bytes) return;
  throw Error(
      fmt::format("has {} x {} pixels in {} bytes; expected at most 2^24 pixels when compressed "
                  "below a thousandth: write it smaller, or with another compression",
                  p.width, p.height, file_bytes));
}

/// Compares what OpenEXR takes memory for, the table of blocks and a row of them, with the file.
void check_table(const ExrPart& p, std::uint64_t file_bytes) {
  const std::int64_t width = p.tiled ? p.tile_width : p.width;
  const std::int64_t rows = p.tiled ? p.tile_height : p.block_rows;
  const bool large = p.tiled && (width > kLargestTile || rows > kLargestTile);
  if (width < 1 || rows < 1 || large) {
    throw Error(fmt::format("has tiles of {} x {} pixels; expected 1 to 2^16 along each edge",
                            width, rows));
  }
  const auto count = [](std::int64_t pixels, std::int64_t each) {
    return std::uint64_t((pixels + each - 1) / each);
  };
  const std::uint64_t blocks = count(p.width, width) * count(p.height, rows);
  if (blocks > file_bytes / sizeof(std::uint64_t)) {  // the offset of each
    throw Error(fmt::format(
        "is incomplete: its {} bytes do not hold {} blocks of pixels; copy or write it again",
        file_bytes, blocks));
  }
  const std::uint64_t row_bytes =
      std::uint64_t(std::max(width, p.width)) * std::uint64_t(rows) * p.pixel_bytes;
  if (row_bytes > std::max(kLargestBlock, kBestZipRatio * file_bytes)) {
    throw Error(fmt::format(
        "has blocks of {} rows that take {} bytes; expected at most 2^28, or a thousand times the "
        "file: write it with smaller tiles, fewer channels or another compression",
        rows, row_bytes));
  }
}

/// The parts of a film as if they were one, of the largest window and the largest blocks.
ExrPart in_one(const ExrHeaders& headers) {
  ExrPart all = headers.parts.front();
  for (std::size_t i = 1; i < headers.parts.size(); ++i) {
    const ExrPart& p = headers.parts[i];
    all.width = std::max(all.width, p.width), all.height = std::max(all.height, p.height);
    all.block_rows = std::max(all.block_rows, p.block_rows);
    all.pixel_bytes += p.pixel_bytes;
  }
  return all;
}

}  // namespace

std::size_t check_exr_file(const std::filesystem::path& file) {
  ByteSource source(file);
  const ExrHeaders headers = read_exr_headers(source);
  try {
    if (headers.parts.front().deep) {
      throw Error(
          "has deep pixels, with several samples each; expected one: flatten it with pvol-convert "
          "DEEP.exr FLAT.exr");
    }
    for (const ExrPart& part : headers.parts) {
      check_window(part);
      check_table(part, source.size());
      check_ratio(part, source.size());
    }
    if (film_parts(headers) > 1) {
      const ExrPart all = in_one(headers);
      check_table(all, source.size());
      check_ratio(all, source.size());
    }
  } catch (const Error& e) {
    throw Error(file.string() + ": " + e.what());
  }
  check_blocks(source, headers);
  return film_parts(headers);
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
    throw Error("has windows of impossible size; it is damaged");
  }
  Film f;
  f.width = int(width), f.height = int(height);
  f.x = int(x), f.y = int(y);
  f.crop_width = int(extent(data.min.x, data.max.x));
  f.crop_height = int(extent(data.min.y, data.max.y));
  f.color_space = space_of(header);
  return f;
}

std::map<std::string, std::string> string_attributes(const Imf::Header& header) {
  std::map<std::string, std::string> attributes;
  for (auto a = header.begin(); a != header.end(); ++a) {
    if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&a.attribute())) {
      attributes[a.name()] = text->value();
    }
  }
  return attributes;
}

void check_picture(const Imf::Header& header) {
  const Imf::ChannelList& channels = header.channels();
  for (const char* name : {"R", "G", "B"}) {
    if (channels.findChannel(name)) continue;
    throw Error(std::string("has no channel ") + name + "; expected R, G and B, found " +
                names_of(channels));
  }
  for (auto c = channels.begin(); c != channels.end(); ++c) {
    if (c.channel().xSampling == 1 && c.channel().ySampling == 1) continue;
    throw Error(std::string("has fewer samples than pixels in its channel ") + c.name() +
                "; write it without that channel, or with all samples");
  }
}

void check_deep_part(const std::filesystem::path& file, ExrPart part, std::uint64_t file_bytes) {
  part.pixel_bytes = sizeof(std::uint32_t);  // at least its number of samples
  try {
    check_window(part);
    check_table(part, file_bytes);
    check_ratio(part, file_bytes);
  } catch (const Error& e) {
    throw Error(file.string() + ": " + e.what());
  }
}

void check_complete(bool complete) {
  if (!complete) throw Error("is incomplete: pixels are missing; copy or write it again");
}

}  // namespace pvol::formats::detail
