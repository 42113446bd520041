#include "image/deep_blocks.h"

#include <fmt/format.h>

#include <zlib.h>

#include <cstring>

#include "image/exr_check.h"
#include "image/exr_zip.h"
#include "pvol/error.h"

namespace pvol::formats::detail {
namespace {

constexpr std::uint64_t kLargestRow = std::uint64_t{1} << 28;  // bytes

/// Undoes what zips does before it packs: differences of bytes, those of odd places behind those of
/// even ones.
void restore(const std::vector<char>& from, std::vector<char>& to) {
  const std::size_t half = from.size() / 2;  // every value has an even number of bytes
  unsigned byte = 128;
  for (std::size_t i = 0; i < from.size(); ++i) {
    byte = (byte + static_cast<unsigned char>(from[i]) - 128) & 255;
    to[i < half ? 2 * i : 2 * (i - half) + 1] = static_cast<char>(byte);
  }
}

}  // namespace

DeepBlocks::DeepBlocks(const std::filesystem::path& file)
    : source_(file), headers_(read_exr_headers(source_)) {
  const ExrPart& p = part();
  const auto refuse = [&](const char* what) { throw Error(file.string() + ": " + what); };
  if (!p.deep) refuse("found a flat picture; expected a deep one");
  if (headers_.several || p.tiled) {
    refuse("has deep pixels in tiles or several parts; expected scanlines in one part");
  }
  const bool zips = p.packing == ExrPacking::zip && p.block_rows == 1;
  if (!zips && p.packing != ExrPacking::none) {
    refuse("found an unsupported compression; expected zips or none: write it with one of those");
  }
  check_deep_part(file, p, source_.size());
}

const DeepBlock& DeepBlocks::read(std::size_t row, int y) {
  ByteCursor table(source_, {headers_.end, source_.size()}, "the table of blocks");
  table.skip(row * sizeof(std::uint64_t));
  const auto offset = table.value<std::uint64_t>();
  const std::string place = fmt::format("row {}", row);
  if (offset > source_.size()) table.fail(place + " lies behind its end; the file is incomplete");
  ByteCursor cursor(source_, {offset, source_.size()}, place);
  if (cursor.value<std::int32_t>() != y) cursor.fail("another row; the file is damaged");
  const auto packed_counts = cursor.value<std::uint64_t>();
  const auto packed = cursor.value<std::uint64_t>(), size = cursor.value<std::uint64_t>();

  block_.ends.resize(std::size_t(part().width));
  const std::uint64_t count_bytes = sizeof(std::uint32_t) * block_.ends.size();
  unpack(cursor, packed_counts, count_bytes, unpacked_);
  std::memcpy(block_.ends.data(), unpacked_.data(), count_bytes);
  std::uint32_t before = 0;
  for (const std::uint32_t end : block_.ends) {
    if (end < before) cursor.fail("counts of samples that decrease; the file is damaged");
    before = end;
  }
  if (size != before * part().pixel_bytes) {
    cursor.fail("samples of another size than their counts; the file is damaged");
  }
  unpack(cursor, packed, size, block_.samples);
  return block_;
}

/// Takes `packed` bytes that stand for `size`.
void DeepBlocks::unpack(ByteCursor& cursor, std::uint64_t packed, std::uint64_t size,
                        std::vector<char>& to) {
  if (packed > cursor.left() || size / kBestZipRatio > packed || size > kLargestRow) {
    cursor.fail("sizes that do not fit the file; it is damaged or cut off");
  }
  to.resize(size);
  if (packed == size) {  // where packing does not pay it is left
    cursor.copy(to.data(), size);
    return;
  }
  packed_.resize(packed);
  cursor.copy(packed_.data(), packed);
  std::vector<char> bytes(size);
  uLongf found = size;
  const int result = ::uncompress(reinterpret_cast<Bytef*>(bytes.data()), &found,
                                  reinterpret_cast<const Bytef*>(packed_.data()), uLong(packed));
  if (part().packing == ExrPacking::none || result != Z_OK || found != size) {
    cursor.fail("a row that does not unpack to its size; the file is damaged");
  }
  restore(bytes, to);
}

}  // namespace pvol::formats::detail
