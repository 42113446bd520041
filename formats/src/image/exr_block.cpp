#include "image/exr_block.h"

#include <fmt/format.h>

#include <zlib.h>

#include <algorithm>
#include <vector>

#include "image/exr_zip.h"
#include "pvol/error.h"

namespace pvol::formats::detail {
namespace {

using Bytes = std::vector<Bytef>;

/// A block as the table has it.
struct Block {
  std::uint64_t offset;  ///< in the file
  std::uint64_t bytes;   ///< of its pixels
  std::int64_t number;
};

/// The blocks of a part, or its tiles of full resolution, in their order in the file. `begin` is
/// where their table is, and then where it ends.
std::vector<Block> take_blocks(ByteSource& source, const ExrPart& p, std::uint64_t& begin) {
  const std::int64_t width = p.tiled ? p.tile_width : p.width;
  const std::int64_t rows = p.tiled ? p.tile_height : p.block_rows;
  ByteCursor table(source, {begin, source.size()}, "the table of blocks");
  std::vector<Block> blocks;
  for (std::int64_t y = 0; y < p.height; y += rows) {
    for (std::int64_t x = 0; x < p.width; x += width) {
      const std::int64_t pixels = std::min(width, p.width - x) * std::min(rows, p.height - y);
      const auto offset = table.value<std::uint64_t>();
      blocks.push_back(
          {offset, std::uint64_t(pixels) * p.pixel_bytes, std::int64_t(blocks.size())});
    }
  }
  begin = table.position();
  std::ranges::sort(blocks, {}, &Block::offset);
  return blocks;
}

/// Whether zip unpacks to so many bytes. `room` is used again for each block.
bool unzips_to(std::uint64_t bytes, const Bytes& stored, Bytes& room) {
  if (bytes / kBestZipRatio > stored.size()) return false;
  room.resize(std::max<std::size_t>(room.size(), bytes));
  uLongf found = bytes;
  return ::uncompress(room.data(), &found, stored.data(), stored.size()) == Z_OK && found == bytes;
}

/// Whether runs do: each begins with a count of bytes that are repeated, less one, or of those that
/// follow, negated.
bool runs_to(std::uint64_t bytes, const Bytes& stored) {
  std::uint64_t found = 0;
  std::size_t at = 0;
  while (at < stored.size()) {
    const int count = static_cast<signed char>(stored[at]);
    found += std::uint64_t(count < 0 ? -count : count + 1);
    at += count < 0 ? std::size_t(1 - count) : 2;
  }
  return at == stored.size() && found == bytes;
}

bool fills(std::uint64_t bytes, ExrPacking packing, const Bytes& stored, Bytes& room) {
  if (stored.size() == bytes) return true;  // not compressed
  return packing == ExrPacking::zip    ? unzips_to(bytes, stored, room)
         : packing == ExrPacking::runs ? runs_to(bytes, stored)
                                       : false;
}

/// `place` is how many bytes of a block say where it belongs.
void check_part(ByteSource& source, const ExrPart& p, const std::vector<Block>& blocks,
                std::uint64_t first, std::uint64_t place) {
  const bool unpacks = p.packing != ExrPacking::other && !p.subsampled;
  Bytes stored, room;
  for (const Block& b : blocks) {
    if (b.offset < first) continue;  // OpenEXR finds which blocks were not written
    const std::uint64_t begin = std::min(b.offset, source.size());
    ByteCursor block(source, {begin, source.size()}, fmt::format("block {}", b.number));
    const bool begins = block.left() >= place + sizeof(std::uint32_t);
    if (begins) block.skip(place);
    const std::uint32_t size = begins ? block.value<std::uint32_t>() : 0;
    if (!begins || size > block.left()) {
      throw Error(
          fmt::format("{}: is incomplete: block {} of its pixels lies beyond the end of the file; "
                      "copy or write it again",
                      source.file().string(), b.number));
    }
    if (!unpacks) continue;
    stored.resize(size);
    block.copy(reinterpret_cast<char*>(stored.data()), size);
    if (fills(b.bytes, p.packing, stored, room)) continue;
    throw Error(
        fmt::format("{}: block {} of its pixels does not fill {} bytes, the size in its header; "
                    "the file is damaged",
                    source.file().string(), b.number, b.bytes));
  }
}

}  // namespace

void check_blocks(ByteSource& source, const ExrHeaders& headers) {
  std::uint64_t table = headers.end;
  for (std::size_t i = 0; i < film_parts(headers); ++i) {
    const ExrPart& p = headers.parts[i];
    const std::vector<Block> blocks = take_blocks(source, p, table);
    check_part(source, p, blocks, headers.end, (headers.several ? 4 : 0) + (p.tiled ? 16 : 4));
  }
}

}  // namespace pvol::formats::detail
