// The rows of a deep EXR file, unpacked.
#pragma once

#include <filesystem>
#include <vector>

#include "file/byte_source.h"
#include "image/exr_header.h"

namespace pvol::formats::detail {

/// A row of pixels with several samples each.
struct DeepBlock {
  std::vector<std::uint32_t> ends;  ///< of each pixel's samples, as a number of the row's
  std::vector<char> samples;        ///< of the row's samples the first channel, then the next
};

/// Deep scanlines of one part, with zips or without compression. What a block says of its size is
/// compared with the file, and with what it unpacks to, before memory is taken for it.
class DeepBlocks {
 public:
  /// Throws Error, which names the file, for what is no such file, is damaged or too large: beyond
  /// the limits of check_exr_file.
  explicit DeepBlocks(const std::filesystem::path& file);

  /// The row of this number from the top, whose coordinate is `y`; valid until the next call.
  /// Throws Error, which names the file, where it is damaged.
  const DeepBlock& read(std::size_t row, int y);

 private:
  ByteSource source_;
  ExrHeaders headers_;
  std::vector<char> packed_, unpacked_;
  DeepBlock block_;

  [[nodiscard]] const ExrPart& part() const { return headers_.parts.front(); }
  void unpack(ByteCursor& cursor, std::uint64_t packed, std::uint64_t size, std::vector<char>& to);
};

}  // namespace pvol::formats::detail
