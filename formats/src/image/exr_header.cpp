#include "image/exr_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "file/grid_choice.h"
#include "pvol/error.h"

namespace pvol::formats::detail {
namespace {

constexpr std::uint32_t kMagic = 20000630;
constexpr std::uint32_t kTiled = 0x200, kDeep = 0x800, kMultiPart = 0x1000;  // beside the version
constexpr std::size_t kLongestName = 255;

/// A compression, and the rows that it takes together.
struct Compression {
  ExrPacking packing;
  std::int64_t rows;
};
constexpr Compression kCompressions[] = {
    {ExrPacking::none, 1},   {ExrPacking::runs, 1},    // rle
    {ExrPacking::zip, 1},    {ExrPacking::zip, 16},    // zips, zip
    {ExrPacking::other, 32}, {ExrPacking::other, 16},  // piz, pxr24
    {ExrPacking::other, 32}, {ExrPacking::other, 32},  // b44, b44a
    {ExrPacking::other, 32}, {ExrPacking::other, 256}  // dwaa, dwab
};

/// Types whose values have always as many bytes: that many OpenEXR reads, whatever the size says.
struct FixedType {
  std::string_view name;
  std::uint32_t bytes;
};
constexpr FixedType kFixedTypes[] = {{"box2f", 16},
                                     {"box2i", 16},
                                     {"chromaticities", 32},
                                     {"compression", 1},
                                     {"deepImageState", 1},
                                     {"double", 8},
                                     {"envmap", 1},
                                     {"float", 4},
                                     {"int", 4},
                                     {"keycode", 28},
                                     {"lineOrder", 1},
                                     {"m33d", 72},
                                     {"m33f", 36},
                                     {"m44d", 128},
                                     {"m44f", 64},
                                     {"rational", 8},
                                     {"tiledesc", 9},
                                     {"timecode", 8},
                                     {"v2d", 16},
                                     {"v2f", 8},
                                     {"v2i", 8},
                                     {"v3d", 24},
                                     {"v3f", 12},
                                     {"v3i", 12}};

/// Text up to a zero.
std::string take_name(ByteCursor& cursor) {
  std::string name;
  while (const char c = cursor.value<char>()) {
    name += c;
    if (name.size() > kLongestName) cursor.fail("a name without an end; the file is damaged");
  }
  return name;
}

void take_window(ByteCursor& cursor, ExrPart& part) {
  std::int64_t corners[4];  // least and greatest x and y, all inside
  for (std::int64_t& c : corners) c = cursor.value<std::int32_t>();
  part.width = corners[2] - corners[0] + 1;
  part.height = corners[3] - corners[1] + 1;
}

void take_tiles(ByteCursor& cursor, ExrPart& part) {
  part.tile_width = cursor.value<std::uint32_t>();
  part.tile_height = cursor.value<std::uint32_t>();
  cursor.skip(1);  // which levels there are
}

void take_compression(ByteCursor& cursor, ExrPart& part) {
  const auto method = cursor.value<std::uint8_t>();
  if (method >= std::size(kCompressions)) {
    cursor.fail(fmt::format("compression {} is unknown; write the picture with another", method));
  }
  part.packing = kCompressions[method].packing;
  part.block_rows = kCompressions[method].rows;
}

/// Adds channels to those of earlier lists, as OpenEXR does.
void take_channels(ByteCursor& cursor, ExrPart& part) {
  constexpr std::uint64_t kBytes[] = {4, 2, 4};  // integer, half, float
  while (!take_name(cursor).empty()) {
    const auto type = cursor.value<std::uint32_t>();
    if (type >= std::size(kBytes)) cursor.fail("a channel of unknown type; the file is damaged");
    part.pixel_bytes += kBytes[type];
    cursor.skip(4);  // a flag and padding
    const auto along_x = cursor.value<std::int32_t>(), along_y = cursor.value<std::int32_t>();
    part.subsampled |= along_x != 1 || along_y != 1;
  }
}

/// One attribute, whose name was taken already.
void take_attribute(ByteCursor& cursor, const std::string& name, ExrPart& part) {
  const std::string type = take_name(cursor);
  const auto size = cursor.value<std::uint32_t>();
  const auto fixed = std::find_if(std::begin(kFixedTypes), std::end(kFixedTypes),
                                  [&](const FixedType& t) { return t.name == type; });
  if (size > cursor.left() || (fixed != std::end(kFixedTypes) && fixed->bytes != size)) {
    cursor.fail(fmt::format("the attribute '{}' has {} bytes; the file is damaged or cut off",
                            printable(name), size));
  }
  const std::uint64_t end = cursor.position() + size;
  if (name == "dataWindow" && type == "box2i") {
    take_window(cursor, part);
  } else if (name == "tiles" && type == "tiledesc") {
    take_tiles(cursor, part);
  } else if (name == "compression" && type == "compression") {
    take_compression(cursor, part);
  } else if (type == "chlist") {
    take_channels(cursor, part);
  } else if (name == "type" && type == "string" && size <= kLongestName) {
    const std::string_view kind(cursor.bytes(size), size);
    part.deep = kind.starts_with("deep");
    part.tiled = kind == "tiledimage" || kind == "deeptile";
  } else {
    cursor.skip(size);
  }
  if (cursor.position() != end) cursor.fail("a list of another size; the file is damaged");
}

/// The attributes of a part, from the name of the first one, and the zero after the last.
ExrPart take_header(ByteCursor& cursor, std::string name) {
  ExrPart part;
  for (; !name.empty(); name = take_name(cursor)) take_attribute(cursor, name, part);
  return part;
}

}  // namespace

std::size_t film_parts(const ExrHeaders& headers) {
  const bool plain = std::ranges::none_of(
      headers.parts, [](const ExrPart& p) { return p.tiled || p.deep || p.subsampled; });
  return plain ? headers.parts.size() : 1;
}

ExrHeaders read_exr_headers(ByteSource& source) {
  ByteCursor cursor(source, {0, source.size()}, "the header");
  if (source.size() < 2 * sizeof kMagic || cursor.value<std::uint32_t>() != kMagic) {
    throw Error(source.file().string() + ": is not an EXR picture");
  }
  const auto flags = cursor.value<std::uint32_t>();
  ExrHeaders headers;
  headers.several = (flags & kMultiPart) != 0;
  if (headers.several) {
    for (std::string name = take_name(cursor); !name.empty(); name = take_name(cursor)) {
      headers.parts.push_back(take_header(cursor, name));
    }
    if (headers.parts.empty()) cursor.fail("no part; the file is damaged");
  } else {
    ExrPart part = take_header(cursor, take_name(cursor));
    part.tiled = (flags & kTiled) != 0;  // the type may be wrong, says OpenEXR
    part.deep |= (flags & kDeep) != 0;
    headers.parts.push_back(part);
  }
  headers.end = cursor.position();
  return headers;
}

}  // namespace pvol::formats::detail
