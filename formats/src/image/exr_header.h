// What the headers of an EXR file announce, read and checked without OpenEXR, which takes memory
// for whatever they say.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "file/byte_source.h"

namespace pvol::formats::detail {

/// How the pixels of a block are packed. The others find for themselves where a block is too short.
enum class ExrPacking { none, runs, zip, other };

/// A part of a file: most files have one.
struct ExrPart {
  std::int64_t width = 0, height = 0;            ///< of the data window; 0: it has none
  std::int64_t tile_width = 0, tile_height = 0;  ///< 0: it does not say
  std::int64_t block_rows = 16;   ///< compressed together where there are no tiles; zip by default
  std::uint64_t pixel_bytes = 0;  ///< of all channels together
  ExrPacking packing = ExrPacking::zip;
  bool subsampled = false;  ///< some channel has fewer samples than there are pixels
  bool tiled = false;
  bool deep = false;  ///< pixels have several samples each
};

struct ExrHeaders {
  std::vector<ExrPart> parts;  ///< at least one
  bool several = false;        ///< the file may have several parts: then each block has its number
  std::uint64_t end = 0;       ///< where the tables of blocks begin
};

/// How many parts are read as one film: the first and, where all are scanlines of one sample each,
/// those after it.
[[nodiscard]] std::size_t film_parts(const ExrHeaders& headers);

/// Walks the headers of all parts: what is read here lies in the file and has the size that it
/// says. Throws Error for what is no EXR file, is damaged or cut off.
[[nodiscard]] ExrHeaders read_exr_headers(ByteSource& source);

}  // namespace pvol::formats::detail
