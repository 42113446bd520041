#include "image/exr_block.h"

#include <fmt/format.h>

#include <zlib.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "pvol/error.h"

namespace pvol::formats::detail {
namespace {

/// The bytes of the first block as they are stored, or none where it is not in the file: OpenEXR
/// finds that.
std::optional<std::vector<Bytef>> take_first_block(ByteSource& source, const ExrHeaders& headers) {
  ByteCursor table(source, {headers.end, source.size()}, "the table of blocks");
  const auto offset = table.value<std::uint64_t>();
  const std::uint64_t place = (headers.several ? 4 : 0) + (headers.parts.front().tiled ? 16 : 4);
  if (offset < headers.end || offset > source.size()) return std::nullopt;
  ByteCursor block(source, {offset, source.size()}, "the first block of pixels");
  block.skip(place);
  const auto size = block.value<std::uint32_t>();
  if (size > block.left()) return std::nullopt;
  std::vector<Bytef> bytes(size);
  block.copy(reinterpret_cast<char*>(bytes.data()), size);
  return bytes;
}

}  // namespace

void check_first_block(ByteSource& source, const ExrHeaders& headers) {
  const ExrPart& p = headers.parts.front();
  if (!p.zipped || p.subsampled) return;
  const std::optional<std::vector<Bytef>> stored = take_first_block(source, headers);
  const std::int64_t width = p.tiled ? std::min(p.tile_width, p.width) : p.width;
  const std::int64_t rows = std::min(p.tiled ? p.tile_height : p.block_rows, p.height);
  const std::uint64_t expected = std::uint64_t(width * rows) * p.pixel_bytes;
  constexpr std::uint64_t kBestRatio = 1032;          // of zlib
  if (!stored || stored->size() == expected) return;  // the latter is not compressed
  uLongf found = 0;
  if (expected / kBestRatio <= stored->size()) {
    std::vector<Bytef> plain(expected);
    found = expected;
    if (::uncompress(plain.data(), &found, stored->data(), stored->size()) != Z_OK) found = 0;
  }
  if (found == expected) return;
  throw Error(
      fmt::format("{}: its first pixels do not fill {} bytes, as its header says; the file "
                  "is damaged",
                  source.file().string(), expected));
}

}  // namespace pvol::formats::detail
